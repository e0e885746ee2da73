/// @file  Simrad EM3000 attitude and its older brother EM1000: 10 bytes, little-endian; 0.01 deg, cm, heave
/// + up, no time, no checksum. They differ in the first byte and in the type of roll.
///
/// Sources: Kongsberg EK80 help, page on EM attitude; Seapath 200 manual p. 55. A resolution of a centimetre
/// and a hundredth of a degree, without rates: enough to look at, too little to keep a load still.
#pragma once

#include <cstddef>
#include <cstdint>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire_motion.hpp"

namespace motionlab::mru::em3000 {

inline constexpr std::size_t kSize = 10;

/// First byte. What lies between is valid but reduced, or not valid although the unit runs.
enum Status : std::uint8_t {
  kEm1000 = 0x00,  ///< no status: this is EM1000
  kNormal = 0x90,
  kFirstReduced = 0x91,
  kFirstInvalid = 0x9A,  ///< e.g. calibrating
  kFirstError = 0xA0,
  kLastError = 0xAF,
};

/// One datagram in the wire's units.
struct Frame {
  std::uint8_t status = kNormal;
  std::int16_t roll_cdeg = 0;    ///< + port up; Hippy type in EM1000
  std::int16_t pitch_cdeg = 0;   ///< + bow up
  std::int16_t heave_up_cm = 0;  ///< + up
  std::uint16_t heading_cdeg = 0;
};

/// Faults: too_short, too_long, bad_header (the second byte, or a status that does not exist). Never throws.
[[nodiscard]] Result<Frame> decode(Bytes datagram) noexcept;
/// @returns the bytes written, or too_short when `to` has no room
[[nodiscard]] Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept;

/// Roll or pitch out of the format's range is the unit's word for invalid: not a motion, bad_value. Heave or
/// heading out of range is NaN.
[[nodiscard]] Result<Motion> motion_of(const Frame& frame) noexcept;
/// @param format  em3000 or em1000
[[nodiscard]] Frame frame_of(const Motion& motion, Format format) noexcept;

}  // namespace motionlab::mru::em3000
