/// @file  The devices: as a running gateway tells, or, while none runs, by what comes and who answers.
#pragma once

#include <atomic>

#include "gateway/doctor/finding.hpp"
#include "gateway/monitor/status_command.hpp"
#include "gateway/service/gateway_config.hpp"

namespace motionlab::doctor {

/// What a running gateway says. It asks QTM for its bodies, the PLC for its symbols and limits and the robot
/// computer for its answers all the time; what does not agree with its configuration stands in its advice.
[[nodiscard]] Findings judge(const monitor::Status& status);

/// While no gateway runs: listens for the motion reference units at the gateway's ports, and looks whether
/// QTM and the PLC accept a connection. Nothing is sent to any of them. The robot computer answers only who
/// commands it and is left alone. Takes a second for each unit, and up to two for each connection.
[[nodiscard]] Findings look_for_devices(const service::GatewayConfig& config,
                                        const std::atomic<bool>& interrupted);

}  // namespace motionlab::doctor
