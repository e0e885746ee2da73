#include "gateway/bus/dds_bus.hpp"

#include <pthread.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include "gateway/bus/flood_gate.hpp"
#include "gateway/bus/participant.hpp"
#include "gateway/bus/qos.hpp"
#include "gateway/bus/type_support.hpp"

namespace motionlab::bus {
namespace {

namespace fast = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;
using SteadyTime = std::chrono::steady_clock::time_point;

constexpr std::size_t kTakenAtOnce = 256;     // of one topic, so that a flood leaves the others their turn
constexpr Nanoseconds kLongestSleep = 100ms;  // of the bus thread

struct AtomicCounters {
  using Count = std::atomic<std::uint64_t>;
  Count written{0}, write_failed{0}, taken{0}, refused_instance{0}, refused_flood{0};
  Count deadline_missed{0}, liveliness_lost{0}, incompatible_qos{0};
  std::array<Count, static_cast<std::size_t>(Refusal::count_)> refused{};

  static void add(Count& count, std::uint64_t n = 1) noexcept {
    count.fetch_add(n, std::memory_order_relaxed);
  }
};

/// One topic that is carried in one direction. Also the listener, and thus alive until the endpoints are
/// deleted.
class Link {
 public:
  virtual ~Link() = default;
  /// Moves what there is to move. The bus thread.
  virtual std::size_t run(SteadyTime now) = 0;
  /// When `run` wants to be called without having been rung for.
  [[nodiscard]] virtual SteadyTime due() const noexcept { return SteadyTime::max(); }
  [[nodiscard]] virtual std::uint64_t lost() const noexcept { return 0; }
  [[nodiscard]] std::size_t matched() const noexcept {
    return static_cast<std::size_t>(std::max(matched_.load(std::memory_order_relaxed), 0));
  }

 protected:
  std::atomic<int> matched_{0};
};

template <class T>
class Out final : public Link, private fast::DataWriterListener {
 public:
  Out(LocalBus& local, const std::shared_ptr<Wakeup>& wakeup, AtomicCounters& counters)
      : Out{local, wakeup, counters, TopicTraits<T>::paced, nullptr} {}
  /// @param paced  the newest once per period; who publishes never rings for it
  /// @param arrivals  what comes in by this bus and does not go out again; may be null
  Out(LocalBus& local, const std::shared_ptr<Wakeup>& wakeup, AtomicCounters& counters, bool paced,
      const Publisher<T>* arrivals)
      : counters_{counters},
        paced_{paced},
        samples_{local.subscribe<T>(paced ? nullptr : wakeup, arrivals)} {}

  bool create(fast::Publisher& publisher, fast::Topic& topic, const TopicShape& shape) {
    writer_ = publisher.create_datawriter(&topic, writer_qos(shape), this);
    return writer_ != nullptr;
  }

  std::size_t run(SteadyTime now) override {
    std::size_t count = 0;
    if (paced_) {
      if (now < due_) return 0;
      due_ = SteadyTime{(now.time_since_epoch() / kPeriod + 1) * kPeriod};  // all of a pace in one round
    }
    bool waiting = false;
    while (const auto sample = samples_.next()) {
      if (waiting && !(paced_ && same_instance(carried_.sample, *sample))) count += write();
      carried_.sample = *sample;
      waiting = true;
    }
    return waiting ? count + write() : count;
  }

  [[nodiscard]] SteadyTime due() const noexcept override { return paced_ ? due_ : SteadyTime::max(); }
  [[nodiscard]] std::uint64_t lost() const noexcept override { return samples_.lost(); }

 private:
  static constexpr Nanoseconds kPeriod = std::max(from_seconds(TopicTraits<T>::period_s), Nanoseconds{1});

  static bool same_instance(const T& a, const T& b) noexcept {
    if constexpr (T::kKeyed) {
      return a.key() == b.key();
    } else {
      return true;
    }
  }

  std::size_t write() {
    const bool written = writer_->write(&carried_);
    AtomicCounters::add(written ? counters_.written : counters_.write_failed);
    return written ? 1 : 0;
  }

  void on_publication_matched(fast::DataWriter*, const fast::PublicationMatchedStatus& status) override {
    matched_.store(status.current_count, std::memory_order_relaxed);
  }
  void on_offered_deadline_missed(fast::DataWriter*, const fast::OfferedDeadlineMissedStatus&) override {
    AtomicCounters::add(counters_.deadline_missed);
  }
  void on_offered_incompatible_qos(fast::DataWriter*, const fast::OfferedIncompatibleQosStatus&) override {
    AtomicCounters::add(counters_.incompatible_qos);
  }

  AtomicCounters& counters_;
  const bool paced_;
  Subscription<T> samples_;
  fast::DataWriter* writer_ = nullptr;
  Carried<T> carried_;
  SteadyTime due_ = std::chrono::steady_clock::now();
};

template <class T>
class In final : public Link, private fast::DataReaderListener {
 public:
  In(LocalBus& local, const std::shared_ptr<Wakeup>& wakeup, AtomicCounters& counters)
      : counters_{counters}, wakeup_{wakeup}, publisher_{local.advertise_for_strangers<T>()} {}

