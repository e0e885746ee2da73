#include "gateway/doctor/network.hpp"

#include <ifaddrs.h>
#include <linux/ethtool.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

namespace motionlab::doctor {
namespace {

namespace fs = std::filesystem;

/// More than this shows in the ages of samples.
constexpr std::uint32_t kHeldBackTooLong_us = 50;
/// As the kernel cuts the gateway's name.
constexpr std::string_view kGateway = "motionlab-gatew";

std::optional<std::uint32_t> held_back_us(int socket, const std::string& interface) {
  ethtool_coalesce coalesce{};
  coalesce.cmd = ETHTOOL_GCOALESCE;
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  request.ifr_data = reinterpret_cast<char*>(&coalesce);
  if (ioctl(socket, SIOCETHTOOL, &request) != 0) return std::nullopt;
  return coalesce.rx_coalesce_usecs;
}

std::vector<Interface> interfaces() {
  std::vector<Interface> all;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return all;
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    if (!entry->ifa_addr || entry->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, entry->ifa_addr, sizeof address);
    all.push_back({.name = entry->ifa_name,
                   .address = ntohl(address.sin_addr.s_addr),
                   .up = (entry->ifa_flags & IFF_UP) != 0 && (entry->ifa_flags & IFF_RUNNING) != 0,
                   .multicast = (entry->ifa_flags & IFF_MULTICAST) != 0,
                   .loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0,
                   .held_back_us = held_back_us(socket, entry->ifa_name)});
  }
  ::close(socket);
  freeifaddrs(list);
  return all;
}

/// Names of programs by the sockets that they hold, as far as we may look.
std::map<std::uint64_t, std::string> programs_by_socket() {
  std::map<std::uint64_t, std::string> all;
  std::error_code hidden;
  for (const auto& process : fs::directory_iterator("/proc", hidden)) {
    std::string name;
    std::getline(std::ifstream(process.path() / "comm"), name);
    if (name.empty()) continue;
    for (const auto& file : fs::directory_iterator(process.path() / "fd", hidden)) {
      const std::string target = fs::read_symlink(file.path(), hidden).string();
      constexpr std::string_view kSocket = "socket:[";
      if (target.starts_with(kSocket)) all.emplace(std::stoull(target.substr(kSocket.size())), name);
    }
  }
  return all;
}

/// A port of the gateway.
struct Door {
  std::string device;
  Endpoint listen;
};

std::vector<Door> doors(const service::GatewayConfig& config) {
  std::vector<Door> all;
  for (const auto& mru : config.mrus) all.push_back({mru.driver.device, mru.listen});
  all.push_back({config.qualisys.driver.device, config.qualisys.listen});
  all.push_back({config.comau.driver.device, config.comau.listen});
  if (config.plc_reply) all.push_back({config.plc_reply->driver.device, config.plc_reply->listen});
  return all;
}

const Interface* with_address(const Network& network, std::uint32_t address) {
  const auto found = std::ranges::find(network.interfaces, address, &Interface::address);
  return found == network.interfaces.end() ? nullptr : &*found;
}

Finding judge_door(const Network& network, const Door& door) {
  const std::string subject = "port of " + door.device;
  const std::string port = "udp " + to_string(door.listen);
  if (door.listen.address != 0 && !with_address(network, door.listen.address)) {
    return {Grade::fail, subject, address_to_string(door.listen.address) + " is no address of this host",
            "ip address add " + address_to_string(door.listen.address) +
                "/24 dev INTERFACE, or mend the configuration"};
  }
  const auto taken = std::ranges::find_if(network.bound, [&](const BoundPort& bound) {
    return bound.local.port == door.listen.port && (bound.local.address == 0 || door.listen.address == 0 ||
                                                    bound.local.address == door.listen.address);
  });
  if (taken == network.bound.end()) return {Grade::pass, subject, port + " is free for the gateway", ""};
  if (taken->program == kGateway) return {Grade::pass, subject, "the gateway has " + port, ""};
  if (taken->program.empty()) {
    return {Grade::warn, subject, "somebody has " + port + "; whose process it is, is hidden from this user",
            "sudo motionlab doctor tells whose it is; the gateway should be the only one"};
  }
  return {Grade::fail, subject, taken->program + " has " + port, "end it: the gateway has to listen there"};
}

/// The interfaces that devices or DDS come in by: with a configured address; all, where none is named.
std::vector<const Interface*> used(const Network& network, const service::GatewayConfig& config) {
  std::vector<const Interface*> all;
  const auto use = [&](const Interface& interface) {
    const auto same = [&](const Interface* other) { return other->name == interface.name; };
    if (!interface.loopback && std::ranges::none_of(all, same)) all.push_back(&interface);
  };
  for (const Door& door : doors(config)) {
    if (const Interface* const found = with_address(network, door.listen.address)) use(*found);
  }
  for (const Interface& interface : network.interfaces) {
    const auto& named = config.bus.interface_whitelist;
    if (named.empty() || std::ranges::find(named, address_to_string(interface.address)) != named.end())
      use(interface);
  }
  return all;
}

/// @param by_multicast  DDS programs of other hosts are found by it
void judge_interface(const Interface& interface, bool by_multicast, Findings& say) {
  const std::string subject = "interface " + interface.name;
  if (!interface.up) {
    say.push_back(
        {Grade::fail, subject, "is down, or without a cable", "ip link set " + interface.name + " up"});
    return;
  }
  if (!interface.multicast && by_multicast) {
    say.push_back({Grade::warn, subject, "carries no multicast: DDS programs of other hosts are not found",
                   "ip link set " + interface.name + " multicast on; or name [bus] peers, or a server"});
  }
  if (interface.held_back_us.value_or(0) > kHeldBackTooLong_us) {
    say.push_back({Grade::warn, subject,
                   "holds datagrams back for " + std::to_string(*interface.held_back_us) + " us",
                   "ethtool -C " + interface.name + " adaptive-rx off rx-usecs 0"});
  } else if (interface.multicast || !by_multicast) {
    say.push_back({Grade::pass, subject,
                   std::string{"up, with"} + (interface.multicast ? "" : "out") + " multicast, at " +
                       address_to_string(interface.address),
                   ""});
  }
}

}  // namespace

