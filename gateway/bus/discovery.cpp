#include "gateway/bus/discovery.hpp"

#include <fastdds/rtps/attributes/ServerAttributes.h>
#include <fastrtps/utils/IPLocator.h>

#include "drivers/core/endpoint.hpp"
#include "drivers/core/error.hpp"

namespace motionlab::bus {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::Duration_t;

/// The name that every server has which was started as number 0: the one that ROS 2 expects, too.
constexpr const char* kServerPrefix = "44.53.00.5f.45.50.52.4f.53.49.4d.41";

/// Port 0: all that the participants of a host may have.
rtps::Locator_t locator(const std::string& address, std::uint16_t port = 0) {
  rtps::Locator_t where;
  rtps::IPLocator::createLocator(LOCATOR_KIND_UDPv4, address, port, where);
  return where;
}

void find_by_address(fast::DomainParticipantQos& qos, const std::vector<std::string>& peers,
                     const std::vector<std::string>& own_addresses) {
  auto& builtin = qos.wire_protocol().builtin;
  // A place to be found at that is named keeps Fast DDS from joining the multicast group as well.
  for (const std::string& address : own_addresses) {
    builtin.metatrafficUnicastLocatorList.push_back(locator(address));
    builtin.initialPeersList.push_back(locator(address));
  }
  for (const std::string& address : peers) {
    builtin.initialPeersList.push_back(locator(address_to_string(Endpoint::parse_address(address))));
  }
}

void find_by_server(fast::DomainParticipantQos& qos, const std::string& server) {
  const Endpoint endpoint = Endpoint::parse(server);
  rtps::RemoteServerAttributes remote;
  remote.ReadguidPrefix(kServerPrefix);
  remote.metatrafficUnicastLocatorList.push_back(locator(address_to_string(endpoint.address), endpoint.port));
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  // A plain client is told only of those it has a topic in common with; who lists everybody needs them all.
  discovery.discoveryProtocol = rtps::DiscoveryProtocol_t::SUPER_CLIENT;
  discovery.discoveryServer_client_syncperiod = Duration_t{0.1L};
  discovery.m_DiscoveryServers.push_back(remote);
}

}  // namespace

void set_discovery(fast::DomainParticipantQos& qos, const DdsConfig& config,
                   const std::vector<std::string>& own_addresses) {
  auto& discovery = qos.wire_protocol().builtin.discovery_config;
  // The defaults let one start in ten wait three seconds for its peers, and a killed peer live on for twenty.
  discovery.initial_announcements.count = 30;
  discovery.initial_announcements.period = Duration_t{0.05L};
  discovery.leaseDuration = Duration_t{2.0L};
  discovery.leaseDuration_announcementperiod = Duration_t{0.6L};
  if (!config.peers.empty() && !config.server.empty()) {
    throw StartupError{"DDS shall find others by their addresses (" + config.peers.front() +
                       ", …) and by the discovery server " + config.server + ": choose one"};
  }
  if (!config.server.empty() && !config.security.empty()) {
    throw StartupError{"DDS security: the discovery server " + config.server +
                       " has no identity, so nobody would be found: name peers, or use multicast"};
  }
  if (!config.peers.empty()) find_by_address(qos, config.peers, own_addresses);
  if (!config.server.empty()) find_by_server(qos, config.server);
}

}  // namespace motionlab::bus
