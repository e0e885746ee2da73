/// @file  What of the configuration may change while the service runs, and why the rest may not.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "gateway/service/gateway_config.hpp"
#include "idl/mode.hpp"

namespace motionlab::service {

/// The configuration in force, and what a newly read one may change of it.
///
/// At any time: `[service] log_level` and `[service] absent`, which move nothing. While nothing is engaged:
/// `[reference] p_world_load_m`. Everything else was used to open sockets, to bound the guard or to believe
/// something, and takes a restart.
class LiveSettings {
 public:
  struct Change {
    std::string key;      ///< "[reference] p_world_load_m"
    std::string refused;  ///< why it stays as it was, and what to do; empty when it was taken
  };

  explicit LiveSettings(GatewayConfig config);

  [[nodiscard]] const GatewayConfig& in_force() const { return config_; }

  /// Takes what may change in this mode. @returns every key that differs, in the order of their names
  std::vector<Change> take(const GatewayConfig& read, topic::ModeState mode);

 private:
  GatewayConfig config_;
  std::map<std::string, std::string> values_;  ///< in force, by key
};

}  // namespace motionlab::service
