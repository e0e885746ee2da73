#include "gateway/bus/dds_watch.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>

#include <fastdds/rtps/participant/ParticipantDiscoveryInfo.h>
#include <fastdds/rtps/reader/ReaderDiscoveryInfo.h>
#include <fastdds/rtps/writer/WriterDiscoveryInfo.h>
#include <fastrtps/utils/IPLocator.h>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include "drivers/core/error.hpp"
#include "gateway/bus/participant.hpp"
#include "gateway/bus/type_support.hpp"

namespace motionlab::bus {
namespace {

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

constexpr std::size_t kMaxSeen =
    10000;  // of participants, and of endpoints: a stranger may announce any number
constexpr int kReaderDepth = 64;

/// The participant that an endpoint belongs to: the first twelve bytes.
DdsId participant_id(DdsId id) {
  std::fill(id.bytes.begin() + 12, id.bytes.end(), std::uint8_t{0});
  return id;
}

Durability durability_of(fast::DurabilityQosPolicyKind kind) {
  switch (kind) {
    case fast::TRANSIENT_LOCAL_DURABILITY_QOS:
      return Durability::transient_local;
    case fast::TRANSIENT_DURABILITY_QOS:
      return Durability::transient;
    case fast::PERSISTENT_DURABILITY_QOS:
      return Durability::persistent;
    case fast::VOLATILE_DURABILITY_QOS:
      break;
  }
  return Durability::not_kept;
}

template <class Qos>
SeenQos qos_of(const Qos& from) {
  SeenQos qos;
  qos.reliable = from.m_reliability.kind == fast::RELIABLE_RELIABILITY_QOS;
  qos.durability = durability_of(from.m_durability.kind);
  qos.exclusive = from.m_ownership.kind == fast::EXCLUSIVE_OWNERSHIP_QOS;
  const auto& deadline = from.m_deadline.period;
  if (deadline < eprosima::fastrtps::c_TimeInfinite)
    qos.deadline_s = 1e-9 * static_cast<double>(deadline.to_ns());
  const auto& kinds = from.representation.m_value;  // none said: XCDR1
  qos.xcdr1 = kinds.empty() ||
              std::ranges::find(kinds, fast::DataRepresentationId_t::XCDR_DATA_REPRESENTATION) != kinds.end();
  for (const std::string& name : from.m_partition.getNames()) {
    if (!name.empty()) qos.partitions.push_back(name);
  }
  return qos;
}

std::string address_of(const rtps::ParticipantProxyData& data) {
  for (const auto* const list : {&data.default_locators.unicast, &data.metatraffic_locators.unicast}) {
    for (const rtps::Locator_t& locator : *list) {
      if (locator.kind == LOCATOR_KIND_UDPv4 || locator.kind == LOCATOR_KIND_TCPv4) {
        return rtps::IPLocator::toIPv4string(locator);
      }
    }
  }
  return {};
}

SeenParticipant seen(const rtps::ParticipantProxyData& data) {
  SeenParticipant participant{.id = participant_id(id_of(data.m_guid)),
                              .name = data.m_participantName.to_string(),
                              .host = {},
                              .process = {}};
  for (auto it = data.m_properties.begin(); it != data.m_properties.end(); ++it) {
    if (it->first() == "__Hostname") participant.host = it->second();
    if (it->first() == "__Pid") participant.process = it->second();
  }
  if (participant.host.empty()) participant.host = address_of(data);
  return participant;
}

fast::DataReaderQos reader_qos_for(const SeenQos& wanted) {
  fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
  qos.reliability().kind =
      wanted.reliable ? fast::RELIABLE_RELIABILITY_QOS : fast::BEST_EFFORT_RELIABILITY_QOS;
  qos.durability().kind = wanted.durability >= Durability::transient_local
                              ? fast::TRANSIENT_LOCAL_DURABILITY_QOS
                              : fast::VOLATILE_DURABILITY_QOS;
  qos.ownership().kind = wanted.exclusive ? fast::EXCLUSIVE_OWNERSHIP_QOS : fast::SHARED_OWNERSHIP_QOS;
  qos.history().kind = fast::KEEP_LAST_HISTORY_QOS;
  qos.history().depth = kReaderDepth;
  qos.resource_limits().max_instances = kMaxReadInstances;
  qos.resource_limits().max_samples_per_instance = kReaderDepth;
  qos.resource_limits().max_samples = kMaxReadInstances * kReaderDepth;
  qos.resource_limits().allocated_samples = kReaderDepth;
  qos.data_sharing().off();
  qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
  return qos;
}

}  // namespace

std::string_view to_string(Durability durability) noexcept {
  constexpr std::array<std::string_view, 4> kNames{"volatile", "transient_local", "transient", "persistent"};
  const auto index = static_cast<std::size_t>(durability);
  return index < kNames.size() ? kNames[index] : std::string_view{"?"};
}

SeenQos satisfied_by_all(const std::vector<SeenEndpoint>& writers) {
  SeenQos asked;
  if (writers.empty()) return asked;
  asked.reliable =
      std::ranges::all_of(writers, [](const SeenEndpoint& writer) { return writer.qos.reliable; });
  asked.durability = std::ranges::min(writers, {}, [](const SeenEndpoint& writer) {
                       return writer.qos.durability;
                     }).qos.durability;
  asked.exclusive =
      std::ranges::all_of(writers, [](const SeenEndpoint& writer) { return writer.qos.exclusive; });
  bool in_default = false;
  for (const SeenEndpoint& writer : writers) {
    in_default = in_default || writer.qos.partitions.empty();
    asked.partitions.insert(asked.partitions.end(), writer.qos.partitions.begin(),
                            writer.qos.partitions.end());
  }
  std::ranges::sort(asked.partitions);
  const auto repeated = std::ranges::unique(asked.partitions);
  asked.partitions.erase(repeated.begin(), repeated.end());
  // The default partition is the one without a name; beside others it must be said.
  if (in_default && !asked.partitions.empty()) asked.partitions.insert(asked.partitions.begin(), "");
  return asked;
}

/// Told by the discovery threads of Fast DDS.
struct DdsWatch::Impl : public fast::DomainParticipantListener {
  Impl(const DdsConfig& config, std::shared_ptr<Wakeup> to_ring)
      : wakeup{to_ring ? std::move(to_ring) : std::make_shared<Wakeup>()},
        participant{create_participant(config, this)} {}
  ~Impl() override { delete_participant(participant); }

