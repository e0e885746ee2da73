/// @file  The faults that only a camera system has. What they do stands with what they disturb.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace motionlab::qualisys {

/// Which of the device's own faults are on, and with what value.
///
///  silent              nothing is sent any more, connections stay open
///  occlude             nothing is tracked
///  occlude:<body>      this body is not tracked
///  residual            the fit of everything is worse by this; value: m (0.005)
///  drop_rate           QTM says that it loses this share of the cameras' data; value: 0…1 (0.5)
///  out_of_sync         likewise of data out of sync
///  skip_frames         of so many frames only one is processed, numbers tell; value: n (2)
///  stop_measurement    the measurement is stopped; a new one begins when the fault ends
///  calibrate           QTM calibrates; when the fault ends it previews again
///  restart             QTM was quit; it is started again when the fault ends
///  restart_timestamp   once: time stamps and frame numbers begin again, unannounced
///  stuck_frame_number  the frame number is always 1
///  close_mid_frame     once: every connection ends in the middle of a packet
///  half_open           connections carry nothing either way and nobody is told; datagrams go on
///  no_state            GetState is not answered
///  split_header        each packet on a connection comes in two pieces, the first inside its header
///  split_frame         each component comes in a datagram of its own
///  oversize            each datagram has one byte too many
///  old_version         another QTM: its newest protocol is 1.n; value: n (20)
///  body_list_change    a body is added before the others; value 0: announced by an event, else silently
///  matrix_by_rows      orientations are written row by row
///  other_angles        the project defines its Euler angles otherwise
class DeviceFaults {
 public:
  static constexpr std::string_view kNames =
      "unknown fault; known are off, stuck, garbage, wrong, slow, delayed, intermittent, silent, occlude, "
      "occlude:<body>, residual, drop_rate, out_of_sync, skip_frames, stop_measurement, calibrate, restart, "
      "restart_timestamp, stuck_frame_number, close_mid_frame, half_open, no_state, split_header, "
      "split_frame, "
      "oversize, old_version, body_list_change, matrix_by_rows, other_angles";

  /// The names of the device's own faults but for `occlude:<body>`.
  [[nodiscard]] static std::vector<std::string_view> names();
  [[nodiscard]] static bool knows(std::string_view name) noexcept;
  /// Switches a fault. A value of 0 is the default. @returns whether that changed whether it is on
  bool set(std::string_view name, bool active, double value);
  void set_occluded(std::string_view body, bool active);

  [[nodiscard]] bool is_on(std::string_view name) const noexcept { return values_.contains(name); }
  [[nodiscard]] std::optional<double> value(std::string_view name) const noexcept;
  [[nodiscard]] bool occludes(std::string_view body) const noexcept;
  [[nodiscard]] bool occludes_all() const noexcept { return is_on("occlude"); }

 private:
  std::map<std::string, double, std::less<>> values_;
  std::set<std::string, std::less<>> occluded_;
};

}  // namespace motionlab::qualisys
