/// @file  What the page has to know of the laboratory to draw it.
#pragma once

#include <string>

#include "gateway/service/gateway_config.hpp"

namespace motionlab::console {

/// /config.json: geometry, mounting poses, limits, freshness, and whether there is control. Nothing secret.
[[nodiscard]] std::string lab_json(const service::GatewayConfig& config, bool control);

}  // namespace motionlab::console
