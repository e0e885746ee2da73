#include "simulators/comau/comau_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "tests/comau/comau_frames.hpp"

namespace motionlab::comau {
namespace {

constexpr Endpoint kGateway{0xC0A85A2A, 50042};
constexpr Endpoint kStranger{0xC0A85AFE, 4711};
constexpr Joints kHome{0, 0, -std::numbers::pi / 2, 0, 0, 0};
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

class Robot : public DatagramOut {
 public:
  explicit Robot(DeviceConfig config) : dut(config, *this) {}
  static DeviceConfig faithful() {
    DeviceConfig c;
    c.remote_enabled_after_s = 0.0;
    return c;
  }
  static DeviceConfig hardened() {
    DeviceConfig c = faithful();
    c.hardened = true;
    c.peer = kGateway;
    return c;
  }

  Status send(Endpoint to, Bytes datagram) override {
    answered_to.push_back(to);
    answers.emplace_back(datagram.begin(), datagram.end());
    return Done{};
  }

  void command(std::int32_t mode, const std::array<float, 6>& qd, Endpoint from = kGateway,
               std::int32_t key = kKey) {
    dut.on_datagram(encode(Command{key, mode, qd}), from, now);
  }

  /// Cycles with an ideal arm; repeats the given command every 5 ms if there is one.
  void run(Nanoseconds duration, const std::optional<Command>& repeated = {}) {
    for (const LabTime end = now + duration; now < end; now += 400us) {
      if (repeated && (now - t_repeated >= 5ms)) {
        t_repeated = now;
        dut.on_datagram(encode(*repeated), kGateway, now);
      }
      dut.cycle(now, q, {});
      if (arm_follows) q = dut.set_point_rad();
    }
  }

