#include "simulators/winch/winch_device_legacy.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::winch {

namespace {

std::uint32_t place_of(std::string_view name) {
  const auto symbols = legacy_symbols();
  const auto found =
      std::find_if(symbols.begin(), symbols.end(), [&](const LegacySymbol& s) { return s.name == name; });
  return found->offset;
}

const std::uint32_t kTsAt = place_of("MAIN.winch.Ts");
const std::uint32_t kEnableAt = place_of("MAIN.winch.bEnable");
const std::uint32_t kModeCommandAt = place_of("MAIN.winch.eModeCmd");
const std::uint32_t kVelocityAt = place_of("MAIN.winch.u");
const std::uint32_t kRemoteVelocityAt = place_of("MAIN.winch.uRemote");
const std::uint32_t kActiveAt = place_of("MAIN.winch.bActive");
const std::uint32_t kModeAt = place_of("MAIN.winch.eMode");
const std::uint32_t kLengthAt = place_of("MAIN.winch.length");
const std::uint32_t kAxisAt = place_of("MAIN.winch.axis.NcToPlc.StateDWord");
const std::uint32_t kAxisValuesAt = place_of("MAIN.winch.axis.NcToPlc.ActPos");
const std::uint32_t kCycleCountAt = place_of("MAIN.nCycleCount");

double finite_or_zero(double value) noexcept {
  return std::isfinite(value) ? value : 0.0;
}

}  // namespace

LegacyCommand LegacyProgram::wanted() {
  const Bytes memory{memory_};
  LegacyCommand command;
  command.enable = memory[kEnableAt] != 0;
  const auto mode = memory[kModeCommandAt];
  if (mode <= static_cast<std::uint8_t>(LegacyMode::motion_compensation)) {
    command.mode = static_cast<LegacyMode>(mode);
  }
  const std::uint32_t at = command.mode == LegacyMode::remote ? kRemoteVelocityAt : kVelocityAt;
  const double asked_mps = finite_or_zero(load<double, std::endian::little>(memory.subspan(at)));
  if (command.mode != LegacyMode::settled) {
    command.velocity_mps = std::clamp(asked_mps, -config_.speed_max_mps, config_.speed_max_mps);
  }
  return command;
}

void LegacyProgram::command(LabTime t, PlcProgram& drive) {
  t_ = t;
  const LegacyCommand asked = wanted();
  if (asked.velocity_mps != velocity_before_mps_) t_changed_ = t;
  velocity_before_mps_ = asked.velocity_mps;
  PlcCommand command;
  command.heartbeat = ++heartbeat_;  // whatever the client does: there is no watchdog
  command.sequence = heartbeat_;
  command.enable = asked.enable;
  command.reset = !asked.enable;
  command.mode = asked.mode == LegacyMode::settled ? PlcMode::hold : PlcMode::velocity;
  command.velocity_mps = asked.velocity_mps;
  LittleWriter writer{drive.memory().subspan(PlcProgram::kCommandAt, kCommandSize)};
  command.encode(writer);
}

void LegacyProgram::report(const PlcProgram& drive) {
  const PlcStatus status = drive.status();
  const double length_m = status.position_m - config_.position_min_m;
  const double travel_m = config_.position_max_m - config_.position_min_m;
  const double acceleration_mps2 = (status.velocity_mps - measured_before_mps_) / config_.task_period_s;
  measured_before_mps_ = status.velocity_mps;
  const MutableBytes memory{memory_};
  store<std::endian::little>(memory.subspan(kTsAt), config_.task_period_s);
  memory[kActiveAt] = velocity_before_mps_ != 0 && t_ - t_changed_ < 1s ? 1 : 0;
  memory[kModeAt] = memory[kEnableAt] != 0 ? memory[kModeCommandAt] : std::uint8_t{0};
  LittleWriter lengths{memory.subspan(kLengthAt)};
  lengths.write(length_m);
  lengths.write(status.velocity_mps);
  lengths.write(acceleration_mps2);
  lengths.write(travel_m > 0 ? 100.0 * length_m / travel_m : 0.0);
  LittleWriter axis{memory.subspan(kAxisAt)};
  axis.write(status.axis_state);
  axis.write(status.axis_error_id);
  axis.write(std::uint32_t{status.enabled ? 1U : 0U});
  LittleWriter values{memory.subspan(kAxisValuesAt)};
  values.write(status.position_m);
  values.write(status.velocity_mps);
  values.write(status.following_error_m);
  values.write(status.set_position_m);
  values.write(status.velocity_mps);
  store<std::endian::little>(memory.subspan(kCycleCountAt), status.cycle_count);
}

}  // namespace motionlab::winch
