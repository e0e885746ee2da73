/// @file  Which devices are there and which are missing: what the service manager and its reader are told.
#pragma once

#include <string>
#include <vector>

#include "gateway/service/gateway_config.hpp"
#include "idl/health.hpp"
#include "idl/mode.hpp"

namespace motionlab::service {

/// The devices of a configuration by name, in the order of its file.
[[nodiscard]] std::vector<std::string> device_names(const GatewayConfig& config);

/// One look at every device of the configuration.
struct RollCall {
  struct Missing {
    std::string device;
    std::string why;  ///< its link, and the advice where there is one
    bool waited_for;  ///< required, not connected, not declared absent: the service is not ready without it
  };
  std::vector<std::string> up;
  std::vector<Missing> missing;  ///< not up; those declared absent are not missing
  std::vector<std::string> absent;

  /// Every required device is connected, or its absence is declared.
  [[nodiscard]] bool complete() const;

  /// The devices that the service waits for: "arm, winch".
  [[nodiscard]] std::string waited_for() const;

  /// One line: mode and reason, who is up, missing (with the reason) and declared absent.
  [[nodiscard]] std::string sentence(const topic::Mode& mode) const;
};

/// @param healths  the newest of each device; a device without one has not been looked at yet
[[nodiscard]] RollCall call_roll(const GatewayConfig& config, const std::vector<topic::Health>& healths);

}  // namespace motionlab::service
