/// @file  A peer that claims our type and sends whatever it likes.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cstring>
#include <functional>
#include <memory>
#include <set>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/dds_tap.hpp"
#include "gateway/bus/topic_list.hpp"
#include "tests/support/own_domain.hpp"

namespace motionlab::bus {
namespace {

namespace fast = eprosima::fastdds::dds;
using Bytes = std::vector<unsigned char>;

/// Sends the bytes as they are.
class AnyBytes final : public fast::TopicDataType {
 public:
  explicit AnyBytes(std::string_view claimed_name) {
    setName(std::string{claimed_name}.c_str());
    m_typeSize = 16'384;
    m_isGetKeyDefined = true;
    auto_fill_type_information(false);
    auto_fill_type_object(false);
  }
  bool serialize(void* data, eprosima::fastrtps::rtps::SerializedPayload_t* payload) override {
    const auto& bytes = *static_cast<const Bytes*>(data);
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    return true;
  }
  bool deserialize(eprosima::fastrtps::rtps::SerializedPayload_t*, void*) override { return false; }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  /// A hash of all bytes, whatever the key is.
  bool getKey(void* data, eprosima::fastrtps::rtps::InstanceHandle_t* handle, bool) override {
    std::size_t n = 0;
    for (const unsigned char byte : *static_cast<const Bytes*>(data)) {
      auto& value = handle->value[n++ % 16];
      value = static_cast<unsigned char>(31 * value + byte + 1);
    }
    return true;
  }
};

class HostilePeer {
 public:
  HostilePeer(int domain, const std::string& topic_name, std::string_view type_name) {
    fast::DomainParticipantQos qos = fast::PARTICIPANT_QOS_DEFAULT;
    const auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList = {"127.0.0.1"};
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(udp);
    auto* const factory = fast::DomainParticipantFactory::get_instance();
    participant_ = factory->create_participant(static_cast<std::uint32_t>(domain), qos);
    fast::TypeSupport type{new AnyBytes{type_name}};
    type.register_type(participant_);
    auto* const topic = participant_->create_topic(topic_name, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
    fast::DataWriterQos writer_qos = fast::DATAWRITER_QOS_DEFAULT;
    writer_qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    writer_qos.resource_limits().max_instances = 1000;
    writer_qos.resource_limits().max_samples = 1000;
    writer_qos.resource_limits().max_samples_per_instance = 1;
    writer_ =
        participant_->create_publisher(fast::PUBLISHER_QOS_DEFAULT)->create_datawriter(topic, writer_qos);
  }
  ~HostilePeer() {
    participant_->delete_contained_entities();
    fast::DomainParticipantFactory::get_instance()->delete_participant(participant_);
  }
  void send(Bytes bytes) { writer_->write(&bytes); }
  [[nodiscard]] bool has_reader() const {
    fast::PublicationMatchedStatus status;
    writer_->get_publication_matched_status(status);
    return status.current_count > 0;
  }
  /// Everything that was sent has arrived.
  [[nodiscard]] bool heard() {
    return writer_->wait_for_acknowledgments({60, 0}) == eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK;
  }

 private:
  fast::DomainParticipant* participant_ = nullptr;
  fast::DataWriter* writer_ = nullptr;
};

bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + 60s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

Bytes request(const std::string& requester, unsigned char action) {
  Bytes bytes{0, 1, 0, 0};
  const auto size = static_cast<std::uint32_t>(requester.size() + 1);
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<unsigned char>(size >> shift));
  bytes.insert(bytes.end(), requester.begin(), requester.end());
  bytes.push_back(0);
  while ((bytes.size() - 4) % 8 != 0) bytes.push_back(0);
  bytes.insert(bytes.end(), 16, 0);
  bytes.insert(bytes.end(), {action, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0});
  return bytes;
}

Bytes request(std::size_t requester_size, unsigned char action) {
  return request(std::string(requester_size, 'r'), action);
}

TEST(HostilePeer, ThatGoesAndLeavesManyNamesBehindTakesNothingWithIt) {
  const int domain = test::own_domain();
  DdsConfig config;
  config.domain = domain;
  config.interface_whitelist = {"127.0.0.1"};
  const std::size_t row = topic_index<topic::ModeRequest>();
  DdsTap dut{config, {.topics = {row}}};  // takes nothing by itself: the samples wait
  constexpr int kPeers = 3, kNames = kMaxWrittenInstances;
  for (int number = 0; number < kPeers; ++number) {
    {
      HostilePeer peer{domain, "motionlab/mode_request", topic::ModeRequest::kTypeName};
      ASSERT_TRUE(eventually([&] { return dut.writers(row) == 1 && peer.has_reader(); }));
      for (int n = 0; n < kNames; ++n) {
        peer.send(request("peer " + std::to_string(number) + " name " + std::to_string(n), 1));
      }
      ASSERT_TRUE(peer.heard());
    }
    ASSERT_TRUE(eventually([&] { return dut.writers(row) == 0; }));
  }
  std::set<std::string> names;
  while (dut.take([&](const TappedSample& sample) { names.emplace(sample.instance); }) > 0) continue;
  EXPECT_EQ(names.size(), std::size_t{kPeers * kNames});
}

TEST(HostilePeer, IsSurvivedAndCounted) {
  const int domain = test::own_domain();
  LocalBus local;
  DdsConfig config;
  config.domain = domain;
  config.interface_whitelist = {"127.0.0.1"};
  DdsBus dut{config, local};
  dut.in<topic::ModeRequest>();
  dut.start();
  auto inbox = local.subscribe<topic::ModeRequest>();
  HostilePeer peer{domain, "motionlab/mode_request", topic::ModeRequest::kTypeName};
  ASSERT_TRUE(eventually([&] { return dut.matched<topic::ModeRequest>() == 1; }));

  const auto refused_within = [&](Bytes bytes, std::uint64_t DdsCounters::*counter) {
    const std::uint64_t before = dut.counters().*counter;
    return eventually([&] {
      peer.send(bytes);
      return dut.counters().*counter > before;
    });
  };
  EXPECT_TRUE(refused_within({0, 1, 0, 0}, &DdsCounters::refused_malformed));
  EXPECT_TRUE(refused_within({1}, &DdsCounters::refused_malformed));
  EXPECT_TRUE(refused_within({0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff}, &DdsCounters::refused_malformed));
  EXPECT_TRUE(refused_within(request(300, 0), &DdsCounters::refused_text));
  EXPECT_TRUE(refused_within(request(4000, 0), &DdsCounters::refused_text));
  EXPECT_TRUE(refused_within(request(4, 200), &DdsCounters::refused_enum));
  EXPECT_FALSE(inbox.next()) << "nothing of that was handed on";

  EXPECT_TRUE(eventually([&] {  // and the topic still works
    peer.send(request(4, 1));
    const auto sample = inbox.next();
    return sample && sample->requester.view() == "rrrr" && sample->action == topic::ModeAction::engage;
  }));
}

/// Requests as fast as the machine lets a peer send them, at least ten thousand a second where it can.
class Flood {
 public:
  explicit Flood(HostilePeer& peer)
      : thread_{[this, &peer] {
          for (unsigned n = 0; !over_; ++n) {
            peer.send(request(4 + n % 20, n % 2 ? kEngage : kAuthority));
            ++sent_;
            if (n % 100 == 99) std::this_thread::sleep_for(5ms);
          }
        }} {}
  ~Flood() {
    over_ = true;
    thread_.join();
  }
  [[nodiscard]] std::uint64_t sent() const { return sent_; }