  LabTime now = from_ns(1'000'000'000);
  LabTime t_repeated{};
  Joints q = kHome;
  bool arm_follows = true;
  std::vector<Endpoint> answered_to;
  std::vector<ByteBuffer> answers;
  ComauDevice dut;
};

Command follow(const std::array<float, 6>& qd) {
  return Command{kKey, 1, qd};
}

TEST(ComauDevice, AnswersEachDatagramAtOnceToItsSender) {
  Robot robot{Robot::faithful()};
  robot.command(0, {});
  robot.run(4ms);
  robot.dut.on_datagram(kCommandBytes, kStranger, robot.now);
  ASSERT_EQ(robot.answers.size(), 2u);
  EXPECT_EQ(robot.answered_to[0], kGateway);
  EXPECT_EQ(robot.answered_to[1], kStranger);
  const auto answer = decode_answer(robot.answers[1]);
  ASSERT_TRUE(answer.ok());
  EXPECT_EQ(answer->frame_counter, 10u) << "one per cycle of 0.4 ms, not per datagram";
  EXPECT_NEAR(answer->q_rad[2], kHome[2], 1e-6);
}

TEST(ComauDevice, SendsNothingByItself) {
  Robot robot{Robot::hardened()};
  robot.run(1s);
  EXPECT_TRUE(robot.answers.empty());
  EXPECT_EQ(robot.dut.frame_counter(), 2500u);
}

TEST(ComauDevice, CountsFramesThroughTheWrap) {
  DeviceConfig config = Robot::faithful();
  config.frame_counter_start = 0xFFFFFFFF;
  Robot robot{config};
  robot.command(0, {});
  robot.run(800us);
  EXPECT_EQ(robot.dut.frame_counter(), 1u);
}

TEST(ComauDevice, IntegratesTheWantedVelocity) {
  for (const bool hardened : {false, true}) {
    Robot robot{hardened ? Robot::hardened() : Robot::faithful()};
    robot.run(1s, follow({0.1F, -0.05F, 0.2F, 0.01F, 0, 0}));
    // v²/(2a) is what the hardened program needs to get up to speed.
    EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.1, 1e-3);
    EXPECT_NEAR(robot.dut.set_point_rad()[1], -0.05, 1e-3);
    EXPECT_NEAR(robot.dut.set_point_rad()[2], kHome[2] + 0.2, 1e-3 + (hardened ? 0.2 * 0.2 / 20 : 0));
    EXPECT_NEAR(robot.dut.set_point_rad()[3], 0.01, 1e-3);
  }
}

TEST(ComauDevice, AnswersInTheLongFormWithItsOwnLimits) {
  DeviceConfig config = Robot::hardened();
  config.long_answers = true;
  Robot robot{config};
  robot.run(1ms);
  robot.command(0, {});
  ASSERT_EQ(robot.answers.back().size(), 124u);
  const auto answer = decode_answer(robot.answers.back());
  ASSERT_TRUE(answer.ok() && answer->limits);
  for (std::size_t i = 0; i < kJointCount; ++i) {
    EXPECT_NEAR(answer->limits->q_min_rad[i], config.q_min_rad[i], 1e-6);
    EXPECT_NEAR(answer->limits->q_max_rad[i], config.q_max_rad[i], 1e-6);
    EXPECT_NEAR(answer->limits->qd_max_radps[i], config.qd_max_radps[i], 1e-6);
  }
}

TEST(ComauDevice, NeverLeavesTheBoxAtFullCommandAndBrakesBeforeItsEdge) {
  for (const bool hardened : {false, true}) {
    for (const float direction : {1.0F, -1.0F}) {
      const DeviceConfig config = hardened ? Robot::hardened() : Robot::faithful();
      Robot robot{config};
      robot.command(0, {});
      robot.run(1ms);
      const float v = direction * 100.0F;
      Joints before = robot.dut.set_point_velocity_radps();
      for (int k = 0; k < 12000; ++k) {
        robot.run(400us, follow({v, v, v, v, v, v}));
        const Joints& q = robot.dut.set_point_rad();
        const Joints& qd = robot.dut.set_point_velocity_radps();
        for (std::size_t i = 0; i < kJointCount; ++i) {
          ASSERT_GE(q[i], config.q_min_rad[i]);
          ASSERT_LE(q[i], config.q_max_rad[i]);
          ASSERT_LE(std::abs(qd[i]), config.qd_max_radps[i]);
          // The bound sqrt(2 a d) brakes at a; the last cycle at the edge closes what is left of it.
          ASSERT_LE(std::abs(before[i]) - std::abs(qd[i]), 2.1 * config.deceleration_radps2 * kCycleSeconds);
        }
        before = qd;
      }
      const Joints& edge = direction > 0 ? config.q_max_rad : config.q_min_rad;
      for (std::size_t i = 0; i < kJointCount; ++i) EXPECT_NEAR(robot.dut.set_point_rad()[i], edge[i], 1e-5);
    }
  }
}

TEST(ComauDevice, IgnoresCommandsUntilTheOperatorSelectsRemote) {
  for (const bool hardened : {false, true}) {
    DeviceConfig config = hardened ? Robot::hardened() : Robot::faithful();
    config.remote_enabled_after_s = 0.5;
    Robot robot{config};
    robot.run(499ms, follow({0.2F, 0, 0, 0, 0, 0}));
    EXPECT_EQ(robot.dut.set_point_rad(), kHome);
    EXPECT_FALSE(robot.dut.following());
    robot.run(500ms, follow({0.2F, 0, 0, 0, 0, 0}));
    EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.1, 3e-3);
  }
}

TEST(ComauDevice, FollowsOnlyKey32AndModeOne) {
  Robot robot{Robot::faithful()};
  for (const auto& [key, mode] : {std::pair{33, 1}, std::pair{32, 0}, std::pair{32, 2}, std::pair{32, -1}}) {
    robot.command(mode, {0.2F, 0, 0, 0, 0, 0}, kGateway, key);
    robot.run(20ms);
    EXPECT_EQ(robot.dut.set_point_rad(), kHome);
  }
}

// The defects of the published program, by their numbers, and their cures.

TEST(ComauDeviceFaithful, Defect1GoesOnMovingWhenCommandsStop) {
  Robot robot{Robot::faithful()};
  robot.command(1, {0.2F, 0, 0, 0, 0, 0});
  robot.run(10s);
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 45 * kDegree, 1e-4);
}

TEST(ComauDeviceFaithful, Defect2ExecutesAShortDatagramTogetherWithTheRestOfTheOneBefore) {
  Robot robot{Robot::faithful()};
  robot.command(0, {0.2F, 0, 0, 0, 0, 0});
  robot.run(1ms);
  const auto whole = encode(follow({}));
  robot.dut.on_datagram(Bytes{whole}.first(8), kGateway, robot.now);  // key and mode 1, no velocities
  robot.run(100ms);
  EXPECT_EQ(robot.answers.size(), 2u) << "it is even answered";
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.02, 1e-3);
}

