/// @file  What the driver is told about the winch's controller.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/winch/winch_driver_axis.hpp"
#include "drivers/winch/winch_wire.hpp"

namespace motionlab::winch {

/// Which PLC project we speak to: ours, or the laboratory's published one (MAIN.winch), which has no
/// watchdog.
enum class Profile : std::uint8_t { gvl_winch, legacy };

struct DriverConfig {
  std::string device = "winch";
  AmsAddress target{{{192, 168, 90, 150, 1, 1}}, ams_port::plc_runtime_1};
  /// Ours. The PLC needs a route to this NetId. One fixed port, so that what we left behind can be found and
  /// deleted.
  AmsAddress local{{{192, 168, 90, 70, 1, 1}}, 32905};
  std::string command_symbol = "GVL_Winch.stCommand";
  std::string status_symbol = "GVL_Winch.stStatus";

  Profile profile = Profile::gvl_winch;
  /// Legacy: whether we may move the winch at all. Without: nothing is ever written.
  bool legacy_commands = false;
  double legacy_speed_max_mps = 0.05;  ///< legacy: the fastest that we ever ask for
  double legacy_travel_m = 1.5;        ///< legacy: between the soft limits, which that project does not tell

  double command_period_s = 0.010;
  double status_period_s = 0.010;
  double command_stale_after_s = 0.05;    ///< an older command becomes quick stop and hold
  double status_stale_after_s = 0.05;     ///< then the status is read, in case only notifications are lost
  double status_dead_after_s = 1.0;       ///< then the connection is closed and made anew
  double heartbeat_echo_within_s = 0.05;  ///< else the command path is not alive
  double request_timeout_s = 0.1;
  double connect_timeout_s = 1.0;
  double reconnect_min_s = 0.1;  ///< doubles up to the next, with jitter
  double reconnect_max_s = 2.0;
  double plc_watchdog_s = 0.1;          ///< wanted of the PLC, which clamps it to 0.02..0.5
  double torque_limit_nm = 0.0;         ///< at the motor; 0: the drive's own
  double latency_s = 0.0;               ///< known constant delay from the PLC's stamp to arrival
  double wire_at_zero_travel_m = 1.20;  ///< see AxisMap
  double pay_out_sign = 1.0;            ///< see AxisMap
  std::uint32_t jitter_seed = 1;

  [[nodiscard]] AxisMap axis() const noexcept { return {wire_at_zero_travel_m, pay_out_sign}; }
  [[nodiscard]] bool legacy() const noexcept { return profile == Profile::legacy; }
  [[nodiscard]] bool commands() const noexcept { return !legacy() || legacy_commands; }
};

}  // namespace motionlab::winch
