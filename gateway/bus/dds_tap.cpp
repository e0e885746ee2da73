#include "gateway/bus/dds_tap.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>

#include "drivers/core/error.hpp"
#include "gateway/bus/participant.hpp"
#include "gateway/bus/qos.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/bus/type_support.hpp"

namespace motionlab::bus {
namespace {

namespace fast = eprosima::fastdds::dds;
using eprosima::fastrtps::types::ReturnCode_t;

constexpr std::size_t kTakenAtOnce = 1024;  // of one topic, so that a flood leaves the others their turn

/// One topic. Also the listener, and thus alive until the readers are deleted.
class Pipe : public fast::DataReaderListener {
 public:
  explicit Pipe(std::size_t topic) : topic_{topic} {}

  virtual bool create(fast::DomainParticipant& participant, int depth) = 0;
  virtual std::size_t take(const std::function<void(const TappedSample&)>& use) = 0;

  [[nodiscard]] std::size_t writers() const noexcept {
    return static_cast<std::size_t>(std::max(writers_.load(std::memory_order_relaxed), 0));
  }
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 protected:
  const std::size_t topic_;
  std::atomic<std::uint64_t> refused_{0};

 private:
  void on_subscription_matched(fast::DataReader*, const fast::SubscriptionMatchedStatus& status) override {
    writers_.store(status.current_count, std::memory_order_relaxed);
  }

  std::atomic<int> writers_{0};
};

template <class T>
class PipeOf final : public Pipe {
 public:
  using Pipe::Pipe;

  bool create(fast::DomainParticipant& participant, int depth) override {
    fast::TypeSupport type{new TapSupport<T>{}};
    if (type.register_type(&participant) != ReturnCode_t::RETCODE_OK) return false;
    fast::Topic* const topic = participant.create_topic(std::string{TopicTraits<T>::name},
                                                        type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
    fast::SubscriberQos qos = fast::SUBSCRIBER_QOS_DEFAULT;
    if (!TopicTraits<T>::partition.empty()) {
      qos.partition().push_back(std::string{TopicTraits<T>::partition}.c_str());
    }
    fast::Subscriber* const subscriber = topic ? participant.create_subscriber(qos) : nullptr;
    if (!subscriber) return false;
    reader_ = subscriber->create_datareader(
        topic, tap_qos({TopicTraits<T>::qos, TopicTraits<T>::period_s}, depth), this);
    return reader_ != nullptr;
  }

  std::size_t take(const std::function<void(const TappedSample&)>& use) override {
    std::size_t count = 0;
    fast::SampleInfo info;
    for (std::size_t n = 0; n < kTakenAtOnce; ++n) {
      if (reader_->take_next_sample(static_cast<Carried<T>*>(&tapped_), &info) != ReturnCode_t::RETCODE_OK)
        break;
      if (!info.valid_data) continue;  // a writer has left
      if (tapped_.refusal != Refusal::none) {
        refused_.fetch_add(1, std::memory_order_relaxed);
        continue;
      }
      use({.topic = topic_,
           .instance = instance(),
           .cdr = tapped_.bytes,
           .writer = id_of(info.sample_identity.writer_guid()),
           .writer_sequence = info.sample_identity.sequence_number().to64long(),
           .t_written_ns = info.source_timestamp.to_ns(),
           .t_heard_ns = info.reception_timestamp.to_ns()});
      ++count;
    }
    return count;
  }

 private:
  [[nodiscard]] std::string_view instance() {
    if constexpr (T::kKeyed) {
      instance_.clear();
      for (const std::string_view part : tapped_.sample.key()) {
        if (!instance_.empty()) instance_ += '/';
        instance_ += part;
      }
    }
    return instance_;
  }

  fast::DataReader* reader_ = nullptr;
  Tapped<T> tapped_;
  std::string instance_;
};

}  // namespace

struct DdsTap::Impl {
  Impl(const DdsConfig& config, const TapOptions& options) : participant{create_participant(config)} {
    std::size_t topic = 0;
#define MOTIONLAB_PIPE(Type) pipes[topic] = std::make_unique<PipeOf<topic::Type>>(topic), ++topic;
    MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_PIPE)
#undef MOTIONLAB_PIPE
    for (std::size_t i = 0; i < pipes.size(); ++i) {
      const bool wanted =
          options.topics.empty() || std::ranges::find(options.topics, i) != options.topics.end();
      if (!wanted || (kTopicList[i].partition == kTruthPartition && !config.join_truth)) {
        pipes[i].reset();
      } else if (!pipes[i]->create(*participant, options.depth)) {
        delete_participant(participant);
        throw StartupError{"DDS refuses the topic " + std::string{kTopicList[i].name} +
                           ": memory is short; the log of Fast DDS says more"};
      }
    }
  }
  ~Impl() {
    delete_participant(participant);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  std::array<std::unique_ptr<Pipe>, kTopicList.size()> pipes;
  fast::DomainParticipant* const participant;
};

DdsTap::DdsTap(const DdsConfig& config, const TapOptions& options)
    : impl_{std::make_unique<Impl>(config, options)} {}

DdsTap::~DdsTap() = default;

std::size_t DdsTap::take(const std::function<void(const TappedSample&)>& use) {
  std::size_t count = 0;
  for (const auto& pipe : impl_->pipes) {
    if (pipe) count += pipe->take(use);
  }
  return count;
}

std::size_t DdsTap::writers(std::size_t topic) const noexcept {
  return impl_->pipes[topic] ? impl_->pipes[topic]->writers() : 0;
}

std::uint64_t DdsTap::refused(std::size_t topic) const noexcept {
  return impl_->pipes[topic] ? impl_->pipes[topic]->refused() : 0;
}

std::uint64_t DdsTap::refused() const noexcept {
  std::uint64_t sum = 0;
  for (std::size_t topic = 0; topic < impl_->pipes.size(); ++topic) sum += refused(topic);
  return sum;
}

}  // namespace motionlab::bus
