#include "gateway/service/nftables.hpp"

#include <ifaddrs.h>
#include <netinet/in.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "drivers/core/error.hpp"

namespace motionlab::service {
namespace {

// The ports of a DDS domain, as the RTPS standard counts them.
constexpr int kFirstDomainPort = 7400;
constexpr int kPortsOfADomain = 250;
constexpr int kLastPort = 65535;

/// "ip daddr 192.168.90.42 " unless the socket listens on every address.
std::string to_address(const Endpoint& listen) {
  return listen.address == 0 ? "" : "ip daddr " + address_to_string(listen.address) + ' ';
}

std::string bus_interfaces(const GatewayConfig& config, const std::vector<InterfaceAddress>& host) {
  std::set<std::string> names{"lo"};  // this host's own tools
  for (const auto& wanted : config.bus.interface_whitelist) {
    const auto found =
        std::find_if(host.begin(), host.end(), [&](const auto& each) { return each.address == wanted; });
    if (found == host.end()) {
      throw StartupError(
          "[bus] interfaces: " + wanted +
          " is no address of this host; run this on the gateway's own machine, its network up");
    }
    names.insert(found->interface);
  }
  std::string list;
  for (const auto& name : names) list += (list.empty() ? "\"" : ", \"") + name + '"';
  return "iifname { " + list + " } ";
}

}  // namespace

std::vector<InterfaceAddress> interface_addresses() {
  std::vector<InterfaceAddress> all;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return all;
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    const auto* const address = reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    all.push_back({address_to_string(ntohl(address->sin_addr.s_addr)), entry->ifa_name});
  }
  freeifaddrs(list);
  return all;
}

std::string nftables_rules(const GatewayConfig& config, const std::vector<InterfaceAddress>& host) {
  std::ostringstream admitted;
  std::set<std::uint16_t> ports;
  const auto admit = [&](const std::string& device, const Endpoint& listen, const Endpoint& peer) {
    ports.insert(listen.port);
    admitted << "    ip saddr " << address_to_string(peer.address) << ' ' << to_address(listen);
    if (peer.port != 0) admitted << "udp sport " << peer.port << ' ';
    admitted << "udp dport " << listen.port << " counter accept comment \"" << device << "\"\n";
  };
  for (const auto& mru : config.mrus) {
    admit(mru.driver.device, mru.listen, {mru.driver.source_address, 0});
  }
  admit(config.qualisys.driver.device, config.qualisys.listen, {config.qualisys.server.address, 0});
  admit(config.comau.driver.device, config.comau.listen, config.comau.driver.robot_computer);
  if (const auto& plc = config.plc_reply) admit(plc->driver.device, plc->listen, plc->driver.plc);

  std::string device_ports;
  for (const auto port : ports) device_ports += (device_ports.empty() ? "" : ", ") + std::to_string(port);
  const int first = kFirstDomainPort + kPortsOfADomain * config.bus.domain;
  const std::string bus_ports =
      std::to_string(first) + '-' + std::to_string(std::min(first + kPortsOfADomain - 1, kLastPort));
  const bool everywhere = config.bus.interface_whitelist.empty();

  std::ostringstream out;
  out << "# Made by motionlab-gateway --nftables from its configuration; make it anew when that changes.\n"
         "# Load with nft -f; look at the counters with: nft list table inet motionlab\n"
         "table inet motionlab\n"
         "delete table inet motionlab\n"
         "table inet motionlab {\n"
         "  counter strangers_at_devices { }\n"
         "  counter strangers_at_bus { }\n"
         "  chain input {\n"
         "    type filter hook input priority filter; policy accept;\n"
      << admitted.str() << "    udp dport { " << device_ports
      << " } counter name \"strangers_at_devices\" drop\n"
      << "    " << (everywhere ? "" : bus_interfaces(config, host)) << "udp dport " << bus_ports
      << " counter accept comment \"DDS domain " << config.bus.domain
      << (everywhere ? ", from anywhere: [bus] interfaces names none" : "") << "\"\n"
      << "    udp dport " << bus_ports << " counter name \"strangers_at_bus\" drop\n"
      << "  }\n"
         "}\n";
  return out.str();
}

}  // namespace motionlab::service
