/// @file  Our side of the interop test, on the bus that the gateway uses. It prints what it writes or reads
/// in the stranger's format, so that run.sh can compare line by line.
///
///   interop_dds_peer publish DOMAIN    until its standard input ends
///   interop_dds_peer receive DOMAIN COUNT
///   interop_dds_peer echo DOMAIN       every topic out, and back by a stranger in the next domain, unchanged
#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "gateway/bus/dds_bus.hpp"
#include "tests/unit/bus/samples.hpp"

namespace motionlab {
namespace {

struct PrintField {
  void operator()(std::string_view name, const auto& value) const {
    std::printf(" %.*s=", static_cast<int>(name.size()), name.data());
    print(value);
  }

 private:
  static void print(bool value) { std::printf("%d", value ? 1 : 0); }
  static void print(double value) { std::printf("%a", value); }
  static void print(std::uint64_t value) { std::printf("%" PRIu64, value); }
  static void print(std::int64_t value) { std::printf("%" PRId64, value); }
  template <std::size_t N>
  static void print(const Text<N>& value) {
    std::printf("%s", value.str().c_str());
  }
  template <std::size_t N>
  static void print(const std::array<double, N>& values) {
    for (std::size_t i = 0; i < N; ++i) std::printf("%s%a", i == 0 ? "" : ",", values[i]);
  }
};

/// Every double another one, none of them round.
struct FillField {
  double next;
  void operator()(std::string_view, double& value) { value = (next += 1) / 3; }
  template <std::size_t N>
  void operator()(std::string_view name, std::array<double, N>& values) {
    for (double& value : values) (*this)(name, value);
  }
  void operator()(std::string_view, auto&) {}
};

topic::Mru mru(std::uint64_t number) {
  topic::Mru sample;
  topic::Mru::fields(sample, FillField{-1e6 * static_cast<double>(number)});
  sample.device = number % 2 == 0 ? "mru1" : "a-name-of-thirty-two-characters.";
  sample.sequence_number = number;
  sample.t_measured_ns = -1 - static_cast<std::int64_t>(number);
  sample.t_received_ns = std::numeric_limits<std::int64_t>::max() - static_cast<std::int64_t>(number);
  sample.stable = number % 2 == 0;
  sample.checksum_suspect = !sample.stable;
  sample.omega_down_radps = std::numeric_limits<double>::denorm_min();
  return sample;
}

topic::Estimate estimate(std::uint64_t number) {
  topic::Estimate sample;
  topic::Estimate::fields(sample, FillField{1e3 * static_cast<double>(number)});
  sample.sequence_number = number;
  sample.t_estimated_ns = 1'700'000'000'000'000'000 + static_cast<std::int64_t>(number);
  sample.valid = true;
  sample.load_tracked = number % 2 == 0;
  return sample;
}

bus::DdsConfig loopback(const char* domain) {
  bus::DdsConfig config;
  config.domain = std::atoi(domain);
  config.interface_whitelist = {"127.0.0.1"};
  config.participant = "interop";
  return config;
}

bool input_has_ended() {
  pollfd input{STDIN_FILENO, POLLIN, 0};
  char byte{};
  return poll(&input, 1, 20) > 0 && read(STDIN_FILENO, &byte, 1) <= 0;
}

int publish(const char* domain) {
  bus::LocalBus local;
  bus::DdsBus dds{loopback(domain), local};
  dds.out<topic::Mru>();
  dds.out<topic::Estimate>();
  dds.start();
  auto mrus = local.advertise<topic::Mru>();
  auto estimates = local.advertise<topic::Estimate>();
  for (std::uint64_t number = 1; !input_has_ended(); ++number) {
    const topic::Mru sample = mru(number);
    mrus.publish(sample);
    std::printf("mru");
    topic::Mru::fields(sample, PrintField{});
    const topic::Estimate state = estimate(number);
    estimates.publish(state);
    std::printf("\nestimate");
    topic::Estimate::fields(state, PrintField{});
    std::printf("\n");
  }
  return dds.counters().incompatible_qos == 0 ? 0 : 3;
}

int receive(const char* domain, std::uint64_t count) {
  bus::LocalBus local;
  bus::DdsBus dds{loopback(domain), local};
  dds.in<topic::ModeRequest>();
  auto requests = local.subscribe<topic::ModeRequest>();
  const auto end = std::chrono::steady_clock::now() + 60s;
  for (std::uint64_t seen = 0; seen < count;) {
    if (std::chrono::steady_clock::now() > end) {
      std::fprintf(stderr, "got %" PRIu64 " requests, not %" PRIu64 "\n", seen, count);
      return 1;
    }
    dds.run_once(100ms);
    while (const auto request = requests.next()) {
      ++seen;
      std::printf("%s %" PRIu64 " %" PRId64 " %s %s\n", request->requester.str().c_str(),
                  request->sequence_number, request->t_created_ns,
                  std::string{to_string(request->action)}.c_str(),
                  std::string{to_string(request->authority)}.c_str());
    }
  }
  const auto counters = dds.counters();
  return counters.incompatible_qos == 0 && counters.refused() == counters.refused_flood ? 0 : 3;
}

/// One topic on its way out and back.
class EchoBase {
 public:
  virtual ~EchoBase() = default;
  virtual void send() = 0;
  /// @returns whether every sample has come back
  virtual bool look() = 0;
  [[nodiscard]] virtual std::string_view name() const = 0;
};

template <class T>
class Echo final : public EchoBase {
 public:
  Echo(bus::LocalBus& there, bus::LocalBus& back)
      : publisher_(there.advertise<T>()), subscription_(back.subscribe<T>()) {
    for (std::uint64_t seed = 1; seed <= kSamples; ++seed) missing_.push_back(bus::random_sample<T>(seed));
  }
  void send() override {
    if (!missing_.empty()) publisher_.publish(missing_.front());
  }
  bool look() override {
    while (const auto sample = subscription_.next()) {
      std::erase_if(missing_, [&](const T& sent) { return bus::differences(sent, *sample).empty(); });
    }
    return missing_.empty();
  }
  [[nodiscard]] std::string_view name() const override { return bus::TopicTraits<T>::name; }

