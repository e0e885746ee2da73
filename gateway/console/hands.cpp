#include "gateway/console/hands.hpp"

#include <nlohmann/json.hpp>

#include <stdexcept>
#include <utility>

#include "gateway/bus/topics.hpp"
#include "gateway/console/json_sample.hpp"

namespace motionlab::console {
namespace {

constexpr Nanoseconds kSettleFor = 1s, kSettleEvery = 20ms;
constexpr std::string_view kRequests = bus::TopicTraits<topic::ModeRequest>::name;
constexpr std::string_view kReferences = bus::TopicTraits<topic::Reference>::name;

bus::DdsConfig writer_config(bus::DdsConfig config) {
  config.participant = "motionlab-console hands";
  config.join_truth = false;
  return config;
}

}  // namespace

Hands::Hands(const bus::DdsConfig& config, const Clock& clock, std::string requester)
    : clock_(clock),
      requester_(std::move(requester)),
      dds_(writer_config(config), local_),
      requests_(local_.advertise<topic::ModeRequest>()),
      references_(local_.advertise<topic::Reference>()) {
  dds_.out<topic::ModeRequest>();
  dds_.out<topic::Reference>();
  dds_.start();
}

template <class T>
void Hands::stamp(T& sample) {
  const LabTime now = clock_.now();
  sample.requester = requester_;
  sample.sequence_number = static_cast<std::uint64_t>(to_ns(now));  // grows from run to run
  sample.t_created_ns = to_ns(now);
}

void Hands::settle() {
  settle_ = {};
  settle_.action = topic::ModeAction::settle;
  stamp(settle_);
  settle_next_ = clock_.now();
  settle_until_ = settle_next_ + kSettleFor;
  run(settle_next_);
}

void Hands::run(LabTime now) {
  if (now < settle_next_ || now >= settle_until_) return;
  requests_.publish(settle_);
  settle_next_ = now + kSettleEvery;
}

bool Hands::may_publish(std::string_view topic) {
  return topic == kRequests || topic == kReferences;
}

void Hands::publish(std::string_view topic, std::string_view json) {
  const nlohmann::json given = nlohmann::json::parse(json, nullptr, false);
  if (topic == kRequests) {
    topic::ModeRequest request;
    fill_from_json(given, request);
    if (!given.contains("action")) throw std::invalid_argument{"the request names no action"};
    if (request.action == topic::ModeAction::settle) return settle();
    stamp(request);
    settle_until_ = {};  // what is asked now is newer than a settle that is being repeated
    requests_.publish(request);
  } else if (topic == kReferences) {
    topic::Reference reference;
    fill_from_json(given, reference);
    if (!given.contains("p_world_load_m"))
      throw std::invalid_argument{"the reference names no p_world_load_m"};
    stamp(reference);
    references_.publish(reference);
  } else {
    throw std::invalid_argument{std::string{topic} + " is not published from here"};
  }
}

}  // namespace motionlab::console
