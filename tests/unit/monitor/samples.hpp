/// @file  Samples whose numbers are known in closed form.
#pragma once

#include <cmath>
#include <numbers>

#include "drivers/core/time.hpp"
#include "idl/control.hpp"
#include "idl/mode.hpp"
#include "idl/truth_world.hpp"

namespace motionlab::monitor {

inline constexpr double kRadPerDeg = std::numbers::pi / 180.0;
inline constexpr std::array<double, 3> kLoadSet{0.847625, -0.407825, 3.919269};
inline constexpr std::array<double, 3> kToolSet{0.847625, -0.407825, 5.919269};

inline LabTime at(double t_s) {
  return LabTime{} + from_seconds(t_s);
}

/// Load and twin plumb at their set points.
inline topic::TruthWorld still(double t_s) {
  topic::TruthWorld truth;
  truth.t_ns = to_ns(at(t_s));
  truth.p_world_load_m = truth.p_world_twin_load_m = kLoadSet;
  truth.p_world_tool_m = truth.p_world_twin_tool_m = kToolSet;
  truth.wire_length_m = 2;
  return truth;
}

inline topic::Mode mode(topic::ModeState state, double t_s, std::string_view code = "") {
  topic::Mode mode;
  mode.state = state;
  mode.t_changed_ns = to_ns(at(t_s));
  mode.fault_latched = state == topic::ModeState::fault;
  mode.fault_code = code;
  return mode;
}

inline topic::Control control(double t_s, double qd_radps) {
  topic::Control control;
  control.t_snapshot_ns = to_ns(at(t_s));
  control.following = true;
  control.qd_command_radps.fill(qd_radps);
  return control;
}

}  // namespace motionlab::monitor