std::vector<BoundPort> bound_ports(std::string_view table) {
  std::vector<BoundPort> all;
  std::istringstream in{std::string(table)};
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string slot, local, skipped, inode;
    words >> slot >> local;
    for (int i = 0; i < 7; ++i)
      words >> skipped;  // remote, state, queues, timer, retransmissions, user, timeout
    words >> inode;
    const auto colon = local.find(':');
    std::uint32_t address = 0;
    BoundPort port;
    const auto hex = [&](std::size_t from, std::size_t to, auto& value) {
      const auto [end, bad] = std::from_chars(local.data() + from, local.data() + to, value, 16);
      return bad == std::errc{} && end == local.data() + to;
    };
    if (colon == std::string::npos || !hex(0, colon, address) ||
        !hex(colon + 1, local.size(), port.local.port))
      continue;
    port.local.address = ntohl(address);
    std::from_chars(inode.data(), inode.data() + inode.size(), port.inode);
    all.push_back(port);
  }
  return all;
}

Network look_at_network() {
  std::ostringstream table;
  table << std::ifstream("/proc/net/udp").rdbuf();
  Network network{interfaces(), bound_ports(table.str())};
  const auto programs = programs_by_socket();
  for (BoundPort& port : network.bound) {
    const auto owner = programs.find(port.inode);
    if (owner != programs.end()) port.program = owner->second;
  }
  return network;
}

Findings judge(const Network& network, const service::GatewayConfig& config) {
  Findings say;
  for (const std::string& address : config.bus.interface_whitelist) {
    if (!with_address(network, Endpoint::parse_address(address))) {
      say.push_back({Grade::fail, "[bus] interfaces", address + " is no address of this host",
                     "give addresses of this host, or [] for all"});
    }
  }
  const bool by_multicast = config.bus.peers.empty() && config.bus.server.empty();
  for (const Interface* const interface : used(network, config))
    judge_interface(*interface, by_multicast, say);
  for (const Door& door : doors(config)) say.push_back(judge_door(network, door));
  return say;
}

}  // namespace motionlab::doctor
