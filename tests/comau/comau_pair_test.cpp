// Driver and robot computer joined in memory on stepped time, with an arm of second order between set point
// and joint.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "drivers/comau/comau_driver.hpp"
#include "drivers/core/memory_network.hpp"
#include "simulators/comau/comau_device.hpp"

namespace motionlab::comau {
namespace {

constexpr Endpoint kGateway{0x7F000001, 50042};
constexpr Endpoint kRobot{0x7F000001, 50032};

class ComauPair {
 public:
  explicit ComauPair(bool hardened, double remote_enabled_after_s = 0.1)
      : network(clock, {.latency = 100us}),
        our_socket(network.datagram(kGateway)),
        their_socket(network.datagram(kRobot)),
        driver(driver_config(), *our_socket, [this](const topic::ArmState& s) { states.push_back(s); }),
        device(device_config(hardened, remote_enabled_after_s), *their_socket) {
    our_socket->on_datagram([this](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
    their_socket->on_datagram([this](Bytes b, Endpoint from, LabTime t) { device.on_datagram(b, from, t); });
  }

  static DriverConfig driver_config() {
    DriverConfig c;
    c.robot_computer = kRobot;
    return c;
  }
  static DeviceConfig device_config(bool hardened, double remote_enabled_after_s) {
    DeviceConfig c;
    c.hardened = hardened;
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
      const double qdd = kOmega * kOmega * (device.set_point_rad()[i] - q[i]) - 2 * kZeta * kOmega * qd[i];
      qd[i] += qdd * kCycleSeconds;
      q[i] += qd[i] * kCycleSeconds;
    }
  }
};

class ComauPairTest : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(FaithfulAndHardened, ComauPairTest, ::testing::Bool());

TEST_P(ComauPairTest, ExchangesTwoHundredTimesASecondAndLosesNothing) {
  ComauPair pair{GetParam()};
  pair.run(2s);
  EXPECT_NEAR(static_cast<double>(pair.states.size()), 400.0, 1.0);
  EXPECT_EQ(pair.driver.health().rejected_total(), 0u);
  EXPECT_EQ(pair.driver.health().lost(), 0u);
  EXPECT_EQ(pair.device.health().rejected_total(), 0u);
  EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up);
  EXPECT_FALSE(pair.device.crashed()) << "the stream runs before remote mode is selected";
  for (std::size_t k = 1; k < pair.states.size(); ++k) {
    const auto frames = pair.states[k].frame_counter - pair.states[k - 1].frame_counter;
    EXPECT_TRUE(frames == 12 || frames == 13) << frames;
  }
}

TEST_P(ComauPairTest, MovesTheArmAsWantedAndTellsWhereItIs) {
  ComauPair pair{GetParam()};
  pair.run(200ms);
  pair.wanted = Joints{0.2, 0, -0.1, 0, 0, 0};
  pair.run(1s);
  EXPECT_NEAR(pair.q[0], 0.2 * (1.0 - 0.056), 5e-3);
  EXPECT_NEAR(pair.q[2], -std::numbers::pi / 2 - 0.1 * (1.0 - 0.056), 5e-3);
  EXPECT_NEAR(pair.states.back().q_rad[0], pair.q[0], 2e-3);
  EXPECT_NEAR(pair.states.back().qd_radps[0], 0.2, 2e-3);
  EXPECT_TRUE(pair.states.back().following);
}

TEST_P(ComauPairTest, ComesToRestGentlyWhenTheControllerDies) {
  ComauPair pair{GetParam()};
  pair.run(200ms);
  pair.wanted = Joints{0.3, 0, 0, 0, 0, 0};
  pair.run(1s);
  pair.wanted.reset();
  const double q0 = pair.q[0];
  pair.run(2s);
  EXPECT_EQ(pair.driver.last_sent()->mode, 0);
  EXPECT_NEAR(pair.qd[0], 0.0, 1e-4);
  // 25 ms until stale, at most one period, the ramp, the lag of the arm.
  EXPECT_LT(pair.q[0] - q0, 0.3 * (0.030 + 0.3 / 2 + 0.060));
}

TEST_P(ComauPairTest, LeavesModeOneWithoutAJolt) {
  ComauPair pair{GetParam()};
  pair.run(200ms);
  pair.wanted = Joints{0.3, 0, 0, 0, 0, 0};
  pair.run(1s);
  pair.wanted.reset();
  pair.want({}, false);
  Joints before = pair.qd;
  double jolt_radps = 0.0;
  for (int k = 0; k < 5000; ++k) {
    pair.run(400us);
    jolt_radps = std::max(jolt_radps, std::abs(pair.qd[0] - before[0]));
    before = pair.qd;
  }
  EXPECT_LT(jolt_radps / kCycleSeconds, 1.6) << "the arm's deceleration, overshoot of the servo included";
}

TEST_P(ComauPairTest, StaysInTheBoxAtFullCommand) {
  ComauPair pair{GetParam()};
  pair.run(200ms);
  pair.wanted = Joints{9, 9, 9, 9, 9, 9};
  pair.run(5s);
  const DeviceConfig box;
  for (std::size_t i = 0; i < kJointCount; ++i) EXPECT_NEAR(pair.q[i], box.q_max_rad[i], 1e-3);
}

TEST_P(ComauPairTest, StopsInOrder) {
  ComauPair pair{GetParam()};
  pair.run(200ms);
  pair.wanted = Joints{0.3, 0, 0, 0, 0, 0};
  pair.run(500ms);
  pair.driver.orderly_stop();
  pair.run(1s);
  EXPECT_TRUE(pair.driver.stopped());
  EXPECT_NEAR(pair.qd[0], 0.0, 1e-3);
  EXPECT_FALSE(pair.device.following());
}

TEST(ComauPair, OnlyTheHardenedComputerStopsWhenTheCableIsCut) {
  for (const bool hardened : {false, true}) {
    ComauPair pair{hardened};
    pair.run(200ms);
    pair.wanted = Joints{0.3, 0, 0, 0, 0, 0};
    pair.run(500ms);
    pair.network.set_datagram_fault(kRobot, {.silent = true});
    pair.run(1s);
    EXPECT_EQ(pair.device.set_point_velocity_radps()[0] == 0.0, hardened);
  }
}

TEST(ComauPair, FollowsTheWantedVelocityThroughLossAndJitter) {
  ComauPair pair{true};
  pair.network.set_datagram_fault(kRobot, {.loss = 0.05, .jitter = 2ms});
  pair.network.set_datagram_fault(kGateway, {.loss = 0.05, .jitter = 2ms});
  pair.run(200ms);
  pair.wanted = Joints{0.1, 0, 0, 0, 0, 0};
  pair.run(3s);
  EXPECT_NEAR(pair.q[0], 0.1 * (3.0 - 0.056), 5e-3);
  EXPECT_NEAR(static_cast<double>(pair.driver.health().lost()), 64.0, 25.0);
}

TEST(ComauPair, CountsWhatTheRobotComputerDoesWrong) {
  const std::vector<std::pair<std::string_view, Reason>> faults{{"wrong_size", Reason::too_short},
                                                                {"nan_answer", Reason::bad_value},
                                                                {"freeze_counter", Reason::duplicate}};
  for (const auto& [name, reason] : faults) {
    ComauPair pair{true};
    pair.run(200ms);
    ASSERT_TRUE(pair.device.set_fault(name, true).ok());
    const auto states = pair.states.size();
    pair.run(500ms);
    EXPECT_LE(pair.states.size(), states + 1) << name;
    EXPECT_GE(pair.driver.health().rejected(reason), 98u) << name;
    ASSERT_TRUE(pair.device.set_fault(name, false).ok());
    pair.run(200ms);
    EXPECT_GT(pair.states.size(), states + 30) << name;
  }
}

TEST(ComauPair, SaysThatTheArmDoesNotMoveWhenTheDrivesAreOff) {
  ComauPair pair{true};
  pair.run(200ms);
  ASSERT_TRUE(pair.device.set_fault("drive_off", true).ok());
  pair.wanted = Joints{0.1, 0, 0, 0, 0, 0};
  pair.run(500ms);
  EXPECT_NE(pair.driver.health().advice().find("told to move"), std::string_view::npos);
}

}  // namespace
}  // namespace motionlab::comau