 private:
  static constexpr std::uint64_t kSamples = 5;
  bus::Publisher<T> publisher_;
  bus::Subscription<T> subscription_;
  std::vector<T> missing_;
};

int echo(const char* domain) {
  bus::DdsConfig here = loopback(domain);
  here.join_truth = true;
  bus::DdsConfig next = here;
  ++next.domain;
  bus::LocalBus there, back;
  bus::DdsBus out{here, there}, in{next, back};
  std::vector<std::unique_ptr<EchoBase>> echoes;
#define MOTIONLAB_ECHO(Type) \
  out.out<topic::Type>();    \
  in.in<topic::Type>();      \
  echoes.push_back(std::make_unique<Echo<topic::Type>>(there, back));
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_ECHO)
#undef MOTIONLAB_ECHO
  out.start();
  in.start();
  const auto end = std::chrono::steady_clock::now() + 60s;
  while (!echoes.empty() && std::chrono::steady_clock::now() < end) {
    for (const auto& topic : echoes) topic->send();
    std::this_thread::sleep_for(20ms);
    std::erase_if(echoes, [](const auto& topic) {
      if (!topic->look()) return false;
      std::printf("%s\n", std::string{topic->name()}.c_str());
      return true;
    });
  }
  out.stop();
  in.stop();
  for (const auto& topic : echoes) {
    std::fprintf(stderr, "%s did not come back unchanged\n", std::string{topic->name()}.c_str());
  }
  const auto incompatible = out.counters().incompatible_qos + in.counters().incompatible_qos;
  // After a stall requests come in a burst, and more than a control step can take are refused, rightly.
  const auto refused = in.counters().refused() - in.counters().refused_flood;
  if (incompatible + refused > 0) {
    std::fprintf(stderr,
                 "on domain %s or the next: %" PRIu64 " of incompatible quality, %" PRIu64
                 " samples refused\n",
                 domain, std::uint64_t{incompatible}, std::uint64_t{refused});
  }
  return echoes.empty() && incompatible + refused == 0 ? 0 : 3;
}

int run(int argc, char** argv) {
  const std::string_view verb = argc > 2 ? argv[1] : "";
  if (verb == "publish" && argc == 3) return publish(argv[2]);
  if (verb == "receive" && argc == 4) return receive(argv[2], std::strtoull(argv[3], nullptr, 10));
  if (verb == "echo" && argc == 3) return echo(argv[2]);
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
