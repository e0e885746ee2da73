/// @file  `motionlab doctor`: is this machine, this network and this laboratory as the gateway needs them?
#pragma once

#include <string>
#include <vector>

#include "gateway/monitor/command_line.hpp"

namespace motionlab::doctor {

struct DoctorCommand {
  std::string config;                 ///< lab.toml; empty: found
  std::vector<std::string> overlays;  ///< laid over it, in order
};

/// Reads the configuration, looks at machine, network and devices, and says of each how it is and what to do.
///
/// Changes nothing and sends nothing to any device. With a gateway on the configured domain the devices are
/// judged by what it says, else by what comes and who answers.
/// @returns kExitWrong when something fails; warnings are no failure. An error in the configuration is the
/// only finding then
int run_doctor(const DoctorCommand& command, const monitor::Connection& connection, bool json,
               const monitor::Terminal& terminal);

/// Adds itself to the command line of `motionlab`.
[[nodiscard]] monitor::FurtherCommand doctor_command();

}  // namespace motionlab::doctor
