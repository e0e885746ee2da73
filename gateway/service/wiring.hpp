/// @file  The wiring that a configuration means, for people.
#pragma once

#include <string>

#include "gateway/service/gateway_config.hpp"

namespace motionlab::service {

/// Who listens where and who is spoken to, one line each.
[[nodiscard]] std::string wiring(const GatewayConfig& config);

/// The same as a drawing, in UTF-8: devices on the left, the gateway with its own addresses, the bus on the
/// right. An arrow points to where bytes go.
[[nodiscard]] std::string wiring_drawing(const GatewayConfig& config);

}  // namespace motionlab::service