TEST(ComauDeviceFaithful, Defect2ReadsTheBeginningOfALongDatagram) {
  Robot robot{Robot::faithful()};
  ByteBuffer bytes(200, 0xFF);
  const auto whole = encode(follow({0.2F, 0, 0, 0, 0, 0}));
  std::copy(whole.begin(), whole.end(), bytes.begin());
  robot.dut.on_datagram(bytes, kGateway, robot.now);
  robot.run(100ms);
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.02, 1e-3);
}

TEST(ComauDeviceFaithful, Defect2ReadsACommandThatIsHalfWritten) {
  Robot robot{Robot::faithful()};
  robot.command(1, {0, 0, 0, 0.05F, 0, 0});
  robot.run(400us);
  ASSERT_TRUE(robot.dut.set_fault("torn", true).ok());
  robot.command(1, {0.1F, 0, 0, 0, 0, 0});  // the first 20 bytes end before joint 4
  robot.run(400us);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[0], 0.1, 1e-6);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[3], 0.05, 1e-6) << "of the command before";
  robot.run(400us);
  EXPECT_EQ(robot.dut.set_point_velocity_radps()[3], 0.0);
}

TEST(ComauDeviceFaithful, Defect2ExecutesAnOldCommandThatComesAgain) {
  Robot robot{Robot::faithful()};
  robot.command(1, {0.2F, 0, 0, 0, 0, 0});
  robot.run(100ms);
  robot.command(1, {});
  robot.run(1ms);
  robot.command(1, {0.2F, 0, 0, 0, 0, 0});  // sent long ago, arriving now
  robot.run(10s);
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 45 * kDegree, 1e-4);
}

TEST(ComauDeviceFaithful, Defect3TakesNaNForFullSpeedTowardsTheLowerEdge) {
  Robot robot{Robot::faithful()};
  robot.command(1, {kNaN, 0, 0, kNaN, 0, 0});
  robot.run(100ms);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[0], -30 * kDegree, 1e-9);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[3], -3 * kDegree, 1e-9);
  EXPECT_EQ(robot.dut.set_point_rad()[1], 0.0);
}

TEST(ComauDeviceFaithful, Defect4EndsWhenRemoteIsSelectedBeforeTheFirstDatagram) {
  DeviceConfig config = Robot::faithful();
  config.remote_enabled_after_s = 0.1;
  Robot robot{config};
  robot.run(200ms);
  EXPECT_TRUE(robot.dut.crashed());
  EXPECT_FALSE(robot.dut.drives_on());
  const auto counter = robot.dut.frame_counter();
  robot.command(0, {});
  robot.run(100ms);
  EXPECT_TRUE(robot.answers.empty());
  EXPECT_EQ(robot.dut.frame_counter(), counter);

  Robot in_order{config};
  in_order.command(0, {});
  in_order.run(200ms);
  EXPECT_FALSE(in_order.dut.crashed());
}

TEST(ComauDeviceFaithful, Defect5TakesUpAnySpeedInOneCycle) {
  Robot robot{Robot::faithful()};
  robot.command(1, {0.5F, 0, 0, 0, 0, 0});
  robot.run(400us);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[0], 0.5, 1e-6);
}

TEST(ComauDeviceFaithful, Defect5DropsItsSpeedInOneCycleWhenModeOneEnds) {
  Robot robot{Robot::faithful()};
  robot.arm_follows = false;  // an arm that lags behind
  robot.command(1, {0.3F, 0, 0, 0, 0, 0});
  robot.run(200ms);
  EXPECT_GT(robot.dut.set_point_rad()[0], 0.05);
  robot.command(0, {});
  robot.run(400us);
  EXPECT_EQ(robot.dut.set_point_velocity_radps()[0], 0.0);
  EXPECT_EQ(robot.dut.set_point_rad()[0], 0.0) << "the set point jumps back to where the arm is";
}

TEST(ComauDeviceFaithful, Defect6CreepsInHoldWhenTheArmDoes) {
  Robot robot{Robot::faithful()};
  robot.command(0, {});
  robot.run(1ms);
  robot.q[1] = 0.01;
  robot.run(1ms);
  EXPECT_EQ(robot.dut.set_point_rad()[1], 0.01);
}

