#include "drivers/winch/winch_driver_command.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::winch {

namespace {

PlcMode to_plc(topic::WinchCommandMode mode) noexcept {
  switch (mode) {
    case topic::WinchCommandMode::off:
      return PlcMode::off;
    case topic::WinchCommandMode::hold:
      return PlcMode::hold;
    case topic::WinchCommandMode::velocity:
      return PlcMode::velocity;
    case topic::WinchCommandMode::position:
      return PlcMode::position;
  }
  return PlcMode::off;
}

}  // namespace

Status CommandSource::set(const topic::WinchCommand& command, std::string_view device, LabTime now) {
  if (!command.device.empty() && command.device.view() != device) {
    return Fault{Reason::foreign, "winch command for another device"};
  }
  if (!std::isfinite(command.wire_length_wanted_m) || !std::isfinite(command.wire_speed_wanted_mps) ||
      !std::isfinite(command.wire_acceleration_wanted_mps2)) {
    return Fault{Reason::bad_value, "winch command that is not finite"};
  }
  if (t_command_ && command.t_created_ns < command_.t_created_ns) {
    return Fault{Reason::out_of_order, "winch command older than the one in use"};
  }
  command_ = command;
  t_command_ = std::min(from_ns(command.t_created_ns), now);
  return Done{};
}

PlcCommand CommandSource::at(LabTime now, double hold_at_m) {
  const bool stale = !t_command_ || now - *t_command_ > stale_after_;
  if (stale && !stale_ && t_command_) ++became_stale_;
  stale_ = stale;

  PlcCommand command;
  command.position_m = hold_at_m;
  command.mode = t_command_ ? PlcMode::hold : PlcMode::off;
  command.quick_stop = stale;
  if (stale) return command;
  command.mode = to_plc(command_.mode);
  command.velocity_mps = axis_.turned(command_.wire_speed_wanted_mps);
  command.acceleration_mps2 = axis_.turned(command_.wire_acceleration_wanted_mps2);
  if (command.mode == PlcMode::position) command.position_m = axis_.position_m(command_.wire_length_wanted_m);
  return command;
}

LegacyCommand to_legacy(const PlcCommand& command, double speed_max_mps) noexcept {
  LegacyCommand legacy;
  legacy.enable = command.enable;
  const bool moves = command.enable && !command.quick_stop && command.mode == PlcMode::velocity;
  if (!moves) return legacy;
  legacy.mode = LegacyMode::local;
  legacy.velocity_mps = std::clamp(command.velocity_mps, -speed_max_mps, speed_max_mps);
  return legacy;
}

}  // namespace motionlab::winch
