/// @file  One DDS participant as every program of the house makes it. Seen by the .cpp files of this folder
/// alone.
#pragma once

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>

#include "gateway/bus/dds_config.hpp"
#include "gateway/bus/dds_id.hpp"

namespace motionlab::bus {

/// UDP only, short discovery, and every type of the house registered with Fast DDS before the participant
/// exists. Tells its host and process number to those who ask who is on the bus.
/// @param listener  told of everybody who comes and goes, may be null; must outlive the participant
/// @throws StartupError  with advice: unknown interface, bad domain, no participant
[[nodiscard]] eprosima::fastdds::dds::DomainParticipant* create_participant(
    const DdsConfig& config, eprosima::fastdds::dds::DomainParticipantListener* listener = nullptr);

/// The name that Fast DDS has, as the house writes it.
[[nodiscard]] DdsId id_of(const eprosima::fastrtps::rtps::GUID_t& guid);

/// With all that belongs to it.
void delete_participant(eprosima::fastdds::dds::DomainParticipant* participant);

}  // namespace motionlab::bus
