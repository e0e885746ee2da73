/// @file  Seapath binary 23: 44 bytes, big-endian; 2^14 counts are 90 deg, heave + down, UTC, CRC-16.
///
/// Sources: Seapath 320 manual p. 101; the public driver SeawardScience/seapath.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire_motion.hpp"

namespace motionlab::mru::bin23 {

inline constexpr std::size_t kSize = 44;

/// Status bits: a subject has reduced performance; the next higher bit says that it is invalid.
enum Status : std::uint16_t {
  kPositionReduced = 1u << 0,
  kPositionInvalid = 1u << 1,
  kHeaveReduced = 1u << 2,
  kHeaveInvalid = 1u << 3,
  kRollPitchReduced = 1u << 4,
  kRollPitchInvalid = 1u << 5,
  kHeadingReduced = 1u << 6,
  kHeadingInvalid = 1u << 7,
};

/// One datagram in the wire's units. 90 deg are 2^14 counts, of a position 2^30.
struct Frame {
  std::int32_t utc_s = 0;              ///< since 1970, without leap seconds
  std::uint16_t utc_tenths_of_ms = 0;  ///< 0 to 9999
  std::int32_t latitude_counts = 0;
  std::int32_t longitude_counts = 0;
  std::int32_t height_up_cm = 0;
  std::int16_t heave_down_cm = 0;
  std::array<std::int16_t, 3> v_ned_cmps{};
  std::int16_t roll_counts = 0;
  std::int16_t pitch_counts = 0;
  std::uint16_t heading_counts = 0;
  std::array<std::int16_t, 3> rate_counts{};  ///< roll, pitch, yaw, per second
  std::uint16_t status = 0;
  bool crc_good = true;  ///< whether the CRC matched; not used by `encode`
};

/// CRC-16/X-25: reflected polynomial 0x8408, start 0xFFFF, inverted at the end.
[[nodiscard]] std::uint16_t crc(Bytes bytes) noexcept;

/// Faults: too_short, too_long, bad_header, bad_value (a second has more than 9999 tenths of a millisecond).
/// A CRC that does not match is no fault here: see `Frame::crc_good`. Never throws or allocates.
[[nodiscard]] Result<Frame> decode(Bytes datagram) noexcept;
/// @returns the bytes written, the right CRC included, or too_short when `to` has no room
[[nodiscard]] Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept;

[[nodiscard]] Motion motion_of(const Frame& frame) noexcept;
/// What of a motion the format can carry; the position stays 0.
/// @param t_utc  since 1970
[[nodiscard]] Frame frame_of(const Motion& motion, Nanoseconds t_utc) noexcept;

}  // namespace motionlab::mru::bin23