  void on_participant_discovery(fast::DomainParticipant*, rtps::ParticipantDiscoveryInfo&& told) override {
    const bool gone = told.status == rtps::ParticipantDiscoveryInfo::REMOVED_PARTICIPANT ||
                      told.status == rtps::ParticipantDiscoveryInfo::DROPPED_PARTICIPANT;
    change([&] {
      keep(people, participant_id(id_of(told.info.m_guid)), gone, [&] { return seen(told.info); });
    });
  }

  void on_publisher_discovery(fast::DomainParticipant*, rtps::WriterDiscoveryInfo&& told) override {
    const bool gone = told.status == rtps::WriterDiscoveryInfo::REMOVED_WRITER;
    note(told.info, gone, true);
  }

  void on_subscriber_discovery(fast::DomainParticipant*, rtps::ReaderDiscoveryInfo&& told) override {
    const bool gone = told.status == rtps::ReaderDiscoveryInfo::REMOVED_READER;
    note(told.info, gone, false);
  }

  template <class Proxy>
  void note(const Proxy& proxy, bool gone, bool writes) {
    change([&] {
      keep(ends, id_of(proxy.guid()), gone, [&] {
        SeenEndpoint end;
        end.id = id_of(proxy.guid());
        end.writes = writes;
        end.topic = proxy.topicName().to_string();
        end.type = proxy.typeName().to_string();
        end.qos = qos_of(proxy.m_qos);
        return end;
      });
    });
  }

