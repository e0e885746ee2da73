#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "simulators/plant/arm_servo.hpp"
#include "simulators/plant/limited_servo.hpp"
#include "simulators/plant/winch_servo.hpp"

namespace motionlab::plant {
namespace {

constexpr double kTick_s = 0.0004;
constexpr double kHuge = 1e9;

/// Step response of x'' + 2 zeta w x' + w² x = w², from rest, zeta < 1.
double closed_form(double w, double zeta, double t) {
  const double root = std::sqrt(1 - zeta * zeta), wd = w * root;
  return 1 - std::exp(-zeta * w * t) * (std::cos(wd * t) + zeta / root * std::sin(wd * t));
}

TEST(LimitedServo, AnswersAStepAsTheClosedFormDoes) {
  const double w = 25.1327, zeta = 0.7;
  LimitedServo servo(w, zeta, {-kHuge, kHuge, kHuge, kHuge}, 0, kTick_s);
  for (int i = 1; i <= 2500; ++i) {
    servo.step(1.0);
    ASSERT_NEAR(servo.position(), closed_form(w, zeta, i * kTick_s), 1e-12);
  }
  EXPECT_EQ(servo.limited_ticks(), 0U);
}

TEST(LimitedServo, LagsARampByTwoZetaOverOmega) {
  LimitedServo servo(25.1327, 0.7, {-kHuge, kHuge, kHuge, kHuge}, 0, kTick_s);
  const double rate = 0.3;
  double t = 0;
  for (int i = 1; i <= 5000; ++i) {
    servo.step(rate * t);  // held through the tick: on average half a tick old
    t = i * kTick_s;
  }
  EXPECT_NEAR(rate * (t - kTick_s / 2) - servo.position(), 2 * 0.7 / 25.1327 * rate, 1e-6);
}

TEST(LimitedServo, NeverExceedsItsSpeedAccelerationAndStroke) {
  LimitedServo servo(25.0, 0.7, {-0.5, 0.5, 1.0, 5.0}, 0, kTick_s);
  double last = 0;
  for (int i = 0; i < 5000; ++i) {
    servo.step(2.0);
    EXPECT_LE(std::abs(servo.speed()), 1.0);
    EXPECT_LE(std::abs(servo.position()), 0.5);
    if (servo.position() < 0.5) {
      EXPECT_LE(std::abs(servo.speed() - last), 5.0 * kTick_s * (1 + 1e-9));
    }
    last = servo.speed();
  }
  EXPECT_EQ(servo.position(), 0.5);
  EXPECT_EQ(servo.speed(), 0.0);
  EXPECT_GT(servo.limited_ticks(), 0U);
}

TEST(ArmServo, HearsACommandSixTicksLate) {
  ArmServo arm({}, {}, kTick_s);
  Joints wanted{};
  wanted[0] = 0.01;
  for (int i = 0; i < 6; ++i) {
    arm.step(wanted);
    EXPECT_EQ(arm.q_rad()[0], 0.0);
  }
  arm.step(wanted);
  EXPECT_GT(arm.q_rad()[0], 0.0);
}

TEST(ArmServo, IgnoresSetPointsThatAreNotFinite) {
  const Joints home{0, 0, -1.57, 0, 0, 0};
  ArmServo arm({}, home, kTick_s);
  Joints bad{};
  bad[3] = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 100; ++i) arm.step(bad);
  EXPECT_EQ(arm.q_rad(), home);
}

TEST(WinchServo, AnswersASmallStepAsTheClosedFormDoes) {
  WinchServo winch({}, 2.0, kTick_s);
  const double step = 0.004;  // small enough for the acceleration limit
  for (int i = 1; i <= 2500; ++i) {
    winch.step(2.0 + step);
    ASSERT_NEAR(winch.length_m(), 2.0 + step * closed_form(25.13, 0.7, i * kTick_s), 2e-6);
  }
  EXPECT_EQ(winch.limited_ticks(), 0U);
}

TEST(WinchServo, StaysOnItsDrum) {
  WinchServo winch({}, 2.0, kTick_s);
  for (int i = 0; i < 10000; ++i) winch.step(9.0);
  EXPECT_EQ(winch.length_m(), 2.7);
  for (int i = 0; i < 10000; ++i) winch.step(0.0);
  EXPECT_EQ(winch.length_m(), 1.2);
}

TEST(WinchServo, ATurnOfTheMotorIsAFeedOfWire) {
  const WinchServo winch({}, 2.0, kTick_s);
  // Work per revolution: 2 pi T = F * feed.
  EXPECT_NEAR(2 * std::numbers::pi * winch.torque_nm(100.0), 100.0 * 0.0218304, 1e-12);
}

}  // namespace
}  // namespace motionlab::plant
