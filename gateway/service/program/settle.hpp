/// @file  Arm and winch brought to rest without a gateway: `motionlab-gateway --settle`.
#pragma once

#include "gateway/deadman/settlement.hpp"
#include "gateway/service/gateway_config.hpp"

namespace motionlab::service {

/// Where the deadman, or whoever settles, finds arm and winch.
[[nodiscard]] deadman::WireConfig wires(const GatewayConfig& config);

/// The second line: the gateway is gone, and perhaps its deadman with it. What is not at rest is told.
/// @returns the program's exit code
/// @throws StartupError while a gateway of this configuration, or its deadman, has the arm's port
int settle(const GatewayConfig& config);

}  // namespace motionlab::service