  template <class F>
  void change(F&& f) {
    {
      const std::lock_guard lock{mutex};
      f();
    }
    changes.fetch_add(1, std::memory_order_release);
    wakeup->ring();
  }

  template <class Value, class Make>
  static void keep(std::map<DdsId, Value>& all, const DdsId& id, bool gone, Make&& make) {
    if (gone) {
      all.erase(id);
    } else if (all.size() < kMaxSeen || all.contains(id)) {
      all.insert_or_assign(id, make());
    }
  }

  template <class Wanted>
  std::vector<SeenEndpoint> endpoints_that(Wanted&& wanted) const {
    const std::lock_guard lock{mutex};
    const DdsId self = participant_id(id_of(participant->guid()));
    std::vector<SeenEndpoint> found;
    for (const auto& [id, end] : ends) {
      if (participant_id(id) == self || !wanted(end)) continue;
      found.push_back(end);
      if (const auto owner = people.find(participant_id(id)); owner != people.end()) {
        found.back().participant = owner->second.name;
        found.back().host = owner->second.host;
        found.back().process = owner->second.process;
      }
    }
    return found;
  }

  const std::shared_ptr<Wakeup> wakeup;
  mutable std::mutex mutex;
  std::map<DdsId, SeenParticipant> people;
  std::map<DdsId, SeenEndpoint> ends;
  std::atomic<std::uint64_t> changes{0};  ///< of `ends` or `people`
  fast::DomainParticipant* const participant;
};

/// The reader behind a tap, and its listener. Takes on the receive threads of Fast DDS, so that nothing is
/// overwritten in the reader's history while the user's terminal is slow.
template <class T>
class DdsWatch::Ear final : private fast::DataReaderListener {
 public:
  Ear(Impl& impl, const std::string& topic) : impl_{impl} {
    fast::TypeSupport type{new TypeSupport<T>{}};
    if (type.register_type(impl.participant) == ReturnCode_t::RETCODE_OK) {
      topic_ = impl.participant->create_topic(topic, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
    }
    if (!topic_) {
      throw StartupError{"DDS refuses to hear " + topic +
                         ": it is heard already, or its name is not allowed"};
    }
    adapt();
  }

  ~Ear() override {
    close();
    impl_.participant->delete_topic(topic_);
  }

  std::optional<Heard<T>> next() {
    adapt();
    const std::lock_guard lock{mutex_};
    if (queue_.empty()) return std::nullopt;
    std::optional<Heard<T>> heard{queue_.front()};
    queue_.pop_front();
    return heard;
  }

  [[nodiscard]] std::uint64_t overflowed() const {
    const std::lock_guard lock{mutex_};
    return overflowed_;
  }

 private:
  /// Begins with the first writer. Asks for less when a new one offers less, and looks in its partition too.
  /// Never for more: that would bring kept samples again.
  void adapt() {
    const std::uint64_t changes = impl_.changes.load(std::memory_order_acquire);
    if (changes == changes_seen_) return;
    changes_seen_ = changes;
    const std::vector<SeenEndpoint> writers = impl_.endpoints_that([this](const SeenEndpoint& end) {
      return end.writes && end.topic == topic_->get_name() && end.type == T::kTypeName;
    });
    if (writers.empty()) return;  // what they will offer is not known yet
    SeenQos asked = satisfied_by_all(writers);
    if (reader_) {
      asked.reliable = asked.reliable && asked_.reliable;
      asked.durability = std::min(asked.durability, asked_.durability);
      if (asked == asked_) return;
    }
    open(asked);
  }

  void open(const SeenQos& asked) {
    close();
    fast::SubscriberQos group = fast::SUBSCRIBER_QOS_DEFAULT;
    for (const std::string& name : asked.partitions) group.partition().push_back(name.c_str());
    subscriber_ = impl_.participant->create_subscriber(group);
    if (subscriber_) reader_ = subscriber_->create_datareader(topic_, reader_qos_for(asked), this);
    if (!reader_) throw StartupError{"DDS makes no reader of " + topic_->get_name() + "; its log says more"};
    asked_ = asked;
  }

  void close() {
    if (reader_) subscriber_->delete_datareader(reader_);
    if (subscriber_) impl_.participant->delete_subscriber(subscriber_);
    reader_ = nullptr;
    subscriber_ = nullptr;
  }

  void on_data_available(fast::DataReader* reader) override {
    const std::lock_guard one_at_a_time{taking_};
    fast::SampleInfo info;
    while (reader->take_next_sample(&carried_, &info) == ReturnCode_t::RETCODE_OK) {
      Heard<T> heard;
      heard.data = info.valid_data;
      if (heard.data) {
        heard.sample = carried_.sample;
        heard.refusal = carried_.refusal;
      }
      heard.writer = id_of(info.sample_identity.writer_guid());
      heard.writer_sequence = info.sample_identity.sequence_number().to64long();
      heard.t_written_ns = info.source_timestamp.to_ns();
      heard.t_heard_ns = info.reception_timestamp.to_ns();
      const std::lock_guard lock{mutex_};
      if (queue_.size() < Tap<T>::kQueueDepth) {
        queue_.push_back(heard);
      } else {
        ++overflowed_;
      }
    }
    impl_.wakeup->ring();
  }

  Impl& impl_;
  fast::Topic* topic_ = nullptr;
  fast::Subscriber* subscriber_ = nullptr;
  fast::DataReader* reader_ = nullptr;
  SeenQos asked_;
  std::uint64_t changes_seen_ = ~std::uint64_t{0};
  std::mutex taking_;
  Carried<T> carried_;
  mutable std::mutex mutex_;
  std::deque<Heard<T>> queue_;
  std::uint64_t overflowed_ = 0;
};

DdsWatch::DdsWatch(const DdsConfig& config, std::shared_ptr<Wakeup> wakeup)
    : impl_{std::make_unique<Impl>(config, std::move(wakeup))} {}
DdsWatch::~DdsWatch() = default;

std::vector<SeenParticipant> DdsWatch::participants() const {
  const std::lock_guard lock{impl_->mutex};
  const DdsId self = participant_id(id_of(impl_->participant->guid()));
  std::vector<SeenParticipant> found;
  for (const auto& [id, participant] : impl_->people) {
    if (id != self) found.push_back(participant);
  }
  return found;
}

std::vector<SeenEndpoint> DdsWatch::endpoints() const {
  return impl_->endpoints_that([](const SeenEndpoint&) { return true; });
}

std::vector<SeenEndpoint> DdsWatch::writers_of(std::string_view topic) const {
  return impl_->endpoints_that([topic](const SeenEndpoint& end) { return end.writes && end.topic == topic; });
}

template <class T>
DdsWatch::Tap<T> DdsWatch::hear(const std::string& topic) {
  return Tap<T>{std::make_unique<Ear<T>>(*impl_, topic)};
}

template <class T>
DdsWatch::Tap<T>::Tap(std::unique_ptr<Ear<T>> ear) : ear_{std::move(ear)} {}
template <class T>
DdsWatch::Tap<T>::Tap(Tap&&) noexcept = default;
template <class T>
DdsWatch::Tap<T>& DdsWatch::Tap<T>::operator=(Tap&&) noexcept = default;
template <class T>
DdsWatch::Tap<T>::~Tap() = default;

template <class T>
std::optional<Heard<T>> DdsWatch::Tap<T>::next() {
  return ear_->next();
}

template <class T>
std::uint64_t DdsWatch::Tap<T>::overflowed() const {
  return ear_->overflowed();
}

#define MOTIONLAB_HEAR(Type)                 \
  template class DdsWatch::Tap<topic::Type>; \
  template DdsWatch::Tap<topic::Type> DdsWatch::hear<topic::Type>(const std::string&);
MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_HEAR)
#undef MOTIONLAB_HEAR

}  // namespace motionlab::bus
