/// @file  One frame of the Qualisys real-time protocol: bodies, markers and time code of a data packet, in
/// SI. The layout is the same from protocol 1.8 to 1.28 and the byte order that of the port. Source: QTM RT
/// Protocol documentation, "Data packet".
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"
#include "drivers/qualisys/qualisys_wire_component.hpp"

namespace motionlab::qualisys {

/// The most bodies that a frame of ours can hold.
inline constexpr std::size_t kMaxBodies = 64;
/// The most markers of each kind (labelled, unlabelled) that a frame of ours can hold.
inline constexpr std::size_t kMaxMarkers = 256;
/// A body or marker further from the origin than this is no measurement.
inline constexpr double kPositionLimit_m = 1000.0;
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

/// The same body with its orientation as three angles, whose definition is a setting of the QTM project
/// (qualisys_wire_rotation.hpp has the usual one). Good for checking the matrix, not for control.
struct BodyAngles {
  bool tracked = false;
  std::array<double, 3> p_camera_body_m{};
  std::array<double, 3> angles_rad{};
  double residual_m = 0.0;

  bool operator==(const BodyAngles&) const = default;
};

/// A marker that QTM has a label for.
struct Marker {
  bool tracked = false;
  std::array<double, 3> p_camera_marker_m{};
  double residual_m = 0.0;

  bool operator==(const Marker&) const = default;
};

/// A marker without a label: there or not, never lost.
struct UnlabelledMarker {
  std::array<double, 3> p_camera_marker_m{};
  std::uint32_t id = 0;  ///< follows one trajectory from frame to frame
  double residual_m = 0.0;

  bool operator==(const UnlabelledMarker&) const = default;
};

struct SmpteTime {
  std::uint32_t hours{}, minutes{}, seconds{}, frame{}, sub_frame{};  ///< sub-frame: 1.27 and later
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

/// At most N things of one frame; the first `size` count.
template <class T, std::size_t N>
struct Items {
  std::array<T, N> all{};
  std::size_t size = 0;

  [[nodiscard]] std::span<const T> view() const noexcept { return {all.data(), size}; }
  bool operator==(const Items& other) const noexcept {
    return std::equal(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(size), other.all.begin(),
                      other.all.begin() + static_cast<std::ptrdiff_t>(other.size));
  }
};

/// One frame, or that part of it which one packet carries.
struct DataFrame {
  std::uint64_t timestamp_us = 0;  ///< since an unknown start that changes with every measurement
  std::uint32_t frame_number = 0;  ///< gaps are normal
  double drop_rate = 0.0;          ///< share of camera data lost between cameras and server, 0…1
  double out_of_sync_rate = 0.0;   ///< share of camera data out of sync, 0…1
  Components present;              ///< what the packet carried; of the kinds below, only those mean something

  Items<BodyPose, kMaxBodies> bodies;               ///< in the order of the list in the XML
  Items<BodyAngles, kMaxBodies> angles;             ///< likewise
  Items<Marker, kMaxMarkers> markers;               ///< in the order of the labels in the XML
  Items<UnlabelledMarker, kMaxMarkers> unlabelled;  ///< in no order
  std::optional<Timecode> timecode;  ///< camera time if there is one, else the first kind given

  [[nodiscard]] bool has_bodies() const noexcept {
    return present.has(Component::bodies) || present.has(Component::bodies_res);
  }
  [[nodiscard]] bool has_angles() const noexcept {
    return present.has(Component::angles) || present.has(Component::angles_res);
  }
  [[nodiscard]] bool has_unlabelled() const noexcept {
    return present.has(Component::unlabelled) || present.has(Component::unlabelled_res);
  }
  [[nodiscard]] const CameraTime* camera_time() const noexcept {
    return timecode ? std::get_if<CameraTime>(&*timecode) : nullptr;
  }
  bool operator==(const DataFrame&) const = default;
};

/// Reads the payload of a data packet. Components whose layout is not known here are passed over by their
/// size; of one with and one without residual in one packet the former is kept.
///
/// @param payload  behind the 8-byte packet header
/// Faults: too_short, too_long (bytes behind the last component, or more items than a frame of ours holds),
/// bad_header (sizes and counts that contradict each other, a component twice), bad_value (a time or position
/// outside what can be, a matrix that is no rotation). A rate above 1 is cut to 1; an unlabelled marker that
/// is not finite is left out. Never throws or allocates. Source: QTM RT Protocol documentation, "3D
/// component" … "Timecode component".
[[nodiscard]] Result<DataFrame> decode_data(Bytes payload, std::endian order = std::endian::little) noexcept;

/// Writes a whole data packet, header included, with those of the components asked for that this codec knows,
/// in the order of their numbers; the time code only when the frame has one. `frame.present` is not looked
/// at. What is not tracked has all bits set in every float. @returns the bytes written, inside `out`. Faults:
/// too_long when `out` is too small.
[[nodiscard]] Result<Bytes> encode_data(const DataFrame& frame, const Components& components,
                                        MutableBytes out, std::endian order = std::endian::little) noexcept;

}  // namespace motionlab::qualisys
