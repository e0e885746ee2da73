#include "drivers/winch/winch_wire_structs.hpp"

#include <array>
#include <cmath>

#include "drivers/winch/winch_wire_filetime.hpp"

namespace motionlab::winch {

namespace {

void write_bool(LittleWriter& writer, bool value) noexcept {
  writer.write(static_cast<std::uint8_t>(value ? 1 : 0));
}
bool read_bool(LittleReader& reader) noexcept {
  return reader.read<std::uint8_t>() != 0;
}

template <class... Doubles>
bool all_finite(Doubles... values) noexcept {
  return (std::isfinite(values) && ...);
}

bool finite_or_absent(double value) noexcept {
  return !std::isinf(value);
}

constexpr Member udint(std::string_view name, std::uint32_t offset) {
  return {name, "UDINT", DataType::udint, offset, 4};
}
constexpr Member lreal(std::string_view name, std::uint32_t offset) {
  return {name, "LREAL", DataType::lreal, offset, 8};
}
constexpr Member uint(std::string_view name, std::uint32_t offset) {
  return {name, "UINT", DataType::word, offset, 2};
}
constexpr Member boolean(std::string_view name, std::uint32_t offset) {
  return {name, "BOOL", DataType::boolean, offset, 1};
}

constexpr std::array kCommandMembers = {
    udint("nLayoutVersion", 0),
    udint("nHeartbeat", 4),
    udint("nSequence", 8),
    udint("nReserved0", 12),
    lreal("fSetPosition", 16),
    lreal("fSetVelocity", 24),
    lreal("fSetAcceleration", 32),
    lreal("fTorqueLimit", 40),
    uint("eMode", 48),
    boolean("bEnable", 50),
    boolean("bReset", 51),
    boolean("bQuickStop", 52),
    Member{"nReserved1", "BYTE", DataType::byte, 53, 1},
    Member{"aReserved", "ARRAY [0..1] OF BYTE", DataType::byte, 54, 2},
    udint("nTimeoutMs", 56),
    udint("nReserved2", 60),
};

constexpr std::array kStatusMembers = {
    udint("nLayoutVersion", 0),
    udint("nCycleCount", 4),
    udint("nHeartbeatEcho", 8),
    udint("nSequenceEcho", 12),
    Member{"nTimestamp", "ULINT", DataType::ulint, 16, 8},
    lreal("fActPosition", 24),
    lreal("fActVelocity", 32),
    lreal("fSetPosition", 40),
    lreal("fFollowingError", 48),
    lreal("fActTorque", 56),
    lreal("fMotorTemperature", 64),
    lreal("fMinPosition", 72),
    lreal("fMaxPosition", 80),
    udint("nAxisStateDWord", 88),
    udint("nAxisErrorId", 92),
    udint("nDriveDiagCode", 96),
    udint("nWatchdogTrips", 100),
    uint("nDriveStatusWord", 104),
    uint("nClass1Diag", 106),
    uint("eState", 108),
    uint("nReserved", 110),
    boolean("bReady", 112),
    boolean("bEnabled", 113),
    boolean("bError", 114),
    boolean("bWarning", 115),
    boolean("bCommOk", 116),
    boolean("bHomed", 117),
    boolean("bLimitMin", 118),
    boolean("bLimitMax", 119),
};

constexpr bool without_gaps(std::span<const Member> members, std::size_t size) {
  std::size_t at = 0;
  for (const auto& member : members) {
    if (member.offset != at) return false;
    at += member.size;
  }
  return at == size;
}
static_assert(without_gaps(kCommandMembers, kCommandSize));
static_assert(without_gaps(kStatusMembers, kStatusSize));

}  // namespace

void PlcCommand::encode(LittleWriter& writer) const noexcept {
  writer.write(kLayoutVersion);
  writer.write(heartbeat);
  writer.write(sequence);
  writer.write(std::uint32_t{0});
  writer.write(position_m);
  writer.write(velocity_mps);
  writer.write(acceleration_mps2);
  writer.write(torque_limit_nm);
  writer.write(static_cast<std::uint16_t>(mode));
  write_bool(writer, enable);
  write_bool(writer, reset);
  write_bool(writer, quick_stop);
  writer.write(std::uint8_t{0});
  writer.write(std::uint16_t{0});
  writer.write(static_cast<std::uint32_t>(timeout.count()));
  writer.write(std::uint32_t{0});
}

Result<PlcCommand> PlcCommand::decode(Bytes bytes) noexcept {
  if (bytes.size() < kCommandSize) return Fault{Reason::too_short, "ST_WinchCommand has 64 bytes"};
  if (bytes.size() > kCommandSize) return Fault{Reason::too_long, "ST_WinchCommand has 64 bytes"};
  LittleReader reader{bytes};
  if (reader.read<std::uint32_t>() != kLayoutVersion) {
    return Fault{Reason::bad_header, "ST_WinchCommand has another layout version than 1"};
  }
  PlcCommand command;
  command.heartbeat = reader.read<std::uint32_t>();
  command.sequence = reader.read<std::uint32_t>();
  reader.skip(4);
  command.position_m = reader.read<double>();
  command.velocity_mps = reader.read<double>();
  command.acceleration_mps2 = reader.read<double>();
  command.torque_limit_nm = reader.read<double>();
  const auto mode = reader.read<std::uint16_t>();
  command.enable = read_bool(reader);
  command.reset = read_bool(reader);
  command.quick_stop = read_bool(reader);
  reader.skip(3);
  command.timeout = std::chrono::milliseconds{reader.read<std::uint32_t>()};
  if (!all_finite(command.position_m, command.velocity_mps, command.acceleration_mps2,
                  command.torque_limit_nm)) {
    return Fault{Reason::bad_value, "a set point is not finite"};
  }
  if (command.torque_limit_nm < 0) return Fault{Reason::bad_value, "the torque limit is negative"};
  if (mode > static_cast<std::uint16_t>(PlcMode::position)) return Fault{Reason::bad_value, "unknown eMode"};
  command.mode = static_cast<PlcMode>(mode);
  return command;
}

void PlcStatus::encode(LittleWriter& writer) const noexcept {
  writer.write(kLayoutVersion);
  writer.write(cycle_count);
  writer.write(heartbeat_echo);
  writer.write(sequence_echo);
  writer.write(to_filetime(t_plc));
  writer.write(position_m);
  writer.write(velocity_mps);
  writer.write(set_position_m);
  writer.write(following_error_m);
  writer.write(torque_nm);
  writer.write(motor_temperature_degc);
  writer.write(position_min_m);
  writer.write(position_max_m);
  writer.write(axis_state);
  writer.write(axis_error_id);
  writer.write(drive_diagnosis);
  writer.write(watchdog_trips);
  writer.write(drive_status_word);
  writer.write(class_1_diagnosis);
  writer.write(static_cast<std::uint16_t>(state));
  writer.write(std::uint16_t{0});
  for (const bool flag : {ready, enabled, error, warning, communication_ok, homed, at_min, at_max}) {
    write_bool(writer, flag);
  }
}

Result<PlcStatus> PlcStatus::decode(Bytes bytes) noexcept {
  if (bytes.size() < kStatusSize) return Fault{Reason::too_short, "ST_WinchStatus has 120 bytes"};
  if (bytes.size() > kStatusSize) return Fault{Reason::too_long, "ST_WinchStatus has 120 bytes"};
  LittleReader reader{bytes};
  if (reader.read<std::uint32_t>() != kLayoutVersion) {
    return Fault{Reason::bad_header, "ST_WinchStatus has another layout version than 1"};
  }
  PlcStatus status;
  status.cycle_count = reader.read<std::uint32_t>();
  status.heartbeat_echo = reader.read<std::uint32_t>();
  status.sequence_echo = reader.read<std::uint32_t>();
  const auto t_plc = since_1970(reader.read<std::uint64_t>());
  status.position_m = reader.read<double>();
  status.velocity_mps = reader.read<double>();
  status.set_position_m = reader.read<double>();
  status.following_error_m = reader.read<double>();
  status.torque_nm = reader.read<double>();
  status.motor_temperature_degc = reader.read<double>();
  status.position_min_m = reader.read<double>();
  status.position_max_m = reader.read<double>();
  status.axis_state = reader.read<std::uint32_t>();
  status.axis_error_id = reader.read<std::uint32_t>();
  status.drive_diagnosis = reader.read<std::uint32_t>();
  status.watchdog_trips = reader.read<std::uint32_t>();
  status.drive_status_word = reader.read<std::uint16_t>();
  status.class_1_diagnosis = reader.read<std::uint16_t>();
  const auto state = reader.read<std::uint16_t>();
  reader.skip(2);
  for (bool* flag : {&status.ready, &status.enabled, &status.error, &status.warning, &status.communication_ok,
                     &status.homed, &status.at_min, &status.at_max}) {
    *flag = read_bool(reader);
  }
  if (!t_plc) return Fault{Reason::bad_value, "nTimestamp is not set, or outside 1970..2262"};
  if (!all_finite(status.position_m, status.velocity_mps, status.set_position_m, status.following_error_m,
                  status.position_min_m, status.position_max_m) ||
      !finite_or_absent(status.torque_nm) || !finite_or_absent(status.motor_temperature_degc)) {
    return Fault{Reason::bad_value, "a measured value is not finite"};
  }
  if (status.position_min_m > status.position_max_m) {
    return Fault{Reason::bad_value, "fMinPosition lies above fMaxPosition"};
  }
  if (state > static_cast<std::uint16_t>(PlcState::communication_lost)) {
    return Fault{Reason::bad_value, "unknown eState"};
  }
  status.t_plc = *t_plc;
  status.state = static_cast<PlcState>(state);
  return status;
}

std::span<const Member> command_members() noexcept {
  return kCommandMembers;
}
std::span<const Member> status_members() noexcept {
  return kStatusMembers;
}

}  // namespace motionlab::winch
