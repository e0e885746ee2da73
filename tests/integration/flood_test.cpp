// A hundred thousand datagrams of garbage a second, to one UDP port after the other of a gateway that holds a
// load.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/integration/process_bench.hpp"
#include "tests/support/garbage.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

constexpr int kDatagramsPerMillisecond = 100;
constexpr auto kFloodLasts = std::chrono::seconds{3};

/// @returns how many really left: a machine that is busy elsewhere sends fewer
std::uint64_t flood(std::uint16_t port) {
  const RawSocket stranger(SOCK_DGRAM);
  const auto datagrams = test::garbage();
  const auto begin = std::chrono::steady_clock::now();
  std::uint64_t sent = 0;
  for (auto now = begin; now < begin + kFloodLasts; now = std::chrono::steady_clock::now()) {
    const auto due = static_cast<std::uint64_t>(
        std::chrono::duration<double, std::milli>(now - begin).count() * kDatagramsPerMillisecond);
    for (const std::uint64_t end = std::min(due, sent + 10 * kDatagramsPerMillisecond); sent < end; ++sent) {
      stranger.send_to(port, datagrams[sent % datagrams.size()]);
    }
    std::this_thread::sleep_for(std::chrono::microseconds{500});
  }
  return sent;
}

class Flood : public Processes {
 protected:
  static std::uint64_t rejected(const Observer& observer, const char* device) {
    std::uint64_t sum = 0;
    for (const auto n : observer.health(device).rejected) sum += n;
    return sum;
  }
};

/// The most that is asked of anything while the load hangs still, and how regularly control steps.
struct Commands {
  double fastest = 0;  ///< rad/s and m/s
  bool finite = true;
  std::uint64_t steps = 0;
  std::int64_t longest_pause_ns = 0;
  double longest_step_us = 0;

  void add(const topic::Control& control) {
    for (const double qd : control.qd_command_radps) add(qd);
    add(control.wire_speed_command_mps);
    longest_step_us = std::max(longest_step_us, control.step_time_us);
    if (last_ns != 0) longest_pause_ns = std::max(longest_pause_ns, control.t_snapshot_ns - last_ns);
    last_ns = control.t_snapshot_ns;
    if (first == 0) first = control.sequence_number;
    steps = control.sequence_number - first;
  }

 private:
  void add(double speed) {
    finite = finite && std::isfinite(speed);
    fastest = std::max(fastest, std::abs(speed));
  }
  std::int64_t last_ns = 0;
  std::uint64_t first = 0;
};

// The ship lies still, so whatever moved would move because of the flood. Times are reported: the machine may
// be busy.
TEST_F(Flood, OfGarbageIsCountedAndMovesNothing) {
  Observer observer(domain_);
  auto gateway = start_gateway();
  auto simulator = start_simulator({"--scenario", "calm"});
  ASSERT_TRUE(eventually([&] { return observer.all_up(); }, kPatience))
      << gateway->output() << simulator->output();
  ASSERT_TRUE(observer.ask_until(ModeAction::engage, ModeState::engaged)) << observer.mode().reason.view();
  ASSERT_TRUE(eventually([&] { return observer.control().following; }, kPatience));
  ASSERT_TRUE(eventually(
      [&] {
        Commands now;
        now.add(observer.control());
        return now.fastest < 0.01;  // what engaging moved has come to rest
      },
      kPatience));

  const std::array<std::pair<const char*, const char*>, 4> udp_ports{
      {{"mru1", "mru1"}, {"mru2", "mru2"}, {"qualisys", "frames"}, {"arm", "arm"}}};
  for (const auto& [device, port] : udp_ports) {
    const auto refused_before = rejected(observer, device);
    std::uint64_t sent = 0;
    std::atomic<bool> over{false};
    std::thread flooder([&, port = port_.at(port)] {
      sent = flood(port);
      over = true;
    });
    Commands commands;
    while (!over) {
      commands.add(observer.control());
      std::this_thread::sleep_for(std::chrono::milliseconds{2});
    }
    flooder.join();
    EXPECT_TRUE(
        eventually([&] { return rejected(observer, device) >= refused_before + sent / 20; }, kPatience))
        << device << ": " << rejected(observer, device) - refused_before << " of " << sent;
    EXPECT_EQ(observer.mode().state, ModeState::engaged) << device << ": " << observer.mode().reason.view();
    EXPECT_TRUE(commands.finite) << device;
    EXPECT_LT(commands.fastest, 0.03) << device;
    EXPECT_GT(commands.steps, 100U) << device;
    for (const char* const other : {"mru1", "mru2", "qualisys", "arm", "winch"}) {
      EXPECT_EQ(observer.health(other).link, topic::LinkState::up) << other << " while " << device;
    }
    const std::string name(device);
    RecordProperty(name + "_sent", std::to_string(sent));
    RecordProperty(name + "_refused", std::to_string(rejected(observer, device) - refused_before));
    RecordProperty(name + "_longest_pause_ms",
                   std::to_string(1e-6 * static_cast<double>(commands.longest_pause_ns)));
    RecordProperty(name + "_longest_step_us", std::to_string(commands.longest_step_us));
    std::printf(
        "%s: %llu sent, %llu refused, longest step %.0f us, longest pause seen %.1f ms, fastest %.4f\n",
        device, static_cast<unsigned long long>(sent),
        static_cast<unsigned long long>(rejected(observer, device) - refused_before),
        commands.longest_step_us, 1e-6 * static_cast<double>(commands.longest_pause_ns), commands.fastest);
  }
  EXPECT_TRUE(gateway->running()) << gateway->output();
}

}  // namespace
}  // namespace motionlab::integration
