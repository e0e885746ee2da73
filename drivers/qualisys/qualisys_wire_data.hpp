/// @file  One frame of the Qualisys real-time protocol: rigid bodies and time code of a data packet, in SI.
/// The layout is the same from protocol 1.8 to 1.28. Source: QTM RT Protocol documentation, "Data packet".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"

namespace motionlab::qualisys {

/// The most bodies that a frame of ours can hold.
inline constexpr std::size_t kMaxBodies = 64;
/// A body further from the origin than this is no measurement.
inline constexpr double kPositionLimit_m = 1000.0;
/// Greatest deviation of any element of RᵀR from the identity that still counts as a rotation: single
/// precision gives 1e-6, a wrong layout or units give 1.
inline constexpr double kRotationTolerance = 1e-3;
/// Times beyond this (146 years) are refused, so that no arithmetic on them can overflow.
inline constexpr std::uint64_t kTimeLimit_ns = std::uint64_t{1} << 62;

/// Where the cameras see one body, in the camera system's global frame.
struct BodyPose {
  bool tracked = false;  ///< false: any value on the wire was not finite; the rest is zero and means nothing
  std::array<double, 3> p_camera_body_m{};
  std::array<double, 4> q_camera_body{};  ///< unit quaternion w, x, y, z with w >= 0
  double residual_m = 0.0;                ///< 0 when the component has none (6D)

  bool operator==(const BodyPose&) const = default;
};

struct SmpteTime {
  std::uint32_t hours{}, minutes{}, seconds{}, frame{}, sub_frame{};
  bool operator==(const SmpteTime&) const = default;
};
struct IrigTime {
  std::uint32_t year{}, day_of_year{}, hours{}, minutes{}, seconds{}, tenths{};
  bool operator==(const IrigTime&) const = default;
};
/// Since power-up of the master camera, or since 1970 when the cameras follow a PTP master. Steps of 100 ns.
struct CameraTime {
  Nanoseconds since_epoch{};
  bool operator==(const CameraTime&) const = default;
};
using Timecode = std::variant<SmpteTime, IrigTime, CameraTime>;

/// One frame as it came.
struct DataFrame {
  std::uint64_t timestamp_us = 0;  ///< since an unknown start that changes with every measurement
  std::uint32_t frame_number = 0;  ///< gaps are normal
  bool has_bodies = false;         ///< the packet carried rigid bodies (6D or 6DRes)
  double drop_rate = 0.0;          ///< share of camera data lost between cameras and server, 0…1
  double out_of_sync_rate = 0.0;   ///< share of camera data out of sync, 0…1
  std::size_t body_count = 0;
  std::array<BodyPose, kMaxBodies>
      body{};                        ///< in the order of the list in the XML; the first `body_count` count
  std::optional<Timecode> timecode;  ///< camera time if there is one, else the first kind given

  [[nodiscard]] std::span<const BodyPose> bodies() const noexcept { return {body.data(), body_count}; }
  bool operator==(const DataFrame&) const = default;
};

/// Which components a client asked for.
struct Components {
  bool bodies = false;                ///< `6D`
  bool bodies_with_residual = false;  ///< `6DRes`
  bool timecode = false;              ///< `Timecode`

  [[nodiscard]] bool any() const noexcept { return bodies || bodies_with_residual || timecode; }
  bool operator==(const Components&) const = default;
};

/// Reads the payload of a data packet. Components of other types are passed over by their size; of 6D and
/// 6DRes in one packet the latter is kept.
///
/// @param payload  behind the 8-byte packet header
/// Faults: too_short, too_long (bytes behind the last component, or more bodies than kMaxBodies), bad_header
/// (sizes and counts that contradict each other, a component twice), bad_value (a time or position outside
/// what can be, a matrix that is no rotation). A rate above 1 is cut to 1. Never throws or allocates. Source:
/// QTM RT Protocol documentation, "6D component", "6D with residual", "Timecode component".
[[nodiscard]] Result<DataFrame> decode_data(Bytes payload) noexcept;

/// Writes a whole data packet, header included, with the components asked for.
/// A body that is not tracked has all bits set in every float. @returns the bytes written, inside `out`.
/// Faults: too_long when `out` is too small.
[[nodiscard]] Result<Bytes> encode_data(const DataFrame& frame, const Components& components,
                                        MutableBytes out) noexcept;

}  // namespace motionlab::qualisys
