// A hundred thousand datagrams of garbage a second, to one UDP port of an engaged gateway after the other, in
// interleaved pairs with quiet stretches: what the commands, the control step and the counters say.
//   bench_datagram_flood [--pairs N] [--seconds S] [--rate DATAGRAMS_PER_S]
//   bench_datagram_flood --short     few, and coarse limits: a test for any machine
// The ship lies still: whatever moved would move because of the flood.
#include <gtest/gtest.h>

#include <array>
#include <cinttypes>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "drivers/core/random.hpp"
#include "tests/bench/datagram_gun.hpp"
#include "tests/bench/gateway_meter.hpp"
#include "tests/integration/process_bench.hpp"

namespace motionlab {

const char* const integration::kGatewayProgram = MOTIONLAB_GATEWAY;
const char* const integration::kSimulatorProgram = MOTIONLAB_SIM;

namespace {

using integration::eventually;
using topic::ModeState;

struct Options {
  int pairs = 3;
  double seconds = 5;
  double rate = 1e5;
  double most_step_p99 = 1.5;
} options;

constexpr int kThreads = 2;
/// What the guard may pass while a load hangs still over a still ship: rad/s and m/s.
constexpr double kStill = 0.03;

/// Random bytes of random length; some begin as the device's own do.
test::Datagrams garbage() {
  Random random(11);
  test::Datagrams all(997);
  for (auto& datagram : all) {
    datagram.resize(random.below(300));
    for (auto& byte : datagram) byte = static_cast<std::uint8_t>(random.bits());
    if (datagram.size() > 1 && random.chance(0.2)) datagram[0] = 'q';  // an MRU's header
    if (datagram.size() == 52) datagram[0] = 32;                       // a robot computer's key
  }
  return all;
}

/// Datagrams that the kernel dropped because nobody took the older ones from the port in time.
std::uint64_t kernel_drops(std::uint16_t port) {
  std::ifstream table("/proc/net/udp");
  std::string line;
  std::uint64_t drops = 0;
  std::getline(table, line);  // the heading
  while (std::getline(table, line)) {
    std::istringstream row(line);
    std::string slot, local, word;
    row >> slot >> local;
    if (std::strtoul(local.substr(local.find(':') + 1).c_str(), nullptr, 16) != port) continue;
    while (row >> word) {
    }
    drops += std::strtoull(word.c_str(), nullptr, 10);  // the last column
  }
  return drops;
}

class DatagramFlood : public integration::Processes {
 protected:
  static std::uint64_t rejected(const test::GatewayMeter& meter, const char* device) {
    std::uint64_t sum = 0;
    for (const auto n : meter.health(device).rejected) sum += n;
    return sum;
  }
};

TEST_F(DatagramFlood, ChangesNoCommandAndIsCounted) {
  const auto gateway = start_gateway();
  const auto simulator = start_simulator({"--scenario", "calm"});
  test::GatewayMeter meter(domain_, "127.0.0.1");
  ASSERT_TRUE(meter.engage()) << meter.mode().reason.view() << gateway->output() << simulator->output();
  std::this_thread::sleep_for(std::chrono::seconds{5});  // what engaging moved comes to rest
  const auto stretch =
      std::chrono::milliseconds(static_cast<std::chrono::milliseconds::rep>(1e3 * options.seconds));

  std::printf("%-9s %4s %18s %20s %11s %9s %9s %9s %9s\n", "to", "pair", "step p99 [us]", "step cpu p99 [us]",
              "fastest", "sent", "1/s", "refused", "dropped");
  int let_go = 0;
  const std::array<std::pair<const char*, const char*>, 4> targets{
      {{"mru1", "mru1"}, {"mru2", "mru2"}, {"qualisys", "frames"}, {"arm", "arm"}}};
  for (const auto& [device, name] : targets) {
    std::vector<double> ratios;
    const std::uint16_t port = port_.at(name);
    for (int pair = 0; pair < options.pairs; ++pair) {
      if (meter.mode().state != ModeState::engaged) {
        ++let_go;
        ASSERT_TRUE(meter.engage()) << meter.mode().reason.view();
        std::this_thread::sleep_for(std::chrono::seconds{5});
      }
      const test::Stretch quiet = meter.look_on(stretch);
      const auto refused_before = rejected(meter, device), dropped_before = kernel_drops(port);
      test::Stretch flooded;
      std::uint64_t sent = 0;
      double lasted_s = 0;
      {
        const test::DatagramGun gun("127.0.0.1", {port}, garbage(), options.rate, kThreads);
        const auto begin = std::chrono::steady_clock::now();
        flooded = meter.look_on(stretch);
        lasted_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
        sent = gun.sent();
      }
      // Each of them is counted by the driver or was dropped by the kernel, and nothing else happened to it.
      std::uint64_t refused = 0, dropped = 0;
      (void)eventually(
          [&, device = device] {
            refused = rejected(meter, device) - refused_before;
            dropped = kernel_drops(port) - dropped_before;
            return refused + dropped >= sent;
          },
          std::chrono::seconds{5});
      EXPECT_GE(refused + dropped, sent - sent / 100) << device;
      EXPECT_GT(refused, sent / 50) << device << ": the port is read";
      EXPECT_TRUE(gateway->running()) << gateway->output();
      EXPECT_TRUE(flooded.finite) << device;
      if (meter.mode().state == ModeState::engaged) {
        EXPECT_LT(flooded.fastest_command, kStill) << device;
      }
      ratios.push_back(flooded.step_us(0.99) / quiet.step_us(0.99));
      std::printf("%-9s %4d %8.0f > %7.0f %10.1f > %7.1f %11.5f %9" PRIu64 " %9.0f %9" PRIu64 " %9" PRIu64
                  "\n",
                  device, pair + 1, quiet.step_us(0.99), flooded.step_us(0.99), quiet.cpu_us(0.99),
                  flooded.cpu_us(0.99), flooded.fastest_command, sent, static_cast<double>(sent) / lasted_s,
                  refused, dropped);
      std::fflush(stdout);
    }
    const double ratio = test::quantile(ratios, 0.5);
    std::printf("%-9s median ratio of the step's p99: %.2f\n", device, ratio);
    EXPECT_LE(ratio, options.most_step_p99) << device;
  }
  std::printf("the gateway let go %d times before a stretch\n", let_go);
}

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  auto& options = motionlab::options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--short") {
      options = {.pairs = 1, .seconds = 2, .rate = 2e4, .most_step_p99 = 1e9};
      continue;
    }
    const double number = i + 1 < argc ? std::atof(argv[++i]) : 0;
    if (number > 0 && word == "--pairs") {
      options.pairs = static_cast<int>(number);
    } else if (number > 0 && word == "--seconds") {
      options.seconds = number;
    } else if (number > 0 && word == "--rate") {
      options.rate = number;
    } else {
      std::fprintf(stderr, "%s: see the head of tests/bench/datagram_flood_bench.cpp\n", word.c_str());
      return 64;
    }
  }
  return RUN_ALL_TESTS();
}
