/// @file  The three ways in which participants find each other, said in Fast DDS. Seen by participant.cpp
/// alone.
#pragma once

#include <string>
#include <vector>

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>

#include "gateway/bus/dds_config.hpp"

namespace motionlab::bus {

/// So many participants of one host are found by those who know nothing but its address.
inline constexpr unsigned kParticipantsOfAHost = 16;

/// By multicast, by the addresses of the other hosts, or by a discovery server, as `config` says.
/// @param own_addresses  of this host, where its other programs are found
/// @throws StartupError  peers and server at once, a server and security at once, or what is no address
void set_discovery(eprosima::fastdds::dds::DomainParticipantQos& qos, const DdsConfig& config,
                   const std::vector<std::string>& own_addresses);

}  // namespace motionlab::bus
