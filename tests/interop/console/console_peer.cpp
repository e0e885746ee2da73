/// @file  What stands on the other side of DDS when strangers judge the console. Every line that it prints is
/// JSON.
///
///   console_peer samples DOMAIN    five samples of every topic, again and again
///   console_peer requests DOMAIN   prints the requests and references that arrive
///   console_peer fault DOMAIN DEVICE FAULT   switches a fault of a simulated device on, and ends
///   console_peer flood DOMAIN      ten units and their health as fast as it goes, and some events
///
/// But for `fault`, until its standard input ends.
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <vector>

#include "gateway/bus/dds_bus.hpp"
#include "tests/unit/bus/samples.hpp"

namespace motionlab {
namespace {

using nlohmann::ordered_json;

/// As a stranger's decoder has it: enumerators are numbers; 64-bit integers are texts, which no JSON reader
/// rounds.
template <class Value>
ordered_json json_of(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return static_cast<std::uint32_t>(value);
  } else if constexpr (std::is_integral_v<Value> && sizeof(Value) == 8) {
    return std::to_string(value);
  } else {
    return value;
  }
}
template <std::size_t N>
ordered_json json_of(const Text<N>& text) {
  return text.str();
}
template <class Value, std::size_t N>
ordered_json json_of(const std::array<Value, N>& values) {
  ordered_json list = ordered_json::array();
  for (const Value& value : values) list.push_back(json_of(value));
  return list;
}

template <class T>
void print(const T& sample) {
  ordered_json fields;
  T::fields(sample,
            [&](std::string_view name, const auto& value) { fields[std::string{name}] = json_of(value); });
  ordered_json line;
  line["topic"] = bus::TopicTraits<T>::name;
  line["sample"] = fields;
  std::cout << line.dump() << std::endl;
}

bool input_has_ended(int patience_ms) {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char byte{};
  return poll(&input, 1, patience_ms) > 0 && read(STDIN_FILENO, &byte, 1) <= 0;
}

bus::DdsConfig loopback(const char* domain) {
  bus::DdsConfig config;
  config.domain = std::atoi(domain);
  config.interface_whitelist = {"127.0.0.1"};
  config.participant = "console peer";
  config.join_truth = true;
  return config;
}

template <class T>
class Known {
 public:
  explicit Known(bus::LocalBus& local) : publisher_(local.advertise<T>()) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      samples_.push_back(bus::random_sample<T>(seed));
      print(samples_.back());
    }
  }
  void publish(std::size_t round) { publisher_.publish(samples_[round % samples_.size()]); }

 private:
  bus::Publisher<T> publisher_;
  std::vector<T> samples_;
};

int samples(const char* domain) {
  bus::LocalBus local;
  bus::DdsBus dds{loopback(domain), local};
#define MOTIONLAB_OUT(Type) dds.out<topic::Type>();
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_OUT)
#undef MOTIONLAB_OUT
  dds.start();
#define MOTIONLAB_KNOWN(Type) Known<topic::Type> known_##Type{local};
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_KNOWN)
#undef MOTIONLAB_KNOWN
  for (std::size_t round = 0; !input_has_ended(50); ++round) {
#define MOTIONLAB_PUBLISH(Type) known_##Type.publish(round);
    MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_PUBLISH)
#undef MOTIONLAB_PUBLISH
  }
  return 0;
}

int requests(const char* domain) {
  bus::LocalBus local;
  bus::DdsBus dds{loopback(domain), local};
  dds.in<topic::ModeRequest>();
  dds.in<topic::Reference>();
  dds.out<topic::Mode>();  // by this the console knows that a gateway is there
  auto requests = local.subscribe<topic::ModeRequest>();
  auto references = local.subscribe<topic::Reference>();
  auto mode = local.advertise<topic::Mode>();
  dds.start();
  mode.publish({});
  while (!input_has_ended(20)) {
    while (const auto request = requests.next()) print(*request);
    while (const auto reference = references.next()) print(*reference);
  }
  return 0;
}

int fault(const char* domain, const char* device, const char* name) {
  bus::LocalBus local;
  bus::DdsBus dds{loopback(domain), local};
  dds.out<topic::SimControl>();
  auto controls = local.advertise<topic::SimControl>();
  dds.start();
  topic::SimControl control;
  control.device = device;
  control.fault = name;
  control.active = true;
  // The console listens as well, so a match says nothing of the simulator: it is said again for two seconds.
  for (int i = 0; i < 20; ++i) {
    ++control.sequence_number;
    controls.publish(control);
    std::this_thread::sleep_for(100ms);
  }
  return 0;
}

int flood(const char* domain) {
  bus::LocalBus local;
  bus::DdsBus dds{loopback(domain), local};
  dds.out<topic::Mru>();
  dds.out<topic::Health>();
  dds.out<topic::Event>();
  auto mrus = local.advertise<topic::Mru>();
  auto healths = local.advertise<topic::Health>();
  auto events = local.advertise<topic::Event>();
  dds.start();
  topic::Mru mru = bus::random_sample<topic::Mru>(1);
  topic::Health health = bus::random_sample<topic::Health>(1);
  topic::Event event = bus::random_sample<topic::Event>(1);
  std::uint64_t round = 0;
  while (!input_has_ended(1)) {
    for (int i = 0; i < 10; ++i) {
      mru.device = "mru" + std::to_string(i);
      ++mru.sequence_number;
      mrus.publish(mru);
    }
    health.device = "mru" + std::to_string(mru.sequence_number % 5);
    ++health.sequence_number;
    healths.publish(health);
    if (++round % 20 != 0) continue;  // of events none may be lost on the way to the console
    ++event.sequence_number;
    events.publish(event);
  }
  std::cout << ordered_json{{"mrus", mru.sequence_number}}.dump() << std::endl;
  return 0;
}

int run(int argc, char** argv) {
  const std::string_view verb = argc > 2 ? argv[1] : "";
  if (verb == "samples" && argc == 3) return samples(argv[2]);
  if (verb == "requests" && argc == 3) return requests(argv[2]);
  if (verb == "fault" && argc == 5) return fault(argv[2], argv[3], argv[4]);
  if (verb == "flood" && argc == 3) return flood(argv[2]);
  return 64;
}

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  try {
    return motionlab::run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