/// A flood of commands for a tenth of a second, 30 in each cycle of 0.4 ms.
void flood(Robot& robot) {
  for (int cycle = 0; cycle < 250; ++cycle) {
    for (int k = 0; k < 30; ++k) robot.command(0, {});
    robot.run(400us);
  }
}

TEST(ComauDeviceFaithful, Defect7MissesCyclesInAFlood) {
  Robot robot{Robot::faithful()};
  flood(robot);
  EXPECT_GT(robot.dut.missed_cycles(), 200u);
  EXPECT_EQ(robot.dut.frame_counter() + robot.dut.missed_cycles(), 250u);
}

TEST(ComauDeviceFaithful, Defect8ObeysAnyHost) {
  Robot robot{Robot::faithful()};
  robot.command(1, {0.2F, 0, 0, 0, 0, 0}, kStranger);
  robot.run(100ms);
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.02, 1e-3);
}

TEST(ComauDeviceHardened, Cure2ExecutesNoPartOfADatagramOfAnotherLength) {
  Robot robot{Robot::hardened()};
  robot.command(0, {0.2F, 0, 0, 0, 0, 0});
  robot.run(1ms);
  const auto whole = encode(follow({0.2F, 0, 0, 0, 0, 0}));
  ByteBuffer longer(whole.begin(), whole.end());
  longer.push_back(0);
  for (std::size_t n = 0; n < whole.size(); ++n) {
    robot.dut.on_datagram(Bytes{whole}.first(n), kGateway, robot.now);
    robot.run(1ms);
  }
  robot.dut.on_datagram(longer, kGateway, robot.now);
  robot.run(1ms);
  EXPECT_EQ(robot.dut.set_point_rad(), kHome);
  EXPECT_EQ(robot.dut.health().rejected(Reason::too_short), 32u);
  EXPECT_EQ(robot.dut.health().rejected(Reason::too_long), 1u);
}

TEST(ComauDeviceHardened, Cure2HandsACommandOverWhole) {
  Robot robot{Robot::hardened()};
  const Status status = robot.dut.set_fault("torn", true);
  ASSERT_FALSE(status.ok());
  EXPECT_NE(status.fault().text.find("whole"), std::string_view::npos);
  EXPECT_EQ(status.fault().reason, Reason::refused);
}

TEST(ComauDeviceHardened, Cure3RefusesNaNAndGoesOnWithTheCommandBefore) {
  Robot robot{Robot::hardened()};
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  robot.command(1, {kNaN, 0, 0, kNaN, 0, 0});
  robot.run(4ms);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[0], 0.1, 1e-6);
  EXPECT_EQ(robot.dut.set_point_velocity_radps()[3], 0.0);
  EXPECT_EQ(robot.dut.health().rejected(Reason::bad_value), 1u);
}

TEST(ComauDeviceHardened, Cure5TakesUpASpeedWithinItsAcceleration) {
  Robot robot{Robot::hardened()};
  double before = 0.0;
  for (int k = 0; k < 200; ++k) {
    robot.run(400us, follow({0.5F, 0, 0, 0, 0, 0}));
    ASSERT_LE(robot.dut.set_point_velocity_radps()[0] - before, 10 * kCycleSeconds + 1e-12);
    before = robot.dut.set_point_velocity_radps()[0];
  }
  EXPECT_NEAR(before, 0.5, 1e-6);
}

TEST(ComauDeviceHardened, Cure6HoldsItsSetPointWhenTheArmCreeps) {
  Robot robot{Robot::hardened()};
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  robot.run(300ms, Command{});
  const Joints held = robot.dut.set_point_rad();
  robot.arm_follows = false;
  robot.q[0] += 0.01;
  robot.run(100ms, Command{});
  EXPECT_EQ(robot.dut.set_point_rad(), held);
  robot.run(400us, follow({0.1F, 0, 0, 0, 0, 0}));
  EXPECT_NEAR(robot.dut.set_point_rad()[0], held[0], 1e-5) << "it goes on from what was commanded";
}

TEST(ComauDeviceHardened, Cure7MissesNoCycleInAFlood) {
  Robot robot{Robot::hardened()};
  flood(robot);
  EXPECT_EQ(robot.dut.missed_cycles(), 0u);
  EXPECT_EQ(robot.dut.frame_counter(), 250u);
}

