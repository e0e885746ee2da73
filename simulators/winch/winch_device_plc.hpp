/// @file  The simulated PLC's program: the 5 ms task that stands between GVL_Winch and the drive.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/core/bytes.hpp"
#include "drivers/core/time.hpp"
#include "drivers/winch/winch_wire.hpp"

namespace motionlab::winch {

/// What the world tells the PLC about the winch, at the time of the cycle.
struct Measurement {
  double wire_length_m = 0;   ///< free length from the exit point to the load
  double wire_speed_mps = 0;  ///< + pays out
  double motor_torque_nm = 0;
  double motor_temperature_degc = 40.0;
};

/// The PLC project's constants. Numbers of the laboratory's axis "RobotWinch" and its drive.
struct PlcConfig {
  double task_period_s = 0.005;
  double wire_at_zero_travel_m = 1.20;  ///< free wire length where the axis' position is zero
  double pay_out_sign = 1.0;    ///< +1 or -1: which way the axis' position grows when wire is paid out
  double position_min_m = 0.0;  ///< soft limits of the axis
  double position_max_m = 1.5;
  double speed_max_mps = 2.378;
  double acceleration_max_mps2 = 3.567;
  double stop_deceleration_mps2 = 3.5;  ///< of quick stop, lost heartbeat and soft limits
  double enabling_s = 0.1;              ///< from enable to closed loop
  double brake_opens_after_s = 0.058;   ///< drive-on delay and brake release
  double brake_closes_after_s = 0.025;  ///< after power off
  double power_off_after_s = 5.0;       ///< without a heartbeat
  double command_period_s = 0.010;    ///< the gateway's tick; a position stream is carried on over one missed
  double enable_agreement_m = 0.005;  ///< enabling in position mode is refused beyond this
  Nanoseconds clock_ahead{0};         ///< PLC clock minus laboratory time
};

/// The program and its global variables. Stepped by `cycle`; whoever writes the command's bytes writes
/// memory.
///
/// A command is obeyed as long as its heartbeat moves. While the drive is on, a heartbeat that stands still
/// for the watchdog time ramps the winch to rest, holds it in closed loop, latches `communication_lost`, and
/// after 5 s powers off and closes the brake. While the drive is off a lost heartbeat only clears bCommOk:
/// nothing moves, so there is nothing to latch. Out of a latched state lead, in this order: a running
/// heartbeat, enable low, a reset edge. Switching on needs enable to have been seen low since start, since
/// any fault and since the last switching on.
class PlcProgram {
 public:
  explicit PlcProgram(const PlcConfig& config);

  /// One run of the task. Call every task period; set points move by the time since the call before.
  /// @param seen  what the sensors say where that is not what is; the status tells it
  void cycle(LabTime t, const Measurement& is, const Measurement& seen);
  void cycle(LabTime t, const Measurement& is) { cycle(t, is, is); }

  /// The bytes that ADS clients read and write: the command, then the status.
  [[nodiscard]] MutableBytes memory() noexcept { return memory_; }
  static constexpr std::uint32_t kCommandAt = 0;
  static constexpr std::uint32_t kStatusAt = kCommandSize;
  static constexpr std::size_t kMemorySize = kCommandSize + kStatusSize;

  /// Free wire length that the drive holds. Before the first cycle the wire at zero travel; while the brake
  /// is closed the measured length.
  [[nodiscard]] double set_point_m() const noexcept;
  [[nodiscard]] bool brake_closed() const noexcept { return brake_closed_; }
  /// The torque the client allows at the motor; 0: the drive's own limit.
  [[nodiscard]] double torque_limit_nm() const noexcept { return command_.torque_limit_nm; }
  [[nodiscard]] PlcState state() const noexcept { return state_; }
  /// What the last cycle told; zeros before it.
  [[nodiscard]] const PlcStatus& status() const noexcept { return status_; }
  /// Changes of the command's memory that were refused.
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_; }

  /// A stopped PLC runs no cycle: the status stands still, the drive ramps to rest and switches off.
  void run(bool running) noexcept { running_ = running; }
  /// Power is gone, now: the brake closes, every variable is forgotten. It stands still until `run`.
  void lose_power();
  /// Takes the heartbeat for lost, whatever arrives.
  void trip_watchdog(bool tripped) noexcept { watchdog_tripped_ = tripped; }
  /// Freezes nCycleCount and nTimestamp; everything else goes on.
  void freeze_cycle_count(bool frozen) noexcept { frozen_ = frozen; }
  /// From now on the clock shows so much more; the task goes on in its own time.
  void set_clock_jump(Nanoseconds jump) noexcept { clock_jump_ = jump; }
  /// What the controller's clock shows, since 1970.
  [[nodiscard]] Nanoseconds clock(LabTime t) const noexcept {
    return t.time_since_epoch() + config_.clock_ahead + clock_jump_;
  }
  /// A drive fault with its S-0-0390 number; nothing: the cause is gone (the latch stays).
  void drive_fault(std::optional<std::uint32_t> diagnosis) noexcept { drive_fault_ = diagnosis; }

 private:
  void take_command();
  void watch_heartbeat();
  void decide();
  void obey_or_stop();
  void lose_communication();
  void power(bool on);
  void move(double dt_s);
  void switch_brake();
  void write_status();
  [[nodiscard]] double velocity_wanted(double dt_s) const;
  [[nodiscard]] double within_braking_distance(double velocity_mps, double dt_s);
  [[nodiscard]] bool at_rest() const noexcept { return velocity_mps_ == 0.0; }
  [[nodiscard]] bool reset_edge() const noexcept { return command_.reset && !previous_.reset; }

  PlcConfig config_;
  Nanoseconds clock_jump_{0};
  std::array<std::uint8_t, kMemorySize> memory_{};
  std::array<std::uint8_t, kCommandSize> seen_{};  ///< command bytes at the last cycle
  LabTime t_{};
  std::optional<LabTime> t_last_;

  PlcCommand command_{};   ///< last good
  PlcCommand previous_{};  ///< of the cycle before
  bool command_refused_ = false;
  std::uint64_t refused_ = 0;
  std::optional<LabTime> t_beat_;  ///< when the heartbeat moved last
  bool communication_ok_ = false;

  PlcState state_ = PlcState::off;
  LabTime t_state_{};
  bool enable_seen_low_ = false;
  bool powered_ = false;
  std::optional<LabTime> t_power_;
  bool brake_closed_ = true;
  bool running_ = true;
  bool frozen_ = false;
  bool limited_ = false;
  bool watchdog_tripped_ = false;
  std::optional<std::uint32_t> drive_fault_;
  std::uint32_t diagnosis_ = 0;  ///< of the latched fault

  double position_m_ = 0;  ///< set point, axis
  double velocity_mps_ = 0;
  double measured_position_m_ = 0;
  Measurement sensed_{};
  PlcStatus status_{};
  std::uint32_t cycle_count_ = 0;
  Nanoseconds t_plc_{0};
  std::uint32_t watchdog_trips_ = 0;
};

}  // namespace motionlab::winch
