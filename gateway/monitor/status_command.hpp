/// @file  `motionlab status`: what the gateway is doing and how each device's link is.
#pragma once

#include <optional>
#include <vector>

#include "gateway/monitor/session.hpp"
#include "idl/health.hpp"
#include "idl/mode.hpp"

namespace motionlab::monitor {

/// What a gateway says of itself and its devices.
struct Status {
  std::optional<topic::Mode> mode;     ///< nothing: none was heard
  std::vector<topic::Health> devices;  ///< by name; the control thread's own is "gateway"

  [[nodiscard]] bool nobody() const { return !mode && devices.empty(); }
  /// All links are up, no fault is latched and nothing keeps the gateway from being ready.
  [[nodiscard]] bool healthy() const;
};

/// Listens until mode and every device were heard, or for the timeout of the connection.
[[nodiscard]] Status hear_status(const Connection& connection, const std::atomic<bool>& interrupted);

/// Waits for mode and health and prints both.
/// @returns kExitGood when all links are up, no fault is latched and nothing keeps the gateway from being
///          ready; kExitWrong otherwise; kExitNobody when neither was heard within the timeout
int run_status(const Connection& connection, bool json, const Terminal& terminal);

}  // namespace motionlab::monitor
