// Driver and robot computer together: what the one sends the other does.
#include "tests/comau/comau_bench.hpp"

#include <gtest/gtest.h>

namespace motionlab::comau {
namespace {

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
  // The lag of the servo, the rest before motion, half of the time to get up to speed.
  EXPECT_NEAR(pair.q[0], 0.2 * (1.0 - 0.056 - 0.02 - 0.5 * 0.2 / 6), 5e-3);
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

TEST(ComauPair, LeavesModeOneGentlyWhereTheFaithfulProgramWouldStep) {
  // The same exit by a peer that simply says mode 0, as the published program allows.
  const auto jolt_of = [](bool by_driver) {
    ComauPair pair{false};
    pair.run(200ms);
    pair.wanted = Joints{0.3, 0, 0, 0, 0, 0};
    pair.run(1001ms);  // between two datagrams of the driver
    pair.wanted.reset();
    pair.set_point_acceleration_max = 0.0;
    if (by_driver) {
      pair.want({}, false);
    } else {
      pair.device.on_datagram(encode(Command{}), kGateway, pair.clock.now());
    }
    pair.run(3ms);  // before the driver's next datagram comes
    if (by_driver) pair.run(2s);
    return pair.set_point_acceleration_max;
  };
  EXPECT_GT(jolt_of(false), 0.3 / kCycleSeconds * 0.99) << "all of the speed in one cycle of 0.4 ms";
  // One command's step, taken up in one cycle of the faithful program, is what 200 commands a second leave.
  EXPECT_LE(jolt_of(true), 1.0 * 0.005 / kCycleSeconds * 1.01);
}

TEST_P(ComauPairTest, SaysNothingAgainstAnArmThatFollowsASwingingCommand) {
  for (const double frequency_hz : {0.1, 0.3, 1.0}) {
    ComauPair pair{GetParam()};
    pair.run(200ms);
    for (int k = 0; k < 4000; ++k) {
      const double phase = 2 * std::numbers::pi * frequency_hz * 1e-3 * k;
      pair.wanted = Joints{0.2 * std::sin(phase), 0.1 * std::cos(phase), 0, 0.03 * std::sin(phase), 0, 0};
      pair.run(1ms);
      ASSERT_TRUE(pair.driver.health().advice().empty())
          << frequency_hz << " Hz, " << k << " ms: " << pair.driver.health().advice();
    }
  }
}

TEST_P(ComauPairTest, UnderstandsTheLongAnswer) {
  ComauPair pair{GetParam(), 0.1, true};
  pair.run(1s);
  EXPECT_EQ(pair.driver.health().rejected_total(), 0u);
  ASSERT_TRUE(pair.states.back().limits_known);
  EXPECT_NEAR(pair.states.back().q_min_rad[2], -135 * kDegree, 1e-6);
  EXPECT_TRUE(pair.driver.health().advice().empty()) << "the same limits on both ends";
}

}  // namespace
}  // namespace motionlab::comau
