#include "simulators/comau/comau_device.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
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
  Robot robot{Robot::hardened()};
  robot.run(1s, follow({0.1F, -0.05F, 0.2F, 0.01F, 0, 0}));
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.1, 1e-3);
  EXPECT_NEAR(robot.dut.set_point_rad()[1], -0.05, 1e-3);
  EXPECT_NEAR(robot.dut.set_point_rad()[2], kHome[2] + 0.2, 1e-3);
  EXPECT_NEAR(robot.dut.set_point_rad()[3], 0.01, 1e-3);
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
    EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.1, 1e-3);
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

// The defects of the published program.

TEST(ComauDeviceFaithful, GoesOnMovingWhenCommandsStop) {
  Robot robot{Robot::faithful()};
  robot.command(1, {0.2F, 0, 0, 0, 0, 0});
  robot.run(10s);
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 45 * kDegree, 1e-4);
}

TEST(ComauDeviceFaithful, ExecutesAShortDatagramTogetherWithTheRestOfTheOneBefore) {
  Robot robot{Robot::faithful()};
  robot.command(0, {0.2F, 0, 0, 0, 0, 0});
  robot.run(1ms);
  const auto whole = encode(follow({}));
  robot.dut.on_datagram(Bytes{whole}.first(8), kGateway, robot.now);  // key and mode 1, no velocities
  robot.run(100ms);
  EXPECT_EQ(robot.answers.size(), 2u) << "it is even answered";
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.02, 1e-3);
}

TEST(ComauDeviceFaithful, ReadsTheBeginningOfALongDatagram) {
  Robot robot{Robot::faithful()};
  ByteBuffer bytes(200, 0xFF);
  const auto whole = encode(follow({0.2F, 0, 0, 0, 0, 0}));
  std::copy(whole.begin(), whole.end(), bytes.begin());
  robot.dut.on_datagram(bytes, kGateway, robot.now);
  robot.run(100ms);
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.02, 1e-3);
}

TEST(ComauDeviceFaithful, TakesNaNForFullSpeedTowardsTheLowerEdge) {
  Robot robot{Robot::faithful()};
  robot.command(1, {kNaN, 0, 0, kNaN, 0, 0});
  robot.run(100ms);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[0], -30 * kDegree, 1e-9);
  EXPECT_NEAR(robot.dut.set_point_velocity_radps()[3], -3 * kDegree, 1e-9);
  EXPECT_EQ(robot.dut.set_point_rad()[1], 0.0);
}

TEST(ComauDeviceFaithful, EndsWhenRemoteIsSelectedBeforeTheFirstDatagram) {
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

TEST(ComauDeviceFaithful, DropsItsSpeedInOneCycleWhenModeOneEnds) {
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

TEST(ComauDeviceFaithful, CreepsInHoldWhenTheArmDoes) {
  Robot robot{Robot::faithful()};
  robot.command(0, {});
  robot.run(1ms);
  robot.q[1] = 0.01;
  robot.run(1ms);
  EXPECT_EQ(robot.dut.set_point_rad()[1], 0.01);
}

TEST(ComauDeviceFaithful, ObeysAnyHost) {
  Robot robot{Robot::faithful()};
  robot.command(1, {0.2F, 0, 0, 0, 0, 0}, kStranger);
  robot.run(100ms);
  EXPECT_NEAR(robot.dut.set_point_rad()[0], 0.02, 1e-3);
}

// The cures.

TEST(ComauDeviceHardened, RampsToRestWhenCommandsStopAndHoldsThere) {
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

TEST(ComauDeviceHardened, RampsToRestWhenModeOneEnds) {
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

TEST(ComauDeviceHardened, DoesNotEndWhenRemoteIsSelectedBeforeTheFirstDatagram) {
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

TEST(ComauDevice, AnswersLate) {
  Robot robot{Robot::faithful()};
  ASSERT_TRUE(robot.dut.set_fault("late", true, 0.01).ok());
  robot.command(0, {});
  robot.run(9ms);
  EXPECT_TRUE(robot.answers.empty());
  robot.run(2ms);
  EXPECT_EQ(robot.answers.size(), 1u);
}

TEST(ComauDevice, LosesTheShareItWasTold) {
  Robot robot{Robot::faithful()};
  ASSERT_TRUE(robot.dut.set_fault("loss", true, 0.3).ok());
  for (int k = 0; k < 10000; ++k) robot.command(0, {});
  EXPECT_NEAR(static_cast<double>(robot.answers.size()), 7000.0, 200.0);
}

TEST(ComauDevice, AnswersWithAWrongSize) {
  Robot robot{Robot::faithful()};
  const std::vector<std::pair<double, std::size_t>> sizes{{0, 51}, {72, 116}, {-52, 0}, {-999, 0}, {1, 53}};
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

TEST(ComauDevice, DropsItsDrives) {
  Robot robot{Robot::hardened()};
  robot.run(100ms, follow({0.2F, 0, 0, 0, 0, 0}));
  ASSERT_TRUE(robot.dut.set_fault("drive_off", true).ok());
  const double q = robot.dut.set_point_rad()[0];
  robot.run(100ms, follow({0.2F, 0, 0, 0, 0, 0}));
  EXPECT_FALSE(robot.dut.drives_on());
  EXPECT_EQ(robot.dut.set_point_rad()[0], q);
}

TEST(ComauDevice, RefusesAFaultItDoesNotKnowAndListsThoseItKnows) {
  Robot robot{Robot::faithful()};
  const Status status = robot.dut.set_fault("explode", true);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.fault().reason, Reason::refused);
  for (const char* name :
       {"silent", "freeze_counter", "late", "loss", "wrong_size", "nan_answer", "drive_off"}) {
    EXPECT_NE(status.fault().text.find(name), std::string_view::npos) << name;
    EXPECT_TRUE(robot.dut.set_fault(name, false).ok()) << name;
  }
}

}  // namespace
}  // namespace motionlab::comau