TEST(ComauDeviceHardened, Cure8ObeysNobodyButItsPeer) {
  Robot robot{Robot::hardened()};
  robot.command(1, {0.2F, 0, 0, 0, 0, 0}, kStranger);
  robot.run(100ms);
  EXPECT_EQ(robot.dut.set_point_rad(), kHome);
  EXPECT_TRUE(robot.answers.empty());
  EXPECT_EQ(robot.dut.health().rejected(Reason::foreign), 1u);
}

TEST(ComauDeviceHardened, Cure1RampsToRestWhenCommandsStopAndHoldsThere) {
  Robot robot{Robot::hardened()};
  robot.run(500ms, follow({0.3F, 0, 0, 0, 0, 0}));
  const double q0 = robot.dut.set_point_rad()[0];
  robot.run(14ms);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[0], 0.3, 1e-6) << "up to 20 ms are bridged";
  Joints before = robot.dut.set_point_velocity_radps();
  for (int k = 0; k < 1000; ++k) {
    robot.run(400us);
    ASSERT_LE(before[0] - robot.dut.set_point_velocity_radps()[0], 1.0 * kCycleSeconds + 1e-12);
    before = robot.dut.set_point_velocity_radps();
  }
  EXPECT_EQ(before[0], 0.0);
  EXPECT_NEAR(robot.dut.set_point_rad()[0] - q0, 0.3 * 0.018 + 0.3 * 0.3 / 2, 2e-3);
  EXPECT_GT(robot.dut.stale_cycles(), 0u);
  const double held = robot.dut.set_point_rad()[0];
  robot.arm_follows = false;
  robot.q[0] = held - 0.01;
  robot.run(10ms);
  EXPECT_EQ(robot.dut.set_point_rad()[0], held) << "held, not creeping after the arm";
}

TEST(ComauDeviceHardened, Cure5RampsToRestWhenModeOneEnds) {
  Robot robot{Robot::hardened()};
  robot.run(500ms, follow({0.3F, 0, 0, 0, 0, 0}));
  Joints before = robot.dut.set_point_velocity_radps();
  for (int k = 0; k < 1000; ++k) {
    robot.run(400us, Command{});
    ASSERT_LE(before[0] - robot.dut.set_point_velocity_radps()[0], 1.0 * kCycleSeconds + 1e-12);
    before = robot.dut.set_point_velocity_radps();
  }
  EXPECT_EQ(before[0], 0.0);
}

TEST(ComauDeviceHardened, RefusesCountsAndDoesNotAnswerWhatIsNotAcceptable) {
  Robot robot{Robot::hardened()};
  robot.command(0, {});
  robot.run(1ms);
  robot.command(1, {kNaN, 0, 0, 0, 0, 0});
  robot.command(1, {0.2F, 0, 0, 0, 0, 0}, kGateway, 33);
  robot.command(2, {0.2F, 0, 0, 0, 0, 0});
  robot.command(1, {0.2F, 0, 0, 0, 0, 0}, kStranger);
  robot.command(1, {0.2F, 0, 0, 0, 0, 0}, Endpoint{kGateway.address, 1});
  const auto whole = encode(follow({0.2F, 0, 0, 0, 0, 0}));
  robot.dut.on_datagram(Bytes{whole}.first(31), kGateway, robot.now);
  robot.dut.on_datagram(ByteBuffer(33, 0), kGateway, robot.now);
  robot.run(100ms);
  EXPECT_EQ(robot.dut.set_point_rad(), kHome);
  EXPECT_EQ(robot.answers.size(), 1u);
  const LinkHealth& health = robot.dut.health();
  EXPECT_EQ(health.rejected(Reason::bad_value), 1u);
  EXPECT_EQ(health.rejected(Reason::bad_header), 2u);
  EXPECT_EQ(health.rejected(Reason::foreign), 2u);
  EXPECT_EQ(health.rejected(Reason::too_short), 1u);
  EXPECT_EQ(health.rejected(Reason::too_long), 1u);
  EXPECT_EQ(health.received(), 1u);
}

TEST(ComauDeviceHardened, Cure4DoesNotEndWhenRemoteIsSelectedBeforeTheFirstDatagram) {
  Robot robot{Robot::hardened()};
  robot.run(1s);
  EXPECT_FALSE(robot.dut.crashed());
  EXPECT_EQ(robot.dut.set_point_rad(), kHome);
}

