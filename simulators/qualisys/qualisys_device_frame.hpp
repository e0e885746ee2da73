/// @file  From what the cameras saw to the frame that QTM sends of it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "drivers/core/time.hpp"
#include "drivers/qualisys/qualisys_wire_data.hpp"
#include "drivers/qualisys/qualisys_wire_xml.hpp"

namespace motionlab::qualisys {

class DeviceFaults;

/// One body of a physical measurement, in the camera system's global frame.
struct MeasuredBody {
  std::string name;
  bool tracked = false;
  std::array<double, 3> p_camera_body_m{};
  std::array<double, 4> q_camera_body{1.0, 0.0, 0.0, 0.0};  ///< unit quaternion w, x, y, z
  double residual_m = 0.0;
};

/// One marker that has a label, likewise.
struct MeasuredMarker {
  std::string label;
  bool tracked = false;
  std::array<double, 3> p_camera_marker_m{};
  double residual_m = 0.0;
};

/// What the cameras saw in one exposure. Bodies and labels of the device's lists that are not here are lost.
struct CameraFrame {
  std::vector<MeasuredBody> bodies{};
  std::vector<MeasuredMarker> markers{};
  std::vector<UnlabelledMarker> unlabelled{};
  double drop_rate = 0.0;         ///< 0…1
  double out_of_sync_rate = 0.0;  ///< 0…1
};

enum class TimecodeSource : std::uint8_t { none, smpte, irig, camera };

/// The time code of an exposure. SMPTE has 30 frames of 80 sub-frames a second; it and IRIG tell UTC.
[[nodiscard]] std::optional<Timecode> timecode_of(TimecodeSource source, LabTime t_exposure,
                                                  double camera_time_offset_s);

/// Bodies, angles and markers of a frame; its number and times are the caller's.
/// @param wrong_by_m  added to every position
[[nodiscard]] DataFrame frame_of(const CameraFrame& seen, std::span<const BodyDefinition> bodies,
                                 std::span<const std::string> labels, const DeviceFaults& faults,
                                 double wrong_by_m);

}  // namespace motionlab::qualisys
