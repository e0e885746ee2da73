#include "simulators/qualisys/qualisys_device_frame.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "drivers/qualisys/qualisys_wire_rotation.hpp"
#include "drivers/qualisys/qualisys_wire_text.hpp"
#include "simulators/qualisys/qualisys_device_faults.hpp"

namespace motionlab::qualisys {

namespace {

template <class Count>
std::uint32_t word(Count count) {
  return static_cast<std::uint32_t>(count);
}

SmpteTime smpte(Nanoseconds since_midnight) {
  constexpr std::int64_t kSubFramesPerSecond = 30 * 80;
  const std::int64_t whole = since_midnight / 1s;
  const std::int64_t sub_frames = (since_midnight % 1s).count() * kSubFramesPerSecond / 1'000'000'000;
  return {word(whole / 3600), word(whole / 60 % 60), word(whole % 60), word(sub_frames / 80),
          word(sub_frames % 80)};
}

IrigTime irig(LabTime t) {
  using namespace std::chrono;
  const sys_days today{floor<days>(t.time_since_epoch())};
  const year_month_day date{today};
  const auto since_midnight = t.time_since_epoch() - today.time_since_epoch();
  const std::int64_t whole = since_midnight / 1s;
  return {word(static_cast<int>(date.year()) % 100),
          word((today - sys_days{date.year() / January / 1}).count() + 1),
          word(whole / 3600),
          word(whole / 60 % 60),
          word(whole % 60),
          word(since_midnight % 1s / 100ms)};
}

/// Angles of another definition that a project may have: about the fixed axes.
std::array<double, 3> fixed_axis_angles(const Matrix& r) {
  return {std::atan2(r[2][1], r[2][2]), -std::asin(std::clamp(r[2][0], -1.0, 1.0)),
          std::atan2(r[1][0], r[0][0])};
}

std::array<double, 3> shifted(std::array<double, 3> p_m, double by_m) {
  for (double& p : p_m) p += by_m;
  return p_m;
}

}  // namespace

std::optional<Timecode> timecode_of(TimecodeSource source, LabTime t_exposure, double camera_time_offset_s) {
  switch (source) {
    case TimecodeSource::smpte:
      return smpte(t_exposure.time_since_epoch() % std::chrono::days{1});
    case TimecodeSource::irig:
      return irig(t_exposure);
    case TimecodeSource::camera:
      return CameraTime{t_exposure.time_since_epoch() + from_seconds(camera_time_offset_s)};
    case TimecodeSource::none:
      break;
  }
  return std::nullopt;
}

DataFrame frame_of(const CameraFrame& seen, std::span<const BodyDefinition> bodies,
                   std::span<const std::string> labels, const DeviceFaults& faults, double wrong_by_m) {
  DataFrame frame;
  frame.drop_rate = faults.value("drop_rate").value_or(seen.drop_rate);
  frame.out_of_sync_rate = faults.value("out_of_sync").value_or(seen.out_of_sync_rate);
  const double extra_residual_m = faults.value("residual").value_or(0.0);

  frame.bodies.size = frame.angles.size = std::min(bodies.size(), kMaxBodies);
  for (std::size_t i = 0; i < frame.bodies.size; ++i) {
    const auto body = std::find_if(seen.bodies.begin(), seen.bodies.end(),
                                   [&](const MeasuredBody& b) { return same_name(b.name, bodies[i].name); });
    if (body == seen.bodies.end() || !body->tracked || !bodies[i].enabled || faults.occludes(bodies[i].name))
      continue;
    const auto p_m = shifted(body->p_camera_body_m, wrong_by_m);
    const double residual_m = body->residual_m + extra_residual_m;
    const Matrix r = to_matrix(body->q_camera_body);
    const auto angles_rad = faults.is_on("other_angles") ? fixed_axis_angles(r) : to_angles(r);
    auto q = body->q_camera_body;
    if (faults.is_on("matrix_by_rows")) q = {q[0], -q[1], -q[2], -q[3]};
    frame.bodies.all[i] = {true, p_m, q, residual_m};
    frame.angles.all[i] = {true, p_m, angles_rad, residual_m};
  }

  frame.markers.size = std::min(labels.size(), kMaxMarkers);
  for (std::size_t i = 0; i < frame.markers.size; ++i) {
    const auto marker = std::find_if(seen.markers.begin(), seen.markers.end(),
                                     [&](const MeasuredMarker& m) { return m.label == labels[i]; });
    if (marker == seen.markers.end() || !marker->tracked || faults.occludes_all()) continue;
    frame.markers.all[i] = {true, shifted(marker->p_camera_marker_m, wrong_by_m),
                            marker->residual_m + extra_residual_m};
  }

  frame.unlabelled.size = faults.occludes_all() ? 0 : std::min(seen.unlabelled.size(), kMaxMarkers);
  for (std::size_t i = 0; i < frame.unlabelled.size; ++i) {
    UnlabelledMarker marker = seen.unlabelled[i];
    marker.p_camera_marker_m = shifted(marker.p_camera_marker_m, wrong_by_m);
    marker.residual_m += extra_residual_m;
    frame.unlabelled.all[i] = marker;
  }
  return frame;
}

}  // namespace motionlab::qualisys
