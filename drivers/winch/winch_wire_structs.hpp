/// @file  ST_WinchCommand and ST_WinchStatus: the two structs of GVL_Winch in the PLC, and their members.
///
/// The layout is the same under packing 1 and 8: members lie on multiples of their size, reserves are spelled
/// out. Positions are the PLC's own (travel of the axis); the driver maps them to free wire length.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"
#include "drivers/winch/winch_wire_symbols.hpp"

namespace motionlab::winch {

inline constexpr std::uint32_t kLayoutVersion = 1;
inline constexpr std::size_t kCommandSize = 64;
inline constexpr std::size_t kStatusSize = 120;
inline constexpr std::string_view kCommandType = "ST_WinchCommand";
inline constexpr std::string_view kStatusType = "ST_WinchStatus";

/// eMode of the command.
enum class PlcMode : std::uint16_t { off, hold, velocity, position };

/// eState of the status.
enum class PlcState : std::uint16_t {
  off,
  enabling,
  hold,
  velocity,
  position,
  stopping,
  fault,
  communication_lost,
};

/// ST_WinchCommand, written whole with every tick.
struct PlcCommand {
  std::uint32_t heartbeat = 0;  ///< +1 per write, wraps
  std::uint32_t sequence = 0;   ///< +1 when mode, enable, reset or stop change
  double position_m = 0;
  double velocity_mps = 0;
  double acceleration_mps2 = 0;  ///< feed-forward
  double torque_limit_nm = 0;    ///< at the motor; 0 is the drive's own limit
  PlcMode mode = PlcMode::off;
  bool enable = false;                   ///< level, but needs a rising edge after any fault
  bool reset = false;                    ///< rising edge
  bool quick_stop = false;               ///< level: ramp down and hold
  std::chrono::milliseconds timeout{0};  ///< wanted watchdog time; whole milliseconds, clamped by the PLC

  bool operator==(const PlcCommand&) const = default;

  void encode(LittleWriter& writer) const noexcept;
  /// Faults: too_short, too_long, bad_header (layout version), bad_value (not finite, negative torque limit,
  /// unknown mode).
  [[nodiscard]] static Result<PlcCommand> decode(Bytes bytes) noexcept;
};

/// ST_WinchStatus, notified whole.
struct PlcStatus {
  std::uint32_t cycle_count = 0;     ///< +1 per PLC cycle
  std::uint32_t heartbeat_echo = 0;  ///< last accepted
  std::uint32_t sequence_echo = 0;   ///< last accepted
  Nanoseconds t_plc{0};              ///< PLC time since 1970 UTC, 100 ns steps
  double position_m = 0;
  double velocity_mps = 0;
  double set_position_m = 0;  ///< in use, after limiting
  double following_error_m = 0;
  double torque_nm = 0;               ///< at the motor; NaN if not mapped
  double motor_temperature_degc = 0;  ///< NaN if unknown
  double position_min_m = 0;          ///< soft limits
  double position_max_m = 0;
  std::uint32_t axis_state = 0;         ///< NC StateDWord
  std::uint32_t axis_error_id = 0;      ///< NC ErrorCode
  std::uint32_t drive_diagnosis = 0;    ///< S-0-0390
  std::uint32_t watchdog_trips = 0;     ///< since start
  std::uint16_t drive_status_word = 0;  ///< S-0-0135
  std::uint16_t class_1_diagnosis = 0;  ///< S-0-0011
  PlcState state = PlcState::off;
  bool ready = false;    ///< power available, no fault
  bool enabled = false;  ///< torque on, generator enabled
  bool error = false;
  bool warning = false;
  bool communication_ok = false;  ///< watchdog satisfied
  bool homed = false;
  bool at_min = false;
  bool at_max = false;

  void encode(LittleWriter& writer) const noexcept;
  /// Faults: too_short, too_long, bad_header (layout version), bad_value (not finite, limits the wrong way
  /// round, unknown state, a stamp before 1970).
  [[nodiscard]] static Result<PlcStatus> decode(Bytes bytes) noexcept;
};

/// One member of a PLC struct, as its symbol is named.
struct Member {
  std::string_view name;
  std::string_view type;
  DataType data_type;
  std::uint32_t offset;
  std::uint32_t size;
};

[[nodiscard]] std::span<const Member> command_members() noexcept;
[[nodiscard]] std::span<const Member> status_members() noexcept;

}  // namespace motionlab::winch
