/// @file  DDS Security, said in Fast DDS: who a participant is, and what it may write and read. Seen by
/// participant.cpp alone.
#pragma once

#include <string>

#include <fastdds/dds/domain/qos/DomainParticipantQos.hpp>

namespace motionlab::bus {

/// Authentication, access control and encryption with the identity in this folder (deploy/security makes such
/// folders).
/// @throws StartupError  a file is missing or cannot be read, or others than its owner can read the private
/// key
void set_security(eprosima::fastdds::dds::DomainParticipantQos& qos, const std::string& folder);

}  // namespace motionlab::bus
