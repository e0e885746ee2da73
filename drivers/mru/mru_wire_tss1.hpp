/// @file  TSS1: one line of 27 characters, `:aabbbb shhhhQsrrrr spppp` CR LF. Hippy roll, heave and vertical
/// acceleration + up, no time, no checksum.
///
/// Sources: Kongsberg EK80 help; Seapath 320 manual p. 104; two published lines (NCEI accession 0086548,
/// NovAtel's TSS1 page).
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire_motion.hpp"

namespace motionlab::mru::tss1 {

inline constexpr std::size_t kSize = 27;

/// What helps the unit; a lower-case letter on the wire says that it is not settled.
enum class Aiding : char { none = 'U', speed = 'G', heading = 'H', full = 'F' };

/// One line in the wire's units.
struct Frame {
  std::uint8_t a_sway_counts = 0;  ///< of 0.03835 m/s2, without a sign
  std::int16_t a_up_counts = 0;    ///< of 0.000625 m/s2, + up
  std::int16_t heave_up_cm = 0;    ///< within +-9999, + up
  Aiding aiding = Aiding::none;
  bool settled = true;
  std::int16_t roll_cdeg = 0;   ///< within +-9999, Hippy type, + port up
  std::int16_t pitch_cdeg = 0;  ///< within +-9999, + bow up
};

/// Faults: too_short, too_long, bad_header (a character that this format does not have in that place).
/// Never throws or allocates.
[[nodiscard]] Result<Frame> decode(Bytes line) noexcept;
/// @returns the bytes written, or too_short when `to` has no room. Beyond +-9999 stands +9999.
[[nodiscard]] Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept;

/// The sway acceleration has no sign and is left out.
[[nodiscard]] Motion motion_of(const Frame& frame) noexcept;
[[nodiscard]] Frame frame_of(const Motion& motion) noexcept;

}  // namespace motionlab::mru::tss1
