#include "drivers/winch/winch_wire_legacy.hpp"

#include <cmath>
#include <numeric>

namespace motionlab::winch {

namespace {

constexpr LegacySymbol lreal(std::string_view name, std::uint32_t offset) {
  return {name, "LREAL", DataType::lreal, offset, 8};
}
constexpr LegacySymbol udint(std::string_view name, std::uint32_t offset) {
  return {name, "UDINT", DataType::udint, offset, 4};
}
constexpr LegacySymbol usint(std::string_view name, std::uint32_t offset) {
  return {name, "USINT", DataType::byte, offset, 1};
}
constexpr LegacySymbol boolean(std::string_view name, std::uint32_t offset) {
  return {name, "BOOL", DataType::boolean, offset, 1};
}

constexpr std::array kSymbols = {
    lreal("MAIN.winch.Ts", 8),
    boolean("MAIN.winch.bEnable", 16),
    usint("MAIN.winch.eModeCmd", 17),
    lreal("MAIN.winch.u", 24),
    lreal("MAIN.winch.uRemote", 32),
    boolean("MAIN.winch.bActive", 40),
    usint("MAIN.winch.eMode", 41),
    lreal("MAIN.winch.length", 48),
    lreal("MAIN.winch.length_t", 56),
    lreal("MAIN.winch.length_tt", 64),
    lreal("MAIN.winch.lengthUtilization", 72),
    udint("MAIN.winch.axis.NcToPlc.StateDWord", 80),
    udint("MAIN.winch.axis.NcToPlc.ErrorCode", 84),
    udint("MAIN.winch.axis.NcToPlc.AxisState", 88),
    lreal("MAIN.winch.axis.NcToPlc.ActPos", 96),
    lreal("MAIN.winch.axis.NcToPlc.ActVelo", 104),
    lreal("MAIN.winch.axis.NcToPlc.PosDiff", 112),
    lreal("MAIN.winch.axis.NcToPlc.SetPos", 120),
    lreal("MAIN.winch.axis.NcToPlc.SetVelo", 128),
    udint("MAIN.nCycleCount", 136),
};

static_assert(std::accumulate(kLegacyStatusSizes.begin(), kLegacyStatusSizes.end(), 0U) == kLegacyStatusSize);
static_assert(std::accumulate(kLegacyCommandSizes.begin(), kLegacyCommandSizes.end(), 0U) ==
              kLegacyCommandSize);

constexpr Fault kTooShort{Reason::too_short, "fewer bytes than the symbols of MAIN.winch have"};
constexpr Fault kTooLong{Reason::too_long, "more bytes than the symbols of MAIN.winch have"};
constexpr Fault kNotFinite{Reason::bad_value, "a value of MAIN.winch is not finite"};
constexpr Fault kUnknownMode{Reason::bad_value, "MAIN.winch has a mode that is none of 0..3"};

bool known(std::uint8_t mode) noexcept {
  return mode <= static_cast<std::uint8_t>(LegacyMode::motion_compensation);
}

}  // namespace

std::span<const LegacySymbol> legacy_symbols() noexcept {
  return kSymbols;
}

void LegacyStatus::encode(LittleWriter& writer) const noexcept {
  writer.write(cycle_count);
  writer.write(static_cast<std::uint8_t>(mode));
  writer.write(length_m);
  writer.write(velocity_mps);
  writer.write(axis_state);
  writer.write(axis_error_id);
}

Result<LegacyStatus> LegacyStatus::decode(Bytes bytes) noexcept {
  if (bytes.size() < kLegacyStatusSize) return kTooShort;
  if (bytes.size() > kLegacyStatusSize) return kTooLong;
  LittleReader reader{bytes};
  LegacyStatus status;
  status.cycle_count = reader.read<std::uint32_t>();
  const auto mode = reader.read<std::uint8_t>();
  status.length_m = reader.read<double>();
  status.velocity_mps = reader.read<double>();
  status.axis_state = reader.read<std::uint32_t>();
  status.axis_error_id = reader.read<std::uint32_t>();
  if (!std::isfinite(status.length_m) || !std::isfinite(status.velocity_mps)) return kNotFinite;
  if (!known(mode)) return kUnknownMode;
  status.mode = static_cast<LegacyMode>(mode);
  return status;
}

void LegacyCommand::encode(LittleWriter& writer) const noexcept {
  writer.write(static_cast<std::uint8_t>(enable ? 1 : 0));
  writer.write(static_cast<std::uint8_t>(mode));
  writer.write(velocity_mps);
}

Result<LegacyCommand> LegacyCommand::decode(Bytes bytes) noexcept {
  if (bytes.size() < kLegacyCommandSize) return kTooShort;
  if (bytes.size() > kLegacyCommandSize) return kTooLong;
  LittleReader reader{bytes};
  LegacyCommand command;
  command.enable = reader.read<std::uint8_t>() != 0;
  const auto mode = reader.read<std::uint8_t>();
  command.velocity_mps = reader.read<double>();
  if (!std::isfinite(command.velocity_mps)) return kNotFinite;
  if (!known(mode)) return kUnknownMode;
  command.mode = static_cast<LegacyMode>(mode);
  return command;
}

}  // namespace motionlab::winch
