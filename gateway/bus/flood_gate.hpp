/// @file  The door for what anybody may ask of the control step: as much passes as a step can take.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "drivers/core/text.hpp"
#include "drivers/core/time.hpp"
#include "idl/mode_request.hpp"
#include "idl/reference.hpp"

namespace motionlab::bus {

/// The time in which a gate counts. It begins with the first sample after the last one has ended.
inline constexpr Nanoseconds kGateWindow = 10ms;

/// What passed of each requester in this window; of so many of them as are told apart.
class GateWindow {
 public:
  using Time = std::chrono::steady_clock::time_point;
  static constexpr std::size_t kRequesters = 64;

  /// @returns whether a new window begins at `now`
  bool begin(Time now) noexcept;
  [[nodiscard]] Time end() const noexcept { return end_; }
  /// How many passed of this requester. Nothing when there are too many requesters to tell.
  [[nodiscard]] std::optional<std::size_t> passed_of(const Text<32>& requester) const noexcept;
  /// Counts one more. The requester is known, or there is room.
  void count(const Text<32>& requester) noexcept;
  [[nodiscard]] std::size_t passed() const noexcept { return passed_; }

 private:
  struct Entry {
    Text<32> requester;
    std::size_t passed = 0;
  };
  std::array<Entry, kRequesters> entries_{};
  std::size_t known_ = 0;
  std::size_t passed_ = 0;
  Time end_ = Time::min();
};

/// Requests: in a window 32 pass, at most 16 of one requester (what DDS keeps of him), and 16 more of those
/// of whom nothing has passed yet, so that one who shouts does not silence the others.
///
/// A settle passes at once whatever was spent, unless its requester's turns are spent and the last that
/// passed in this window was a settle too: that one has done its work. Should nothing else pass it is handed
/// on when the window ends, so that a settle is always the last word of whoever said it last. One thread.
class RequestGate {
 public:
  using Time = GateWindow::Time;
  static constexpr std::size_t kForAll = 32, kForOne = 16, kForNewcomers = 16;

  /// @returns whether the sample passes now
  [[nodiscard]] bool passes(const topic::ModeRequest& request, Time now) noexcept;
  /// What was held and may pass now, one a call.
  [[nodiscard]] std::optional<topic::ModeRequest> held(Time now) noexcept;
  /// When something that is held may pass; the end of time when nothing is.
  [[nodiscard]] Time due() const noexcept { return settle_ ? window_.end() : Time::max(); }
  /// Samples that will never pass.
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }

 private:
  GateWindow window_;
  bool settled_last_ = false;  ///< the last that passed in this window was a settle
  std::optional<topic::ModeRequest> settle_;
  std::uint64_t refused_ = 0;
};

/// References: one in a window, and when it ends the last one that came: the last one told holds, whoever
/// tells it, and that one is never lost. One thread.
class ReferenceGate {
 public:
  using Time = GateWindow::Time;

  /// As RequestGate.
  [[nodiscard]] bool passes(const topic::Reference& reference, Time now) noexcept;
  [[nodiscard]] std::optional<topic::Reference> held(Time now) noexcept;
  [[nodiscard]] Time due() const noexcept { return newest_ ? window_.end() : Time::max(); }
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }

 private:
  GateWindow window_;
  std::optional<topic::Reference> newest_;
  std::uint64_t refused_ = 0;
};

/// For topics that cost a control step nothing: all passes.
template <class T>
class OpenGate {
 public:
  using Time = GateWindow::Time;
  [[nodiscard]] static bool passes(const T&, Time) noexcept { return true; }
  [[nodiscard]] static std::optional<T> held(Time) noexcept { return std::nullopt; }
  [[nodiscard]] static Time due() noexcept { return Time::max(); }
  [[nodiscard]] static std::uint64_t refused() noexcept { return 0; }
};

/// The gate at a topic's door.
template <class T>
using GateOf =
    std::conditional_t<std::is_same_v<T, topic::ModeRequest>, RequestGate,
                       std::conditional_t<std::is_same_v<T, topic::Reference>, ReferenceGate, OpenGate<T>>>;

}  // namespace motionlab::bus
