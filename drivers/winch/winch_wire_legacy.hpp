/// @file  The laboratory's own PLC project, as published: function block `MAIN.winch`, without GVL_Winch.
///
/// Its symbols are reached one by one, by name. Its velocity command has no watchdog: what was written last
/// is obeyed for ever. Source: the laboratory's public PLC project (TwinCAT 3.1.4022): FB_Winch and MAIN.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/winch/winch_wire_symbols.hpp"

namespace motionlab::winch {

/// eModeCmd and eMode.
enum class LegacyMode : std::uint8_t { settled, local, remote, motion_compensation };

/// A symbol of the project, and where the simulated PLC keeps it. Places in the function block up to
/// length_tt are those of the laboratory's build; those behind are ours, since clients ask by name.
struct LegacySymbol {
  std::string_view name;
  std::string_view type;
  DataType data_type;
  std::uint32_t offset;
  std::uint32_t size;
};

inline constexpr std::size_t kLegacyMemorySize = 192;
[[nodiscard]] std::span<const LegacySymbol> legacy_symbols() noexcept;

/// What is read, in this order: one sum read.
inline constexpr std::array<std::string_view, 6> kLegacyStatusNames = {
    "MAIN.nCycleCount",
    "MAIN.winch.eMode",
    "MAIN.winch.length",
    "MAIN.winch.length_t",
    "MAIN.winch.axis.NcToPlc.StateDWord",
    "MAIN.winch.axis.NcToPlc.ErrorCode",
};
inline constexpr std::array<std::uint32_t, 6> kLegacyStatusSizes = {4, 1, 8, 8, 4, 4};
inline constexpr std::size_t kLegacyStatusSize = 29;

/// What is written, in this order: one sum write.
inline constexpr std::array<std::string_view, 3> kLegacyCommandNames = {
    "MAIN.winch.bEnable",
    "MAIN.winch.eModeCmd",
    "MAIN.winch.u",
};
inline constexpr std::array<std::uint32_t, 3> kLegacyCommandSizes = {1, 1, 8};
inline constexpr std::size_t kLegacyCommandSize = 10;

/// Bits of the NC's StateDWord.
namespace axis_state {
inline constexpr std::uint32_t operational = 1U << 0;
inline constexpr std::uint32_t homed = 1U << 1;
inline constexpr std::uint32_t not_moving = 1U << 2;
inline constexpr std::uint32_t positive = 1U << 9;
inline constexpr std::uint32_t negative = 1U << 10;
inline constexpr std::uint32_t external_generator = 1U << 14;
inline constexpr std::uint32_t error = 1U << 31;
}  // namespace axis_state

struct LegacyStatus {
  std::uint32_t cycle_count = 0;
  LegacyMode mode = LegacyMode::settled;
  double length_m = 0;  ///< from the lower soft limit
  double velocity_mps = 0;
  std::uint32_t axis_state = 0;
  std::uint32_t axis_error_id = 0;

  bool operator==(const LegacyStatus&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  /// Faults: too_short, too_long, bad_value (not finite, unknown mode).
  [[nodiscard]] static Result<LegacyStatus> decode(Bytes bytes) noexcept;
};

struct LegacyCommand {
  bool enable = false;
  LegacyMode mode = LegacyMode::settled;
  double velocity_mps = 0;  ///< obeyed in the modes local and motion_compensation

  bool operator==(const LegacyCommand&) const = default;
  void encode(LittleWriter& writer) const noexcept;
  /// Faults: too_short, too_long, bad_value (not finite, unknown mode).
  [[nodiscard]] static Result<LegacyCommand> decode(Bytes bytes) noexcept;
};

}  // namespace motionlab::winch
