#include "gateway/bus/dds_repeater.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <string>

#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
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

/// A reader that does not answer holds nobody up for longer.
const eprosima::fastrtps::Duration_t kPatience{1, 0};

/// Works on `Tapped<T>`, for writers only. The sample is there for its key; what is sent are the bytes.
template <class T>
class RepeatSupport final : public TypeSupport<T> {
 public:
  bool serialize(void* data, typename TypeSupport<T>::Payload* payload) override {
    const auto& bytes = static_cast<const Tapped<T>&>(*static_cast<Carried<T>*>(data)).bytes;
    if (bytes.size() > payload->max_size) return false;
    std::memcpy(payload->data, bytes.data(), bytes.size());
    payload->length = static_cast<std::uint32_t>(bytes.size());
    payload->encapsulation = bytes[1] == std::byte{1} ? CDR_LE : CDR_BE;
    return true;
  }
  void* createData() override { return static_cast<Carried<T>*>(new Tapped<T>{}); }
  void deleteData(void* data) override { delete static_cast<Tapped<T>*>(static_cast<Carried<T>*>(data)); }
};

/// One topic. Also the listener, and thus alive until the writers are deleted.
class Voice : public fast::DataWriterListener {
 public:
  virtual bool create(fast::DomainParticipant& participant) = 0;
  virtual bool say(std::span<const std::byte> cdr) = 0;
  /// Until reliable readers have all that was said to them, or patience ends.
  virtual void wait_until_heard() = 0;

  [[nodiscard]] std::size_t readers() const noexcept {
    return static_cast<std::size_t>(std::max(readers_.load(std::memory_order_relaxed), 0));
  }

 private:
  void on_publication_matched(fast::DataWriter*, const fast::PublicationMatchedStatus& status) override {
    readers_.store(status.current_count, std::memory_order_relaxed);
  }

  std::atomic<int> readers_{0};
};

template <class T>
class VoiceOf final : public Voice {
 public:
  bool create(fast::DomainParticipant& participant) override {
    fast::TypeSupport type{new RepeatSupport<T>{}};
    if (type.register_type(&participant) != ReturnCode_t::RETCODE_OK) return false;
    fast::Topic* const topic = participant.create_topic(std::string{TopicTraits<T>::name},
                                                        type.get_type_name(), fast::TOPIC_QOS_DEFAULT);
    fast::PublisherQos qos = fast::PUBLISHER_QOS_DEFAULT;
    if (!TopicTraits<T>::partition.empty()) {
      qos.partition().push_back(std::string{TopicTraits<T>::partition}.c_str());
    }
    fast::Publisher* const publisher = topic ? participant.create_publisher(qos) : nullptr;
    if (!publisher) return false;
    writer_ = publisher->create_datawriter(topic, writer_qos({TopicTraits<T>::qos, TopicTraits<T>::period_s}),
                                           this);
    return writer_ != nullptr;
  }

  bool say(std::span<const std::byte> cdr) override {
    sample_.bytes.assign(cdr.begin(), cdr.end());
    sample_.refusal =
        read_cdr(reinterpret_cast<char*>(sample_.bytes.data()), sample_.bytes.size(), sample_.sample);
    return sample_.refusal == Refusal::none && writer_->write(static_cast<Carried<T>*>(&sample_));
  }

  void wait_until_heard() override { writer_->wait_for_acknowledgments(kPatience); }

 private:
  fast::DataWriter* writer_ = nullptr;
  Tapped<T> sample_;
};

}  // namespace

struct DdsRepeater::Impl {
  Impl(const DdsConfig& config, const std::vector<std::size_t>& topics)
      : participant{create_participant(config)} {
    std::size_t topic = 0;
#define MOTIONLAB_VOICE(Type) voices[topic] = std::make_unique<VoiceOf<topic::Type>>(), ++topic;
    MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_VOICE)
#undef MOTIONLAB_VOICE
    for (std::size_t i = 0; i < voices.size(); ++i) {
      if (std::ranges::find(topics, i) == topics.end()) {
        voices[i].reset();
      } else if (!voices[i]->create(*participant)) {
        delete_participant(participant);
        throw StartupError{"DDS refuses the topic " + std::string{kTopicList[i].name} +
                           ": memory is short; the log of Fast DDS says more"};
      }
    }
  }
  ~Impl() {
    for (const auto& voice : voices) {
      if (voice) voice->wait_until_heard();
    }
    delete_participant(participant);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  std::array<std::unique_ptr<Voice>, kTopicList.size()> voices;
  fast::DomainParticipant* const participant;
};

DdsRepeater::DdsRepeater(const DdsConfig& config, const std::vector<std::size_t>& topics)
    : impl_{std::make_unique<Impl>(config, topics)} {}

DdsRepeater::~DdsRepeater() = default;

bool DdsRepeater::say(std::size_t topic, std::span<const std::byte> cdr) {
  return impl_->voices[topic] && impl_->voices[topic]->say(cdr);
}

std::size_t DdsRepeater::readers(std::size_t topic) const noexcept {
  return impl_->voices[topic] ? impl_->voices[topic]->readers() : 0;
}

}  // namespace motionlab::bus