  bool create(fast::Subscriber& subscriber, fast::Topic& topic, const TopicShape& shape) {
    reader_.store(subscriber.create_datareader(&topic, reader_qos(shape), this));
    return reader_ != nullptr;
  }

  std::size_t run(SteadyTime now) override {
    std::size_t count = 0;
    while (const auto sample = gate_.held(now)) count += hand_on(*sample);
    if (!arrived_.exchange(false, std::memory_order_acq_rel)) return count;
    fast::SampleInfo info;
    std::size_t n = 0;
    for (; n < kTakenAtOnce; ++n) {
      if (reader_.load()->take_next_sample(&carried_, &info) != ReturnCode_t::RETCODE_OK) break;
      if (!info.valid_data) continue;  // a writer has left
      if (is_ours(info)) continue;
      if (carried_.refusal != Refusal::none) {
        AtomicCounters::add(counters_.refused[static_cast<std::size_t>(carried_.refusal)]);
      } else if (gate_.passes(carried_.sample, now)) {
        count += hand_on(carried_.sample);
      }
    }
    AtomicCounters::add(counters_.refused_flood, gate_.refused() - refused_by_gate_);
    refused_by_gate_ = gate_.refused();
    if (n == kTakenAtOnce) on_data_available(nullptr);
    return count;
  }

  [[nodiscard]] SteadyTime due() const noexcept override { return gate_.due(); }

  [[nodiscard]] const Publisher<T>& arrivals() const noexcept { return publisher_; }

 private:
  std::size_t hand_on(const T& sample) {
    const bool taken = publisher_.publish(sample);
    AtomicCounters::add(taken ? counters_.taken : counters_.refused_instance);
    return taken ? 1 : 0;
  }

  /// Whether it comes from a writer of this participant, of a topic that goes both ways.
  [[nodiscard]] bool is_ours(const fast::SampleInfo& info) const {
    return info.sample_identity.writer_guid().guidPrefix == reader_.load()->guid().guidPrefix;
  }

  void on_data_available(fast::DataReader*) override {
    arrived_.store(true, std::memory_order_release);
    wakeup_->ring();
  }
  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override {
    matched_.store(status.current_count, std::memory_order_relaxed);
  }
  void on_requested_deadline_missed(fast::DataReader*, const fast::RequestedDeadlineMissedStatus&) override {
    AtomicCounters::add(counters_.deadline_missed);
  }
  void on_liveliness_changed(fast::DataReader*, const fast::LivelinessChangedStatus& status) override {
    if (status.not_alive_count_change > 0) AtomicCounters::add(counters_.liveliness_lost);
  }
  void on_requested_incompatible_qos(fast::DataReader*,
                                     const fast::RequestedIncompatibleQosStatus&) override {
    AtomicCounters::add(counters_.incompatible_qos);
  }

  AtomicCounters& counters_;
  std::shared_ptr<Wakeup> wakeup_;
  Publisher<T> publisher_;
  std::atomic<fast::DataReader*> reader_{nullptr};
  std::atomic<bool> arrived_{false};
  Carried<T> carried_;
  GateOf<T> gate_;
  std::uint64_t refused_by_gate_ = 0;  ///< as far as it was counted
};

}  // namespace

struct DdsBus::Impl {
  Impl(const DdsConfig& wanted, LocalBus& bus)
      : config{wanted}, local{bus}, participant{create_participant(config)} {}

  ~Impl() { delete_participant(participant); }

  template <class T, class Direction>
  void carry() {
    const std::string name{TopicTraits<T>::name};
    if (link_of(name)) {
      throw StartupError{
          name + " is carried already: a topic goes out or comes in, once, or its samples would circle"};
    }
    add<T>(std::make_unique<Direction>(local, wakeup, counters));
  }

  template <class T>
  void carry_both() {
    carry<T, In<T>>();
    const auto& in = static_cast<const In<T>&>(*link_of(TopicTraits<T>::name));
    constexpr bool kPaced = TopicTraits<T>::period_s > 0;
    add<T>(std::make_unique<Out<T>>(local, wakeup, counters, kPaced, &in.arrivals()));
  }

