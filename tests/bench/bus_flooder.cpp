// Floods a gateway's bus: many participants, requests, references and commands of all of them, junk on the
// ports of discovery.
//   bus_flooder DOMAIN OWN_ADDRESS TARGET_ADDRESS PARTICIPANTS SAMPLES_PER_S
// SAMPLES_PER_S is of each of the four topics that a gateway takes, and of the junk. Runs until it is killed;
// says each half second how much has left so far. It never asks to settle: that is obeyed from anyone, and
// the measurement would be over.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "drivers/core/random.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "idl/topics.hpp"
#include "tests/bench/datagram_gun.hpp"

namespace motionlab {
namespace {

constexpr int kNames = 7;  ///< of one participant

/// One participant, who speaks on all topics that a gateway takes.
class Mallory {
 public:
  Mallory(int domain, const std::string& address, int number)
      : dds_({.domain = domain, .interface_whitelist = {address}, .participant = "mallory"}, local_),
        requests_(local_.advertise<topic::ModeRequest>()),
        references_(local_.advertise<topic::Reference>()),
        arm_(local_.advertise<topic::ArmCommand>()),
        winch_(local_.advertise<topic::WinchCommand>()),
        name_("mallory" + std::to_string(number)) {
    dds_.out<topic::ModeRequest>();
    dds_.out<topic::Reference>();
    dds_.out<topic::ArmCommand>();
    dds_.out<topic::WinchCommand>();
    dds_.start();
  }

  /// One sample of each topic.
  void speak(std::uint64_t number) {
    const Text<32> name(name_ + "-" + std::to_string(number % kNames));
    topic::ModeRequest request;
    request.requester = name;
    request.sequence_number = number;
    request.action = number % 2 ? topic::ModeAction::engage : topic::ModeAction::authority;
    request.authority = topic::Authority::full;
    requests_.publish(request);
    topic::Reference reference;
    reference.requester = name;
    reference.sequence_number = number;
    const double jump = number % 2 ? 0.001 : -0.001;
    reference.p_world_load_m = {0.847625 + jump, -0.407825 - jump, 3.919269};
    references_.publish(reference);
    topic::ArmCommand arm;
    arm.device = "arm";
    arm.requester = number % 5 ? name : Text<32>("motionlab-gateway");
    arm.sequence_number = number;
    arm.follow = true;
    arm.qd_wanted_radps.fill(1);
    arm_.publish(arm);
    topic::WinchCommand winch;
    winch.device = "winch";
    winch.requester = arm.requester;
    winch.sequence_number = number;
    winch.wire_speed_wanted_mps = 1;
    winch_.publish(winch);
  }
  [[nodiscard]] std::uint64_t written() const { return dds_.counters().written; }

 private:
  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Publisher<topic::ModeRequest> requests_;
  bus::Publisher<topic::Reference> references_;
  bus::Publisher<topic::ArmCommand> arm_;
  bus::Publisher<topic::WinchCommand> winch_;
  std::string name_;
};

/// Random bytes, half of them behind a right RTPS header.
test::Datagrams junk() {
  constexpr std::array<std::uint8_t, 8> kHeader{'R', 'T', 'P', 'S', 2, 3, 1, 15};
  Random random(5);
  test::Datagrams all(499);
  for (auto& datagram : all) {
    datagram.resize(1 + random.below(400));
    for (auto& byte : datagram) byte = static_cast<std::uint8_t>(random.bits());
    if (random.chance(0.5) && datagram.size() > 40)
      std::copy(kHeader.begin(), kHeader.end(), datagram.begin());
  }
  return all;
}

/// Where RTPS listens for participants and for data, of the first ten participants of a host.
std::vector<std::uint16_t> ports_of(int domain) {
  std::vector<std::uint16_t> ports;
  const int base = 7400 + 250 * domain;
  for (int port = base; port <= base + 1; ++port) ports.push_back(static_cast<std::uint16_t>(port));
  for (int port = base + 10; port < base + 30; ++port) ports.push_back(static_cast<std::uint16_t>(port));
  return ports;
}

int run(int domain, const std::string& own, const std::string& target, int participants, double per_second) {
  using std::chrono::steady_clock;
  std::vector<std::unique_ptr<Mallory>> crowd;
  for (int i = 0; i < participants; ++i) crowd.push_back(std::make_unique<Mallory>(domain, own, i));
  const test::DatagramGun gun(target, ports_of(domain), junk(), per_second, 1);
  double due = 0;
  std::uint64_t spoken = 0;
  auto last = steady_clock::now(), told = last;
  while (getppid() != 1) {  // whoever started this has died
    const auto now = steady_clock::now();
    due += std::min(std::chrono::duration<double>(now - last).count(), 0.02) * per_second;
    last = now;
    for (; due >= 1; due -= 1, ++spoken) {
      crowd[spoken % crowd.size()]->speak(spoken / crowd.size());
    }
    if (now - told >= std::chrono::milliseconds{500}) {
      told = now;
      std::uint64_t written = 0;
      for (const auto& mallory : crowd) written += mallory->written();
      std::printf("flood %llu samples %llu junk\n", static_cast<unsigned long long>(written),
                  static_cast<unsigned long long>(gun.sent()));
      std::fflush(stdout);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{1});
  }
  return EXIT_SUCCESS;
}

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fputs("usage: bus_flooder DOMAIN OWN_ADDRESS TARGET_ADDRESS PARTICIPANTS SAMPLES_PER_S\n", stderr);
    return 64;
  }
  try {
    return motionlab::run(std::atoi(argv[1]), argv[2], argv[3], std::max(1, std::atoi(argv[4])),
                          std::atof(argv[5]));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bus_flooder: %s\n", error.what());
    return EXIT_FAILURE;
  }
}
