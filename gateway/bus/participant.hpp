/// @file  A DDS participant as the house wants it: UDP only, types registered first, quick to notice who
/// comes and who is gone. Seen by the sources of this folder alone.
#pragma once

#include <fastdds/dds/domain/DomainParticipant.hpp>

#include "gateway/bus/dds_bus.hpp"

namespace motionlab::bus {

/// @throws StartupError  with advice: unknown interface, bad domain, no participant
[[nodiscard]] eprosima::fastdds::dds::DomainParticipant* make_participant(const DdsConfig& config);

/// With everything that was created in it. Its listeners must still be alive.
void delete_participant(eprosima::fastdds::dds::DomainParticipant* participant);

}  // namespace motionlab::bus
