/// @file  KM Binary (`#KMB`): 132 bytes, little-endian, packed; degrees, heave + down, UTC, no checksum.
///
/// Source: Kongsberg EK80 help, page "KM Binary datagram format". The Euler type of its roll is taken from
/// the maker's other formats, not from that page.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/mru/mru_wire_motion.hpp"

namespace motionlab::mru::km {

inline constexpr std::size_t kSize = 132;

/// Status bits: data of a subject are invalid. The same bit shifted by `kReduced` says reduced performance.
enum Status : std::uint32_t {
  kPosition = 1u << 0,  ///< horizontal position and velocity
  kRollPitch = 1u << 1,
  kHeading = 1u << 2,
  kHeave = 1u << 3,  ///< heave and vertical velocity
  kAcceleration = 1u << 4,
  kDelayedHeave = 1u << 5,
};
inline constexpr unsigned kReduced = 16;

/// One datagram in the wire's units. Heights are + up, everything else vertical is + down.
struct Frame {
  std::uint32_t utc_s = 0, utc_ns = 0;
  std::uint32_t status = 0;
  double latitude_deg = 0.0, longitude_deg = 0.0;
  float height_up_m = 0.0F;
  std::array<float, 3> roll_pitch_heading_deg{};
  float heave_down_m = 0.0F;
  std::array<float, 3> rates_degps{};
  std::array<float, 3> v_ned_mps{};
  std::array<float, 3> position_error_m{};  ///< latitude, longitude, height; -1: not implemented
  std::array<float, 3> roll_pitch_heading_error_deg{};
  float heave_error_m = 0.0F;
  std::array<float, 3> a_ned_mps2{};
  std::uint32_t delayed_utc_s = 0, delayed_utc_ns = 0;
  float delayed_heave_down_m = 0.0F;
};

/// Faults: too_short, too_long, bad_header (name, length, version), bad_value (a number is not finite, or a
/// second has more than 1e9 ns). Never throws or allocates.
[[nodiscard]] Result<Frame> decode(Bytes datagram) noexcept;
/// @returns the bytes written, or too_short when `to` has no room. NaN is sent as it is.
[[nodiscard]] Result<Bytes> encode(const Frame& frame, MutableBytes to) noexcept;

[[nodiscard]] Motion motion_of(const Frame& frame) noexcept;
/// What of a motion the format can carry; the position stays 0, delayed heave is marked as invalid.
/// @param t_utc  since 1970
[[nodiscard]] Frame frame_of(const Motion& motion, Nanoseconds t_utc) noexcept;

}  // namespace motionlab::mru::km