  /// Creates the endpoint of a link below the right partition's publisher or subscriber.
  template <class T, class Direction>
  void add(std::unique_ptr<Direction> link) {
    using Traits = TopicTraits<T>;
    const std::string name{Traits::name};
    if (Traits::partition == kTruthPartition && !config.join_truth) {
      throw StartupError{name + " is of the simulated truth: only simulator and viewers set join_truth"};
    }
    fast::TypeSupport type{new TypeSupport<T>{}};
    auto* topic = dynamic_cast<fast::Topic*>(participant->lookup_topicdescription(name));
    if (!topic && type.register_type(participant) == ReturnCode_t::RETCODE_OK) {
      topic = participant->create_topic(name, type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
    }
    const TopicShape shape{Traits::qos, Traits::period_s};
    Direction& direction = *link;
    links.emplace_back(Traits::name, std::move(link));  // kept also on failure: listeners outlive endpoints
    if (!topic || !create(direction, *topic, shape, std::string{Traits::partition})) {
      throw StartupError{"DDS refuses the topic " + name +
                         (config.security.empty()
                              ? ": its quality of service contradicts itself or memory is short; the log of "
                                "Fast DDS says more"
                              : ": the permissions in " + config.security + " do not allow it")};
    }
  }

  template <class T>
  bool create(Out<T>& out, fast::Topic& topic, const TopicShape& shape, const std::string& partition) {
    fast::PublisherQos qos = fast::PUBLISHER_QOS_DEFAULT;
    if (!partition.empty()) qos.partition().push_back(partition.c_str());
    fast::Publisher* const publisher = participant->create_publisher(qos);
    return publisher && out.create(*publisher, topic, shape);
  }

  template <class T>
  bool create(In<T>& in, fast::Topic& topic, const TopicShape& shape, const std::string& partition) {
    fast::SubscriberQos qos = fast::SUBSCRIBER_QOS_DEFAULT;
    if (!partition.empty()) qos.partition().push_back(partition.c_str());
    fast::Subscriber* const subscriber = participant->create_subscriber(qos);
    return subscriber && in.create(*subscriber, topic, shape);
  }

  [[nodiscard]] const Link* link_of(std::string_view name) const noexcept {
    const auto found = std::ranges::find(links, name, [](const auto& entry) { return entry.first; });
    return found == links.end() ? nullptr : found->second.get();
  }

  std::size_t run() {
    std::size_t count = 0;
    for (const auto& [name, link] : links) count += link->run(std::chrono::steady_clock::now());
    return count;
  }

  const DdsConfig config;
  LocalBus& local;
  const std::shared_ptr<Wakeup> wakeup = std::make_shared<Wakeup>();
  AtomicCounters counters;
  std::vector<std::pair<std::string_view, std::unique_ptr<Link>>> links;
  fast::DomainParticipant* const participant;
  std::atomic<bool> stopping{false};
  std::atomic<std::uint64_t> rounds{0};
  std::thread thread;
};

DdsBus::DdsBus(const DdsConfig& config, LocalBus& local) : impl_{std::make_unique<Impl>(config, local)} {}

DdsBus::~DdsBus() {
  stop();
}

template <class T>
void DdsBus::out() {
  impl_->carry<T, Out<T>>();
}

template <class T>
void DdsBus::in() {
  impl_->carry<T, In<T>>();
}

template <class T>
void DdsBus::both() {
  impl_->carry_both<T>();
}

template <class T>
std::size_t DdsBus::matched() const {
  std::size_t count = 0;
  for (const auto& [name, link] : impl_->links) count += name == TopicTraits<T>::name ? link->matched() : 0;
  return count;
}

std::size_t DdsBus::run_once(Nanoseconds timeout) {
  SteadyTime due = SteadyTime::max();
  for (const auto& [name, link] : impl_->links) due = std::min(due, link->due());
  if (due != SteadyTime::max()) {
    timeout = std::clamp<Nanoseconds>(due - std::chrono::steady_clock::now(), Nanoseconds{0}, timeout);
  }
  impl_->wakeup->wait(timeout);
  const std::size_t moved = impl_->run();
  impl_->rounds.fetch_add(1, std::memory_order_relaxed);
  return moved;
}

void DdsBus::start() {
  if (impl_->thread.joinable()) return;
  impl_->stopping = false;
  impl_->thread = std::thread{[this] {
    pthread_setname_np(pthread_self(), "bus");
    while (!impl_->stopping) run_once(kLongestSleep);
    impl_->run();
  }};
}

void DdsBus::stop() {
  if (!impl_->thread.joinable()) return;
  impl_->stopping = true;
  impl_->wakeup->ring();
  impl_->thread.join();
}

std::uint64_t DdsBus::rounds() const {
  return impl_->rounds.load(std::memory_order_relaxed);
}

DdsCounters DdsBus::counters() const {
  const AtomicCounters& from = impl_->counters;
  const auto refused = [&from](Refusal refusal) {
    return from.refused[static_cast<std::size_t>(refusal)].load();
  };
  DdsCounters counters;
  counters.written = from.written;
  counters.write_failed = from.write_failed;
  counters.taken = from.taken;
  counters.refused_malformed = refused(Refusal::malformed);
  counters.refused_text = refused(Refusal::text_too_long);
  counters.refused_enum = refused(Refusal::unknown_enum);
  counters.refused_not_finite = refused(Refusal::not_finite);
  counters.refused_instance = from.refused_instance;
  counters.refused_flood = from.refused_flood;
  for (const auto& [name, link] : impl_->links) counters.lost_locally += link->lost();
  counters.deadline_missed = from.deadline_missed;
  counters.liveliness_lost = from.liveliness_lost;
  counters.incompatible_qos = from.incompatible_qos;
  return counters;
}

#define MOTIONLAB_CARRY(Type)                \
  template void DdsBus::out<topic::Type>();  \
  template void DdsBus::in<topic::Type>();   \
  template void DdsBus::both<topic::Type>(); \
  template std::size_t DdsBus::matched<topic::Type>() const;
MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_CARRY)
#undef MOTIONLAB_CARRY

}  // namespace motionlab::bus