 private:
  static constexpr unsigned char kEngage = 1, kAuthority = 3;
  std::atomic<bool> over_{false};
  std::atomic<std::uint64_t> sent_{0};
  std::thread thread_;
};

TEST(HostilePeer, FloodingRequestsNeitherFillsTheStepNorDrownsASettleThatIsSaidOnce) {
  const int domain = test::own_domain();
  const auto loopback = [domain](const char* name) {
    DdsConfig config;
    config.domain = domain;
    config.interface_whitelist = {"127.0.0.1"};
    config.participant = name;
    return config;
  };
  LocalBus local, elsewhere;
  DdsBus dut{loopback("gateway"), local}, hand{loopback("hand"), elsewhere};
  dut.in<topic::ModeRequest>();
  hand.out<topic::ModeRequest>();
  auto inbox = local.subscribe<topic::ModeRequest>();
  auto said = elsewhere.advertise<topic::ModeRequest>();
  dut.start();
  hand.start();
  HostilePeer peer{domain, "motionlab/mode_request", topic::ModeRequest::kTypeName};
  ASSERT_TRUE(eventually(
      [&] { return dut.matched<topic::ModeRequest>() == 2 && hand.matched<topic::ModeRequest>() == 1; }));
  const auto begin = std::chrono::steady_clock::now();
  const Flood flood{peer};
  ASSERT_TRUE(eventually([&] { return dut.counters().refused_flood > 1000; })) << flood.sent();

  topic::ModeRequest settle;
  settle.requester = "hand";
  settle.action = topic::ModeAction::settle;
  ASSERT_TRUE(said.publish(settle));
  std::uint64_t handed_on = 0;
  EXPECT_TRUE(eventually([&] {
    while (const auto sample = inbox.next()) {
      ++handed_on;
      if (sample->requester.view() == "hand" && sample->action == topic::ModeAction::settle) return true;
    }
    return false;
  }));
  const std::uint64_t taken = dut.counters().taken;  // before the time is: this thread may stall
  const auto windows = (std::chrono::steady_clock::now() - begin) / Nanoseconds{10ms} + 2;
  EXPECT_LE(taken, 48U * static_cast<std::uint64_t>(windows) + 1);
  EXPECT_GT(handed_on, 0U);
}

}  // namespace
}  // namespace motionlab::bus
