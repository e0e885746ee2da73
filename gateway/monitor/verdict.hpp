/// @file  How the gateway took a request, read from its mode: requests have no answer of their own.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "idl/mode.hpp"
#include "idl/mode_request.hpp"

namespace motionlab::monitor {

enum class Outcome {
  pending,  ///< not yet; ask again
  granted,
  refused  ///< the sentence says why
};

struct Verdict {
  Outcome outcome;
  std::string sentence;
};

/// Judges a settle, engage or reset.
/// @param action  one of these three; any other is refused
/// @param before  the mode when the first request left; nothing when none had been heard
/// @param now     the newest mode
/// @param requester  who asks, as in the request
///
/// The gateway says no by publishing its state once more, with a code and a reason. A settle is granted as
/// soon as nothing can be commanded; a latched fault refuses it, because the gateway stopped by itself and
/// stays so.
[[nodiscard]] Verdict judge(topic::ModeAction action, const std::optional<topic::Mode>& before,
                            const topic::Mode& now, std::string_view requester);

/// Judges a request for another authority: granted when the mode shows it, refused when the gateway says that
/// it is.
[[nodiscard]] Verdict judge_authority(topic::Authority wanted, const std::optional<topic::Mode>& before,
                                      const topic::Mode& now);

}  // namespace motionlab::monitor
