/// @file  `motionlab status`: what the gateway is doing and how each device's link is.
#pragma once

#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

/// Waits for mode and health and prints both.
/// @returns kExitGood when all links are up, no fault is latched and nothing keeps the gateway from being
///          ready; kExitWrong otherwise; kExitNobody when neither was heard within the timeout
int run_status(const Connection& connection, bool json, const Terminal& terminal);

}  // namespace motionlab::monitor