TEST(ComauDeviceHardened, ExecutesOnlyTheNewestOfABacklog) {
  Robot robot{Robot::hardened()};
  for (int k = 0; k < 200; ++k) robot.command(1, {0.3F, 0, 0, 0, 0, 0});
  robot.command(0, {});
  robot.run(100ms);
  EXPECT_EQ(robot.dut.set_point_rad(), kHome);
}

// Faults.

TEST(ComauDevice, FallsSilentInBothDirections) {
  Robot robot{Robot::faithful()};
  robot.command(0, {});
  ASSERT_TRUE(robot.dut.set_fault("silent", true).ok());
  robot.command(1, {0.2F, 0, 0, 0, 0, 0});
  robot.run(100ms);
  EXPECT_EQ(robot.answers.size(), 1u);
  EXPECT_EQ(robot.dut.set_point_rad(), kHome);
  EXPECT_EQ(robot.dut.frame_counter(), 250u);
}

TEST(ComauDevice, FreezesItsCounter) {
  Robot robot{Robot::faithful()};
  robot.command(0, {});
  robot.run(100ms);
  ASSERT_TRUE(robot.dut.set_fault("freeze_counter", true).ok());
  robot.run(100ms);
  EXPECT_EQ(robot.dut.frame_counter(), 250u);
}

TEST(ComauDevice, AnswersWithAWrongSize) {
  Robot robot{Robot::faithful()};
  const std::vector<std::pair<double, std::size_t>> sizes{{0, 51}, {64, 116}, {-52, 0}, {-999, 0}, {1, 53}};
  for (const auto& [value, size] : sizes) {
    ASSERT_TRUE(robot.dut.set_fault("wrong_size", true, value).ok());
    robot.command(0, {});
    EXPECT_EQ(robot.answers.back().size(), size);
  }
}

TEST(ComauDevice, AnswersNaN) {
  Robot robot{Robot::faithful()};
  ASSERT_TRUE(robot.dut.set_fault("nan_answer", true).ok());
  robot.command(0, {});
  EXPECT_EQ(decode_answer(robot.answers.back()).fault().reason, Reason::bad_value);
}

