#include "drivers/winch/winch_driver_status.hpp"

#include <algorithm>
#include <limits>

namespace motionlab::winch {

topic::WinchState to_state(const PlcStatus& status, const AxisMap& axis) noexcept {
  const double a_m = axis.wire_length_m(status.position_min_m);
  const double b_m = axis.wire_length_m(status.position_max_m);
  const bool reversed = axis.pay_out_sign < 0;
  topic::WinchState state;
  state.drive_state = static_cast<topic::WinchDriveState>(status.state);
  state.ready = status.ready;
  state.enabled = status.enabled;
  state.error = status.error;
  state.homed = status.homed;
  state.at_lower_limit = reversed ? status.at_max : status.at_min;
  state.at_upper_limit = reversed ? status.at_min : status.at_max;
  state.wire_length_m = axis.wire_length_m(status.position_m);
  state.wire_speed_mps = axis.turned(status.velocity_mps);
  state.wire_length_set_m = axis.wire_length_m(status.set_position_m);
  state.wire_length_min_m = std::min(a_m, b_m);
  state.wire_length_max_m = std::max(a_m, b_m);
  state.motor_torque_nm = status.torque_nm;
  state.motor_temperature_degc = status.motor_temperature_degc;
  state.axis_error_id = status.axis_error_id;
  state.drive_diagnosis = status.drive_diagnosis;
  state.watchdog_trips = status.watchdog_trips;
  return state;
}

PlcStatus from_legacy(const LegacyStatus& status, LabTime t_asked, std::uint32_t heartbeat_echo,
                      double travel_m) noexcept {
  constexpr double kNearLimitM = 0.001;
  constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  PlcStatus ours;
  ours.cycle_count = status.cycle_count;
  ours.heartbeat_echo = heartbeat_echo;
  ours.t_plc = t_asked.time_since_epoch();
  ours.position_m = status.length_m;
  ours.velocity_mps = status.velocity_mps;
  ours.set_position_m = status.length_m;
  ours.torque_nm = kUnknown;
  ours.motor_temperature_degc = kUnknown;
  ours.position_max_m = travel_m;
  ours.axis_state = status.axis_state;
  ours.axis_error_id = status.axis_error_id;
  ours.error = (status.axis_state & axis_state::error) != 0 || status.axis_error_id != 0;
  ours.enabled = !ours.error && (status.axis_state & axis_state::external_generator) != 0;
  ours.state = ours.error                           ? PlcState::fault
               : !ours.enabled                      ? PlcState::off
               : status.mode == LegacyMode::settled ? PlcState::hold
                                                    : PlcState::velocity;
  ours.ready = !ours.error;
  ours.communication_ok = true;
  ours.homed = (status.axis_state & axis_state::homed) != 0;
  ours.at_min = status.length_m <= kNearLimitM;
  ours.at_max = status.length_m >= travel_m - kNearLimitM;
  return ours;
}

}  // namespace motionlab::winch
