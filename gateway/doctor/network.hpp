/// @file  The network as the gateway needs it: its addresses on this host, interfaces that carry multicast
/// and do not hold interrupts back, ports that nobody else has.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/endpoint.hpp"
#include "gateway/doctor/finding.hpp"
#include "gateway/service/gateway_config.hpp"

namespace motionlab::doctor {

/// An IPv4 address of this host.
struct Interface {
  std::string name;
  std::uint32_t address = 0;  ///< host byte order
  bool up = false;
  bool multicast = false;
  bool loopback = false;
  std::optional<std::uint32_t> held_back_us;  ///< by interrupt coalescing on reception; nothing: not told
};

/// A UDP port that somebody has.
struct BoundPort {
  Endpoint local;
  std::uint64_t inode = 0;
  std::string program;  ///< empty: of a process that we may not look at
};

struct Network {
  std::vector<Interface> interfaces;
  std::vector<BoundPort> bound;
};

/// The ports of other users' programs are seen, but without the name of the program, unless we are root.
[[nodiscard]] Network look_at_network();

[[nodiscard]] Findings judge(const Network& network, const service::GatewayConfig& config);

/// The kernel's table of UDP sockets (/proc/net/udp) without programs. Lines that are none are left out.
[[nodiscard]] std::vector<BoundPort> bound_ports(std::string_view table);

}  // namespace motionlab::doctor