TEST(ComauDevice, MissesNothingAndSaysNothingWithoutPowerAndBootsAfterIt) {
  DeviceConfig config = Robot::hardened();
  config.pendant.powerlink_after_s = 0.1;
  config.frame_counter_start = 7;
  Robot robot{config};
  robot.run(500ms, follow({0.1F, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(robot.dut.set_fault("off", true).ok());
  const auto answers = robot.answers.size();
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  EXPECT_EQ(robot.answers.size(), answers);
  EXPECT_FALSE(robot.dut.drives_on());
  ASSERT_TRUE(robot.dut.set_fault("off", false).ok());
  EXPECT_EQ(robot.dut.frame_counter(), 7u);
  robot.run(99ms, Command{});
  EXPECT_FALSE(robot.dut.drives_on());
  EXPECT_EQ(robot.dut.frame_counter(), 7u) << "no cycle before POWERLINK is active";
  robot.run(10ms, Command{});
  EXPECT_TRUE(robot.dut.drives_on());
  EXPECT_GT(robot.dut.frame_counter(), 7u);
}

TEST(ComauDevice, IsRevivedBySwitchingOffAndOn) {
  Robot robot{Robot::faithful()};
  robot.run(1ms);
  ASSERT_TRUE(robot.dut.crashed());
  ASSERT_TRUE(robot.dut.set_fault("off", true).ok());
  ASSERT_TRUE(robot.dut.set_fault("off", false).ok());
  robot.command(0, {});
  robot.run(1ms);
  EXPECT_FALSE(robot.dut.crashed());
  EXPECT_EQ(robot.answers.size(), 1u);
}

TEST(ComauDevice, SaysTheSamePostureForEverWhenItsMeasurementIsStuckWhileItsCounterRuns) {
  Robot robot{Robot::hardened()};
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(robot.dut.set_fault("stuck", true).ok());
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  const auto first = decode_answer(*(robot.answers.end() - 10)).value();
  const auto last = decode_answer(robot.answers.back()).value();
  EXPECT_EQ(first.q_rad, last.q_rad);
  EXPECT_GT(last.frame_counter, first.frame_counter + 100);
  EXPECT_GT(robot.q[0], last.q_rad[0] + 0.005) << "the arm itself goes on";
}

TEST(ComauDevice, SpeaksGarbageOfTheSameLength) {
  for (const bool long_answers : {false, true}) {
    DeviceConfig config = Robot::hardened();
    config.long_answers = long_answers;
    Robot robot{config};
    ASSERT_TRUE(robot.dut.set_fault("garbage", true).ok());
    robot.command(0, {});
    robot.command(0, {});
    EXPECT_EQ(robot.answers[0].size(), long_answers ? 124u : 52u);
    EXPECT_NE(robot.answers[0], robot.answers[1]);
  }
}

TEST(ComauDevice, IsWrongByAsMuchAsItWasTold) {
  Robot robot{Robot::hardened()};
  robot.run(1ms);
  ASSERT_TRUE(robot.dut.set_fault("wrong", true, 0.05).ok());
  robot.command(0, {});
  EXPECT_NEAR(decode_answer(robot.answers.back())->q_rad[2], kHome[2] + 0.05, 1e-6);
}

TEST(ComauDevice, AnswersMoreRarelyWhenItIsSlow) {
  Robot robot{Robot::hardened()};
  ASSERT_TRUE(robot.dut.set_fault("slow", true).ok());
  robot.run(1s, Command{});
  EXPECT_NEAR(static_cast<double>(robot.answers.size()), 49.0, 2.0);
  EXPECT_EQ(robot.dut.frame_counter(), 2500u);
}

TEST(ComauDevice, AnswersLateWhenItIsDelayed) {
  Robot robot{Robot::faithful()};
  ASSERT_TRUE(robot.dut.set_fault("delayed", true, 0.01).ok());
  robot.command(0, {});
  robot.run(9ms);
  EXPECT_TRUE(robot.answers.empty());
  robot.run(2ms);
  EXPECT_EQ(robot.answers.size(), 1u);
}

TEST(ComauDevice, AnswersHalfTheTimeWhenItIsIntermittent) {
  Robot robot{Robot::hardened()};
  ASSERT_TRUE(robot.dut.set_fault("intermittent", true, 0.1).ok());
  robot.run(1s, Command{});
  EXPECT_NEAR(static_cast<double>(robot.answers.size()), 100.0, 3.0);
}

// The pendant.

TEST(ComauDevice, IsSwitchedOnByItsOperatorStepByStep) {
  DeviceConfig config = Robot::hardened();
  config.pendant = {
      .powerlink_after_s = 0.1, .drive_on_after_s = 0.1, .driving_on_s = 0.1, .start_after_s = 0.1};
  Robot robot{config};
  const Command wanted = follow({0.1F, 0, 0, 0, 0, 0});
  robot.run(99ms, wanted);
  EXPECT_FALSE(robot.dut.pendant().powerlink());
  EXPECT_EQ(robot.dut.frame_counter(), 0u) << "the controller calls no cycle";
  robot.run(100ms, wanted);
  EXPECT_TRUE(robot.dut.pendant().powerlink());
  EXPECT_EQ(robot.dut.pendant().drives(), Pendant::Drives::off);
  robot.run(100ms, wanted);
  EXPECT_EQ(robot.dut.pendant().drives(), Pendant::Drives::driving_on);
  EXPECT_FALSE(robot.dut.drives_on());
  robot.run(100ms, wanted);
  EXPECT_EQ(robot.dut.pendant().drives(), Pendant::Drives::on);
  EXPECT_EQ(robot.dut.pendant().modality(), Pendant::Modality::listen);
  EXPECT_EQ(robot.dut.set_point_rad(), kHome) << "nothing follows before START";
  robot.run(100ms, wanted);
  EXPECT_EQ(robot.dut.pendant().modality(), Pendant::Modality::pos_absolute);
  EXPECT_TRUE(robot.dut.following());
}

TEST(ComauDevice, StandsStillWithoutPowerlinkAndComesBackByItsOperator) {
  for (const bool hardened : {false, true}) {
    Robot robot{hardened ? Robot::hardened() : Robot::faithful()};
    robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
    ASSERT_TRUE(robot.dut.set_fault("powerlink_drop", true).ok());
    const auto counter = robot.dut.frame_counter();
    const auto answers = robot.answers.size();
    const double q = robot.q[0];
    robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
    EXPECT_EQ(robot.dut.frame_counter(), counter);
    EXPECT_GT(robot.answers.size(), answers) << "the receiving thread goes on answering";
    EXPECT_FALSE(robot.dut.drives_on());
    EXPECT_EQ(robot.q[0], q);
    ASSERT_TRUE(robot.dut.set_fault("powerlink_drop", false).ok());
    robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(robot.dut.following());
  }
}

TEST(ComauDevice, DropsItsDrivesInOrderOrAtOnce) {
  for (const std::string_view fault : {"drive_off", "drive_fault"}) {
    DeviceConfig config = Robot::hardened();
    config.pendant.driving_off_s = 0.05;
    config.pendant.driving_on_s = 0.05;
    Robot robot{config};
    robot.run(200ms, follow({0.2F, 0, 0, 0, 0, 0}));
    ASSERT_TRUE(robot.dut.set_fault(fault, true).ok());
    EXPECT_FALSE(robot.dut.drives_on());
    EXPECT_EQ(robot.dut.pendant().drives(),
              fault == "drive_off" ? Pendant::Drives::driving_off : Pendant::Drives::off);
    const double q = robot.dut.set_point_rad()[0];
    robot.run(100ms, follow({0.2F, 0, 0, 0, 0, 0}));
    EXPECT_EQ(robot.dut.pendant().drives(), Pendant::Drives::off);
    EXPECT_EQ(robot.dut.set_point_rad()[0], q);
    ASSERT_TRUE(robot.dut.set_fault(fault, false).ok());
    robot.run(100ms, follow({0.2F, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(robot.dut.following());
  }
}

TEST(ComauDevice, IsHeldByTheControllerWhileTheProgramIsHeld) {
  Robot robot{Robot::hardened()};
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(robot.dut.set_fault("hold", true).ok());
  robot.run(1ms, follow({0.1F, 0, 0, 0, 0, 0}));
  const double q = robot.dut.set_point_rad()[0];
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(robot.dut.drives_on());
  EXPECT_EQ(robot.dut.pendant().modality(), Pendant::Modality::listen);
  EXPECT_EQ(robot.dut.set_point_rad()[0], q);
  ASSERT_TRUE(robot.dut.set_fault("hold", false).ok());
  robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
  EXPECT_GT(robot.dut.set_point_rad()[0], q + 0.008);
}

TEST(ComauDevice, FollowsNothingWhileItsConsoleSwitchStandsOnStop) {
  for (const bool hardened : {false, true}) {
    Robot robot{hardened ? Robot::hardened() : Robot::faithful()};
    robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
    ASSERT_TRUE(robot.dut.set_fault("local", true).ok());
    robot.run(200ms, follow({0.1F, 0, 0, 0, 0, 0}));
    const double q = robot.dut.set_point_rad()[0];
    robot.run(100ms, follow({0.1F, 0, 0, 0, 0, 0}));
    EXPECT_EQ(robot.dut.set_point_rad()[0], q);
    EXPECT_FALSE(robot.dut.following());
  }
}

TEST(ComauDevice, MovesAtTheShareThatThePendantLeavesIt) {
  for (const bool hardened : {false, true}) {
    Robot robot{hardened ? Robot::hardened() : Robot::faithful()};
    ASSERT_TRUE(robot.dut.set_fault("override", true, 50).ok());
    robot.run(1s, follow({0.1F, 0, 0, 0, 0, 0}));
    EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.05, 1e-3);
    ASSERT_TRUE(robot.dut.set_fault("override", false).ok());
    robot.run(1s, follow({0.1F, 0, 0, 0, 0, 0}));
    EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.15, 2e-3);
  }
}

TEST(ComauDevice, RefusesAFaultItDoesNotKnowAndListsThoseItKnows) {
  for (const bool hardened : {false, true}) {
    Robot robot{hardened ? Robot::hardened() : Robot::faithful()};
    const Status status = robot.dut.set_fault("explode", true);
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.fault().reason, Reason::refused);
    EXPECT_NE(status.fault().text.find(ComauDevice::fault_names()), std::string_view::npos);
    std::istringstream names{std::string{ComauDevice::fault_names()}};
    int known = 0;
    for (std::string name; names >> name; ++known) {
      EXPECT_EQ(robot.dut.set_fault(name, false).ok(), !(hardened && name == "torn")) << name;
    }
    EXPECT_EQ(known, 18);
  }
}

}  // namespace
}  // namespace motionlab::comau
