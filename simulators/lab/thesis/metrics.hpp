/// @file  What a run of the thesis' world amounts to.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gateway/math/crane_arm.hpp"
#include "gateway/monitor/report.hpp"
#include "simulators/lab/thesis/scenario.hpp"
#include "simulators/lab/thesis/simulation.hpp"

namespace motionlab::thesis {

/// rms and maxima over all milliseconds. Errors are position minus set point.
struct Metrics {
  std::uint64_t samples = 0;
  bool finite = true;  ///< the state never left the finite numbers
  std::array<double, 2> swing_axis_rms_deg{}, swing_axis_max_deg{};
  double tool_rms_m = 0;     ///< in the robot's axes
  double tool_rms_xy_m = 0;  ///< horizontal part of it
  double tool_world_rms_m = 0;
  double load_rms_m = 0, load_rms_xy_m = 0, load_rms_z_m = 0;  ///< in world
  double settle_1deg_s = 0;      ///< longest time from an event until both angles are within 1 deg for good
  bool settle_censored = false;  ///< in one case the next event or the end came first
  double command_max_mps2 = 0;   ///< largest component
  double command_rms_mps2 = 0;   ///< of the components
  std::array<double, 3> joint_speed_max_degps{};  ///< of the samples within reach
  std::array<double, 3> joint_min_deg{}, joint_max_deg{};
  double reach_max_m = 0;             ///< farthest from the shoulder
  bool reach_ok = true;               ///< always a place where the arm can be
  double angle_estimate_rms_deg = 0;  ///< error of the estimated swing angles
};

/// Collects `Metrics` of one run. Samples before `from_s` are left out of the statistics.
class MetricsCollector {
 public:
  MetricsCollector(const Run& run, double from_s = 0);
  void take(const Sample& sample);
  [[nodiscard]] Metrics metrics() const;

 private:
  void take_arm(const Sample& sample);

  std::int64_t from_ms_;
  bool arm_;  ///< there is one
  math::CraneArm kinematics_;
  std::vector<std::int64_t> events_ms_;
  std::size_t event_ = 0;         ///< the one whose time runs
  std::int64_t outside_ms_ = -1;  ///< last sample of it outside 1 deg
  std::int64_t last_ms_ = -1;
  double settle_s_ = 0;
  bool censored_ = false;
  Metrics sums_;  ///< squares where rms will stand
};

/// Runs and measures.
[[nodiscard]] Metrics measure(const Run& run, double from_s = 0);

/// Runs it and its uncontrolled twin, and reports in the words of `motionlab-study`. Scored from 0; the twin
/// starts as the run does and is without friction, too.
[[nodiscard]] monitor::Report report(const Run& run);

}  // namespace motionlab::thesis
