/// @file  The laboratory's own configuration, with a few lines laid over it.
#pragma once

#include <string>

#include "gateway/service/gateway_config.hpp"

namespace motionlab::service {

inline GatewayConfig lab_config(const std::string& more = "") {
  const std::string folder = std::string(MOTIONLAB_SOURCE_DIR) + "/deploy/config/";
  return load_gateway_config(folder + "lab.toml", {}, {{"test", more}});
}

}  // namespace motionlab::service
