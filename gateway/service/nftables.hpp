/// @file  Firewall rules made from the configuration: each port of the gateway admits the peers that it
/// names.
#pragma once

#include <string>
#include <vector>

#include "gateway/service/gateway_config.hpp"

namespace motionlab::service {

/// An address of this host and the interface that has it.
struct InterfaceAddress {
  std::string address;    ///< "192.168.90.70"
  std::string interface;  ///< "eth0"
};

[[nodiscard]] std::vector<InterfaceAddress> interface_addresses();

/// A file for `nft -f`: one table, `inet motionlab`, that replaces itself. Device ports hear their configured
/// source alone; the DDS ports of the domain hear the interfaces of `[bus] interfaces` (all, when none is
/// named) and this host. What else comes to these ports is dropped and counted. Other ports and other tables
/// are left alone, and so are the gateway's own connections to QTM and the PLC.
/// @throws StartupError when a bus interface is no address of this host
[[nodiscard]] std::string nftables_rules(const GatewayConfig& config,
                                         const std::vector<InterfaceAddress>& host);

}  // namespace motionlab::service
