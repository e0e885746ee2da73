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

#include "tests/bench/datagram_gun.hpp"
#include "tests/bench/gateway_meter.hpp"
#include "tests/integration/process_bench.hpp"
#include "tests/support/garbage.hpp"

namespace motionlab {

const char* const integration::kGatewayProgram = MOTIONLAB_GATEWAY;
const char* const integration::kSimulatorProgram = MOTIONLAB_SIM;

namespace {

using integration::eventually;
using topic::ModeState;

struct Options {
  int pairs = 7;
  double seconds = 5;
  double rate = 1e5;
  double least_rate = 0.9e5;  ///< that must really have been sent
  double most_cpu = 1.5;      ///< median ratio of the step's p99 of processor time
} options;

constexpr int kThreads = 2;
/// What the guard may pass while a load hangs still over a still ship: rad/s and m/s.
constexpr double kStill = 0.03;

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

  /// Floods the port of one device in pairs with quiet stretches, either of which may come first.
  void compare(test::GatewayMeter& meter, const char* device, std::uint16_t port) {
    const auto stretch =
        std::chrono::milliseconds(static_cast<std::chrono::milliseconds::rep>(1e3 * options.seconds));
    std::vector<double> cpu, cpu_p99, step_p99, wakeup_p99, rates;
    for (int pair = 0; pair < options.pairs; ++pair) {
      test::Stretch quiet, flooded;
      Shots shots;
      for (const bool with_flood : {pair % 2 != 0, pair % 2 == 0}) {
        ASSERT_NO_FATAL_FAILURE(engage(meter));
        if (with_flood) {
          flooded = flood(meter, device, port, stretch, shots);
        } else {
          quiet = meter.look_on(stretch);
        }
      }
      EXPECT_TRUE(quiet.finite && flooded.finite) << device;
      EXPECT_LT(flooded.fastest_command, kStill) << device;
      cpu.push_back(flooded.cpu_us(0.5) / quiet.cpu_us(0.5));
      cpu_p99.push_back(flooded.cpu_us(0.99) / quiet.cpu_us(0.99));
      step_p99.push_back(flooded.step_us(0.99) / quiet.step_us(0.99));
      wakeup_p99.push_back(flooded.wakeup_us(0.99) / quiet.wakeup_us(0.99));
      rates.push_back(static_cast<double>(shots.sent) / shots.lasted_s);
      std::printf(
          "%-9s %4d %6.1f > %6.1f %6.1f > %6.1f %6.0f > %6.0f %6.0f > %6.0f %8.5f > %7.5f %8.0f %9" PRIu64
          " %9" PRIu64 "\n",
          device, pair + 1, quiet.cpu_us(0.5), flooded.cpu_us(0.5), quiet.cpu_us(0.99), flooded.cpu_us(0.99),
          quiet.step_us(0.99), flooded.step_us(0.99), quiet.wakeup_us(0.99), flooded.wakeup_us(0.99),
          quiet.fastest_command, flooded.fastest_command, rates.back(), shots.refused, shots.dropped);
      std::fflush(stdout);
    }
    const auto median = [](const std::vector<double>& values) { return test::quantile(values, 0.5); };
    std::printf("%-9s median ratios: step cpu p50 %.2f, p99 %.2f; step p99 %.2f; wake-up p99 %.2f; %.0f/s\n",
                device, median(cpu), median(cpu_p99), median(step_p99), median(wakeup_p99), median(rates));
    EXPECT_LE(median(cpu_p99), options.most_cpu) << device;
    EXPECT_GE(median(rates), options.least_rate) << "this machine cannot send as many";
  }

  int let_go_ = 0;

 private:
  struct Shots {
    std::uint64_t sent = 0, refused = 0, dropped = 0;
    double lasted_s = 0;
  };

  /// Engages, and waits until what that moved has come to rest.
  void engage(test::GatewayMeter& meter) {
    if (meter.mode().state == ModeState::engaged) return;
    ++let_go_;
    ASSERT_TRUE(meter.engage()) << meter.mode().reason.view();
    std::this_thread::sleep_for(std::chrono::seconds{5});
  }

  test::Stretch flood(test::GatewayMeter& meter, const char* device, std::uint16_t port,
                      std::chrono::milliseconds stretch, Shots& shots) {
    const auto refused_before = rejected(meter, device), dropped_before = kernel_drops(port);
    test::Stretch seen;
    {
      const test::DatagramGun gun("127.0.0.1", {port}, test::garbage(), options.rate, kThreads);
      const auto begin = std::chrono::steady_clock::now();
      seen = meter.look_on(stretch);
      shots.lasted_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      shots.sent = gun.sent();
    }
    // Each of them is counted by the driver or was dropped by the kernel, and nothing else happened to it.
    (void)eventually(
        [&] {
          shots.refused = rejected(meter, device) - refused_before;
          shots.dropped = kernel_drops(port) - dropped_before;
          return shots.refused + shots.dropped >= shots.sent;
        },
        std::chrono::seconds{5});
    EXPECT_GE(shots.refused + shots.dropped, shots.sent - shots.sent / 100) << device;
    EXPECT_GT(shots.refused, shots.sent / 50) << device << ": the port is read";
    return seen;
  }
};

TEST_F(DatagramFlood, ChangesNoCommandAndIsCounted) {
  const auto gateway = start_gateway();
  const auto simulator = start_simulator({"--scenario", "calm"});
  test::GatewayMeter meter(domain_, "127.0.0.1");
  ASSERT_TRUE(meter.engage()) << meter.mode().reason.view() << gateway->output() << simulator->output();
  std::this_thread::sleep_for(std::chrono::seconds{5});  // what engaging moved comes to rest

  std::printf("%-9s %4s %15s %15s %15s %15s %18s %8s %9s %9s\n", "to", "pair", "step cpu p50", "step cpu p99",
              "step p99", "wake-up p99 [us]", "fastest command", "sent/s", "refused", "dropped");
  const std::array<std::pair<const char*, const char*>, 4> targets{
      {{"mru1", "mru1"}, {"mru2", "mru2"}, {"qualisys", "frames"}, {"arm", "arm"}}};
  for (const auto& [device, name] : targets) {
    ASSERT_NO_FATAL_FAILURE(compare(meter, device, port_.at(name)));
    ASSERT_TRUE(gateway->running()) << gateway->output();
  }
  std::printf("the gateway let go %d times\n", let_go_);
}

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  auto& options = motionlab::options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--short") {
      options = {.pairs = 1, .seconds = 2, .rate = 2e4, .least_rate = 0, .most_cpu = 1e9};
      continue;
    }
    const double number = i + 1 < argc ? std::atof(argv[++i]) : 0;
    if (number > 0 && word == "--pairs") {
      options.pairs = static_cast<int>(number);
    } else if (number > 0 && word == "--seconds") {
      options.seconds = number;
    } else if (number > 0 && word == "--rate") {
      options.rate = number;
      options.least_rate = 0.9 * number;
    } else {
      std::fprintf(stderr, "%s: see the head of tests/bench/datagram_flood_bench.cpp\n", word.c_str());
      return 64;
    }
  }
  return RUN_ALL_TESTS();
}
