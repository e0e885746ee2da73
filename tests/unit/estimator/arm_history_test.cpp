#include "gateway/estimator/arm_history.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace motionlab::estimator {
namespace {

using Eigen::Vector3d;

LabTime at_ms(std::int64_t ms) {
  return LabTime{Nanoseconds{ms * 1'000'000}};
}

/// q = q0 + v t + a t²/2 on all joints, read every 5 ms.
ArmHistory parabola(int readings) {
  ArmHistory history;
  for (int i = 0; i < readings; ++i) {
    const double t = 0.005 * i;
    history.add(at_ms(5 * i), Vector3d::Constant(1 + 0.2 * t + 0.5 * 0.8 * t * t),
                Vector3d(0.2 + 0.8 * t, -0.8 * t, 0.3));
  }
  return history;
}

TEST(ArmHistory, IsEmptyUntilTheFirstReading) {
  ArmHistory dut;
  EXPECT_TRUE(dut.empty());
  dut.add(at_ms(0), Vector3d::Zero(), Vector3d::Zero());
  EXPECT_FALSE(dut.empty());
}

TEST(ArmHistory, OneReadingIsHeldBeforeItAndFollowedAfterIt) {
  ArmHistory dut;
  dut.add(at_ms(100), Vector3d(1, 2, 3), Vector3d(1, -1, 0));
  EXPECT_EQ(dut.at(at_ms(50)).q, Vector3d(1, 2, 3));
  EXPECT_EQ(dut.at(at_ms(100)).q, Vector3d(1, 2, 3));
  EXPECT_LT((dut.at(at_ms(110)).q - Vector3d(1.01, 1.99, 3)).norm(), 1e-15);
  EXPECT_EQ(dut.at(at_ms(110)).qd, Vector3d(1, -1, 0));
  EXPECT_EQ(dut.at(at_ms(110)).qdd, Vector3d::Zero());
}

TEST(ArmHistory, InterpolatesBetweenReadings) {
  const ArmHistory dut = parabola(10);
  const JointMotion motion = dut.at(at_ms(22));
  const double t = 0.022;
  EXPECT_NEAR(motion.q[0], 1 + 0.2 * t + 0.4 * t * t, 0.8 * 0.005 * 0.005 / 8 + 1e-12);
  EXPECT_NEAR(motion.qd[0], 0.2 + 0.8 * t, 1e-12);
  EXPECT_NEAR(motion.qd[1], -0.8 * t, 1e-12);
  EXPECT_NEAR(dut.at(at_ms(20)).q[0], 1 + 0.2 * 0.02 + 0.4 * 0.02 * 0.02, 1e-15);
}

TEST(ArmHistory, AccelerationIsTheSlopeOfTheVelocities) {
  const ArmHistory dut = parabola(10);
  for (const int ms : {0, 3, 22, 45, 60}) {
    const Vector3d qdd = dut.at(at_ms(ms)).qdd;
    EXPECT_LT((qdd - Vector3d(0.8, -0.8, 0)).norm(), 1e-10) << ms;
  }
}

TEST(ArmHistory, ExtrapolatesForFiftyMillisecondsAndNoFurther) {
  ArmHistory dut;
  dut.add(at_ms(0), Vector3d::Zero(), Vector3d::Ones());
  dut.add(at_ms(5), Vector3d::Constant(0.005), Vector3d::Ones());
  EXPECT_NEAR(dut.at(at_ms(35)).q[0], 0.035, 1e-12);
  EXPECT_NEAR(dut.at(at_ms(55)).q[0], 0.055, 1e-12);
  EXPECT_NEAR(dut.at(at_ms(10000)).q[0], 0.055, 1e-12);
}

TEST(ArmHistory, GivesTheOldestReadingForTimesBeforeIt) {
  const ArmHistory dut = parabola(200);  // more than it keeps
  const JointMotion oldest = dut.at(at_ms(0));
  EXPECT_NEAR(oldest.q[0], dut.at(at_ms(5 * (200 - 64))).q[0], 1e-15);
  EXPECT_EQ(oldest.q, dut.at(at_ms(100)).q);
}

TEST(ArmHistory, IgnoresReadingsThatAreNotNewer) {
  ArmHistory dut = parabola(10);
  const JointMotion before = dut.at(at_ms(33));
  dut.add(at_ms(45), Vector3d::Constant(99), Vector3d::Constant(99));
  dut.add(at_ms(20), Vector3d::Constant(99), Vector3d::Constant(99));
  const JointMotion after = dut.at(at_ms(33));
  EXPECT_EQ(before.q, after.q);
  EXPECT_EQ(before.qd, after.qd);
  EXPECT_EQ(before.qdd, after.qdd);
  EXPECT_LT(dut.at(at_ms(60)).q[0], 2);
}

}  // namespace
}  // namespace motionlab::estimator
