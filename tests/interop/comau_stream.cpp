// What the arm's driver and the simulated robot computer say to each other, for a decoder that is not ours.
//
//   interop_comau_stream 52|124     answers of that size
//
// One line each, numbers as the speaker means them, bytes in hexadecimal:
//   > t_ns BYTES mode qd1 … qd6                    a command, and what the driver says that it sent
//   < t_ns BYTES counter q1 … q6 qd1 … qd6 [limits]  an answer, and what was measured
//   = t_ns counter q1 … q6 qd1 … qd6 [limits]        what the driver understood
// Limits, with 124: q_min, q_max, qd_max of six joints each.
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numbers>
#include <string_view>
#include <utility>

#include "drivers/comau/comau_driver.hpp"
#include "drivers/core/memory_network.hpp"
#include "simulators/comau/comau_device.hpp"

namespace {

using namespace motionlab;

void print(const std::array<double, 6>& joints) {
  for (const double value : joints) std::printf(" %.17g", value);
}

void print(Bytes datagram) {
  std::printf(" ");
  for (const auto byte : datagram) std::printf("%02x", byte);
}

/// Prints every datagram on its way out, with what `meant` prints of it.
class Tap final : public DatagramOut {
 public:
  Tap(char mark, DatagramOut& out, const Clock& clock, std::function<void()> meant)
      : mark_(mark), out_(out), clock_(clock), meant_(std::move(meant)) {}
  Status send(Endpoint to, Bytes datagram) override {
    std::printf("%c %lld", mark_, static_cast<long long>(to_ns(clock_.now())));
    print(datagram);
    if (meant_) meant_();
    return out_.send(to, datagram);
  }

 private:
  char mark_;
  DatagramOut& out_;
  const Clock& clock_;
  std::function<void()> meant_;
};

}  // namespace

int main(int argc, char** argv) {
  const bool long_answers = argc > 1 && std::string_view(argv[1]) == "124";
  const Endpoint ours = Endpoint::parse("127.0.0.1:50042");
  const Endpoint theirs = Endpoint::parse("127.0.0.1:50032");
  SteppedClock clock;
  MemoryNetwork network{clock, {.latency = 100us}};
  const auto our_socket = network.datagram(ours);
  const auto their_socket = network.datagram(theirs);

  comau::DeviceConfig robot;
  robot.hardened = true;
  robot.long_answers = long_answers;
  robot.remote_enabled_after_s = 0.1;
  const auto print_limits = [&](const auto& q_min, const auto& q_max, const auto& qd_max) {
    if (!long_answers) return;
    print(q_min);
    print(q_max);
    print(qd_max);
  };

  const std::array<double, 6> home{0, 0, -std::numbers::pi / 2, 0, 0, 0};
  std::array<double, 6> q = home;
  std::array<double, 6> qd{};
  const comau::ComauDevice* said_by = nullptr;
  Tap answers{'<', *their_socket, clock, [&] {
                std::printf(" %u", said_by->frame_counter());
                print(q);
                print(qd);
                print_limits(robot.q_min_rad, robot.q_max_rad, robot.qd_max_radps);
                std::printf("\n");
              }};
  comau::ComauDevice device{robot, answers};
  said_by = &device;
  device.cycle(clock.now(), home, {});

  comau::DriverConfig config;
  config.robot_computer = theirs;
  Tap commands{'>', *our_socket, clock, {}};
  comau::ComauDriver driver{config, commands,
                            [&](const topic::ArmState& state) {
                              std::printf("= %lld %u", static_cast<long long>(to_ns(clock.now())),
                                          state.frame_counter);
                              print(state.q_rad);
                              print(state.qd_radps);
                              print_limits(state.q_min_rad, state.q_max_rad, state.qd_max_radps);
                              std::printf("\n");
                            },
                            [](const topic::ArmCommand& sent) {
                              std::printf(" %d", sent.follow ? 1 : 0);
                              print(sent.qd_wanted_radps);
                              std::printf("\n");
                            }};
  our_socket->on_datagram([&](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
  their_socket->on_datagram([&](Bytes b, Endpoint from, LabTime t) { device.on_datagram(b, from, t); });

  while (clock.now() < from_ns(0) + 4s && !driver.stopped()) {
    network.run_until(clock.now() + 200us);
    const LabTime now = clock.now();
    const double t_s = seconds(now.time_since_epoch());
    topic::ArmCommand wanted;
    wanted.t_created_ns = to_ns(now);
    wanted.follow = t_s > 0.3 && t_s < 2.5;
    for (std::size_t i = 0; i < 6; ++i) {
      wanted.qd_wanted_radps[i] =
          0.01 * (static_cast<double>(i) + 1) * std::sin(2.0 * t_s + static_cast<double>(i));
    }
    driver.set_command(wanted);
    if (t_s > 3.0) driver.orderly_stop();
    driver.step(now);
    if (now.time_since_epoch() % 400us == 0ns) {
      q = device.set_point_rad();  // an arm that is always where it shall be
      qd = device.set_point_velocity_radps();
      device.cycle(now, q, qd);
    }
  }
  return 0;
}
