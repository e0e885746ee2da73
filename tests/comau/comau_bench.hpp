/// @file  Driver and robot computer joined in memory on stepped time, with an arm between set point and
/// joint.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

#include "drivers/comau/comau_driver.hpp"
#include "drivers/core/memory_network.hpp"
#include "simulators/comau/comau_device.hpp"

namespace motionlab::comau {

inline constexpr Endpoint kGateway{0x7F000001, 50042};
inline constexpr Endpoint kRobot{0x7F000001, 50032};

/// Driver and device on a memory network. The arm between set point and joint: second order, 4 Hz, damping
/// 0.7.
class ComauPair {
 public:
  explicit ComauPair(bool hardened, double remote_enabled_after_s = 0.1, bool long_answers = false)
      : network(clock, {.latency = 100us}),
        our_socket(network.datagram(kGateway)),
        their_socket(network.datagram(kRobot)),
        driver(
            driver_config(), *our_socket, [this](const topic::ArmState& s) { states.push_back(s); },
            [this](const topic::ArmCommand& c) { sent.push_back(c); }),
        device(device_config(hardened, remote_enabled_after_s, long_answers), *their_socket) {
    our_socket->on_datagram([this](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
    their_socket->on_datagram([this](Bytes b, Endpoint from, LabTime t) { device.on_datagram(b, from, t); });
    cycle(clock.now());
  }

  static DriverConfig driver_config() {
    DriverConfig c;
    c.robot_computer = kRobot;
    return c;
  }
  static DeviceConfig device_config(bool hardened, double remote_enabled_after_s, bool long_answers) {
    DeviceConfig c;
    c.hardened = hardened;
    c.long_answers = long_answers;
    c.peer = kGateway;
    c.remote_enabled_after_s = remote_enabled_after_s;
    return c;
  }

  /// Every 0.2 ms the driver is stepped if it is due, every 0.4 ms the robot cycles.
  void run(Nanoseconds duration) {
    for (const LabTime end = clock.now() + duration; clock.now() < end;) {
      network.run_until(clock.now() + 200us);
      const LabTime now = clock.now();
      if (wanted && (now.time_since_epoch() % 1ms).count() == 0) want(*wanted);
      driver.step(now);
      if ((now.time_since_epoch() % 400us).count() == 0) cycle(now);
    }
  }

  void want(const Joints& velocities, bool follow = true) {
    topic::ArmCommand command;
    command.t_created_ns = to_ns(clock.now());
    command.follow = follow;
    command.qd_wanted_radps = velocities;
    driver.set_command(command);
  }

  SteppedClock clock;
  MemoryNetwork network;
  std::unique_ptr<DatagramSocket> our_socket;
  std::unique_ptr<DatagramSocket> their_socket;
  std::vector<topic::ArmState> states;
  std::vector<topic::ArmCommand> sent;
  ComauDriver driver;
  ComauDevice device;
  std::optional<Joints> wanted;
  Joints q{0, 0, -std::numbers::pi / 2, 0, 0, 0};
  Joints qd{};
  double set_point_acceleration_max = 0.0;  ///< of joint 1, since it was last set to zero

 private:
  void cycle(LabTime now) {
    const double before = device.set_point_velocity_radps()[0];
    device.cycle(now, q, qd);
    const double after = device.set_point_velocity_radps()[0];
    set_point_acceleration_max =
        std::max(set_point_acceleration_max, std::abs(after - before) / kCycleSeconds);
    constexpr double kOmega = 2 * std::numbers::pi * 4;
    constexpr double kZeta = 0.7;
    for (std::size_t i = 0; i < kJointCount; ++i) {
      if (!device.drives_on()) {  // the brakes hold it
        qd[i] = 0.0;
        continue;
      }
      const double qdd = kOmega * kOmega * (device.set_point_rad()[i] - q[i]) - 2 * kZeta * kOmega * qd[i];
      qd[i] += qdd * kCycleSeconds;
      q[i] += qd[i] * kCycleSeconds;
    }
  }
};

}  // namespace motionlab::comau
