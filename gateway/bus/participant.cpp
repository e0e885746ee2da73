#include "gateway/bus/participant.hpp"

#include <ifaddrs.h>
#include <limits.h>
#include <netdb.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/xmlparser/XMLProfileManager.h>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/log/StdoutErrConsumer.hpp>

#include "drivers/core/error.hpp"
#include "gateway/bus/discovery.hpp"
#include "gateway/bus/security.hpp"
#include "gateway/bus/type_support.hpp"

namespace motionlab::bus {
namespace {

namespace fast = eprosima::fastdds::dds;

constexpr int kMaxDomain = 232;  // beyond it the port numbers end

/// What Fast DDS complains about goes to standard error: standard output belongs to the program.
void complain_on_standard_error() {
  auto to_stderr = std::make_unique<fast::StdoutErrConsumer>();
  to_stderr->stderr_threshold(fast::Log::Kind::Info);  // all that it says
  fast::Log::ClearConsumers();
  fast::Log::RegisterConsumer(std::move(to_stderr));
}

/// Once per process, before the first participant: the type registry of Fast DDS is not safe against its own
/// discovery threads, and a reader of the same process would otherwise run on the writer's thread.
void prepare_fast_dds() {
  static const bool prepared = [] {
    complain_on_standard_error();
#define MOTIONLAB_REGISTER(Type) (void)TwinOf<topic::Type>::Twin{};
    MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_REGISTER)
#undef MOTIONLAB_REGISTER
    eprosima::fastrtps::LibrarySettingsAttributes settings;
    settings.intraprocess_delivery = eprosima::fastrtps::INTRAPROCESS_OFF;
    eprosima::fastrtps::xmlparser::XMLProfileManager::library_settings(settings);
    return true;
  }();
  (void)prepared;
}

[[nodiscard]] std::vector<std::string> addresses_of_this_host() {
  std::vector<std::string> addresses;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return addresses;
  for (const ifaddrs* entry = list; entry; entry = entry->ifa_next) {
    std::array<char, NI_MAXHOST> text{};
    if (entry->ifa_addr && entry->ifa_addr->sa_family == AF_INET &&
        getnameinfo(entry->ifa_addr, sizeof(sockaddr_in), text.data(), text.size(), nullptr, 0,
                    NI_NUMERICHOST) == 0) {
      addresses.emplace_back(text.data());
    }
  }
  freeifaddrs(list);
  return addresses;
}

void check(const DdsConfig& config) {
  if (config.domain < 0 || config.domain > kMaxDomain) {
    throw StartupError{"DDS domain " + std::to_string(config.domain) +
                       " does not exist: choose one from 0 to " + std::to_string(kMaxDomain)};
  }
  if (config.interface_whitelist.empty()) return;
  const std::vector<std::string> known = addresses_of_this_host();
  for (const std::string& wanted : config.interface_whitelist) {
    if (std::ranges::find(known, wanted) != known.end()) continue;
    std::string text = "DDS shall use the interface " + wanted + ", which this host does not have. It has";
    for (const std::string& address : known) text += " " + address;
    throw StartupError{text + ": choose one of these, or none to use them all"};
  }
}

[[nodiscard]] fast::DomainParticipantQos participant_qos(const DdsConfig& config) {
  fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
  qos.name(config.participant.c_str());
  // The names that Cyclone gives to the same facts.
  std::array<char, HOST_NAME_MAX + 1> host{};
  if (gethostname(host.data(), host.size() - 1) == 0) {
    qos.properties().properties().emplace_back("__Hostname", host.data(), true);
  }
  qos.properties().properties().emplace_back("__Pid", std::to_string(getpid()), true);
  qos.transport().use_builtin_transports = false;
  const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
  udp->interfaceWhiteList = config.interface_whitelist;
  udp->maxInitialPeersRange = kParticipantsOfAHost;
  qos.transport().user_transports.push_back(udp);
  set_discovery(qos, config,
                config.interface_whitelist.empty() ? addresses_of_this_host() : config.interface_whitelist);
  if (!config.security.empty()) set_security(qos, config.security);
  return qos;
}

std::string why_not_started(const DdsConfig& config) {
  std::string text = "DDS did not start on domain " + std::to_string(config.domain) +
                     ": see whether other programs use up its UDP ports, or choose another [bus] domain";
  if (config.security.empty()) return text;
  return text + "; or see whether the identity in " + config.security +
         " has expired or was not made by its own authority.pem: Fast DDS says above what it refuses";
}

}  // namespace

fast::DomainParticipant* create_participant(const DdsConfig& config,
                                            fast::DomainParticipantListener* listener) {
  check(config);
  prepare_fast_dds();
  fast::DomainParticipant* const participant =
      fast::DomainParticipantFactory::get_instance()->create_participant(
          static_cast<std::uint32_t>(config.domain), participant_qos(config), listener,
          fast::StatusMask::none());
  if (!participant) {
    throw StartupError{why_not_started(config)};
  }
  return participant;
}

DdsId id_of(const eprosima::fastrtps::rtps::GUID_t& guid) {
  DdsId id;
  std::copy_n(guid.guidPrefix.value, 12, id.bytes.begin());
  std::copy_n(guid.entityId.value, 4, id.bytes.begin() + 12);
  return id;
}

void delete_participant(fast::DomainParticipant* participant) {
  participant->delete_contained_entities();
  fast::DomainParticipantFactory::get_instance()->delete_participant(participant);
}

}  // namespace motionlab::bus
