#include "gateway/controller/set_point_observer.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/controller/bench.hpp"

namespace motionlab::controller {
namespace {

using test::Joint;
using Vector3d = Eigen::Vector3d;

LabTime at_us(std::int64_t us) {
  return LabTime{Nanoseconds{us * 1000}};
}

/// A robot computer that gets a velocity every 5 ms and an observer that is told the same.
struct Bench {
  SetPointObserver dut{ServoBelief{}, 10.0, {.memory_s = 0}};  // learns nothing: the observer alone
  Joint joint;
  std::int64_t us = 0;
  bool follow = true;
  bool lose = false;  ///< the next command is told to the observer but never arrives
  double in_force = 0;
  bool in_force_follow = false;

  explicit Bench(double omega = 25.1327) : joint(0.3, omega) {}

  static double wanted(double t) { return 0.2 * std::sin(2 * t) + 0.05 * std::cos(5 * t); }

  /// 5 ms: one command, then the world at 0.1 ms, measured every 2.5 ms.
  void period() {
    const double qd = follow ? wanted(1e-6 * static_cast<double>(us)) : 0.0;
    dut.sent(at_us(us), follow, Vector3d(qd, 0, 0));
    if (!lose) {
      in_force = qd;
      in_force_follow = follow;
    }
    lose = false;
    for (int k = 1; k <= 50; ++k) {
      joint.step(in_force_follow, in_force);
      us += 100;
      if (k % 25 == 0) dut.measured(at_us(us), Vector3d(joint.q(), 0, 0), Vector3d(joint.qd(), 0, 0));
    }
  }
  void seconds(double s) {
    for (int i = 0; i < static_cast<int>(s / 0.005 + 0.5); ++i) period();
  }
  [[nodiscard]] double error() const { return dut.at(at_us(us))[0] - joint.set_point(); }
};

TEST(SetPointObserver, IsZeroBeforeTheFirstMeasurementAndTheMeasurementBeforeTheFirstCommand) {
  SetPointObserver dut{ServoBelief{}, 10.0};
  EXPECT_EQ(dut.at(at_us(1000)), Vector3d::Zero());
  dut.measured(at_us(2000), Vector3d(1, 2, 3), Vector3d::Zero());
  EXPECT_EQ(dut.at(at_us(3000)), Vector3d(1, 2, 3));
}

TEST(SetPointObserver, TracksTheIntegratorOfAnExactlyModelledServo) {
  Bench b;
  b.follow = false;
  b.seconds(0.1);
  b.follow = true;
  b.seconds(2);
  for (int i = 0; i < 2000; ++i) {
    b.period();
    ASSERT_LT(std::abs(b.error()), 1e-4) << i;
  }
}

TEST(SetPointObserver, IsTheMeasurementWhileTheRobotHolds) {
  Bench b;
  b.follow = true;
  b.seconds(1);
  b.follow = false;
  b.seconds(0.02);
  for (int i = 0; i < 50; ++i) {
    b.period();
    ASSERT_DOUBLE_EQ(b.dut.at(at_us(b.us))[0], b.joint.q());
  }
}

TEST(SetPointObserver, RecoversFromALostCommandAtTheStatedPace) {
  Bench b;
  b.follow = false;
  b.seconds(0.1);
  b.follow = true;
  // At the fastest moment ten datagrams are lost: the robot goes on with the old velocity.
  b.seconds(1.7);
  for (int i = 0; i < 10; ++i) {
    b.lose = true;
    b.period();
  }
  const double wrong = b.error();
  ASSERT_GT(std::abs(wrong), 5e-4);
  // Gain 10 /s behind the servo's own lag: about e^-3 after 0.35 s, nothing after one.
  b.seconds(0.35);
  EXPECT_LT(std::abs(b.error()), 0.12 * std::abs(wrong));
  b.seconds(0.65);
  EXPECT_LT(std::abs(b.error()), 0.02 * std::abs(wrong) + 5e-5);
}

TEST(SetPointObserver, OfASlowerServoItSaysTheSetPointThatABelievedServoWouldNeed) {
  // 10 % slower than believed: the joint lags more, and the observer puts that lag into the set point, so
  // that a controller that steers the observed set point moves the real one further ahead.
  Bench b(0.9 * 25.1327);
  b.follow = false;
  b.seconds(0.1);
  b.follow = true;
  b.seconds(3);
  double dot = 0, speed2 = 0, worst = 0;
  for (int i = 0; i < 1000; ++i) {
    b.period();
    dot += b.error() * b.joint.qd();
    speed2 += b.joint.qd() * b.joint.qd();
    worst = std::max(worst, std::abs(b.error()));
  }
  // The lag of the servos differs by 2 zeta (1/0.9 - 1)/omega = 6.2 ms; at slow motion most of it shows.
  EXPECT_LT(dot / speed2, -0.003);
  EXPECT_GT(dot / speed2, -0.0075);
  EXPECT_LT(worst, 0.0075 * 0.26);
}

TEST(SetPointObserver, AfterALongSilenceItBeginsFromTheMeasurement) {
  Bench b;
  b.seconds(1);
  b.dut.measured(at_us(b.us + 300'000), Vector3d(0.7, 0, 0), Vector3d::Zero());
  EXPECT_EQ(b.dut.at(at_us(b.us + 300'000))[0] > 0.5, true);
}

TEST(SetPointObserver, IgnoresMeasurementsThatAreOldOrNotFinite) {
  Bench b;
  b.follow = false;
  b.seconds(0.1);
  b.follow = true;
  b.seconds(1);
  const Vector3d before = b.dut.at(at_us(b.us));
  b.dut.measured(at_us(b.us - 1000), Vector3d::Constant(9), Vector3d::Zero());
  b.dut.measured(at_us(b.us), Vector3d::Constant(9), Vector3d::Zero());
  b.dut.measured(at_us(b.us + 100), Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()),
                 Vector3d::Zero());
  b.dut.measured(at_us(b.us + 200), Vector3d::Zero(),
                 Vector3d::Constant(std::numeric_limits<double>::infinity()));
  EXPECT_EQ(b.dut.at(at_us(b.us)), before);
  b.seconds(1);
  EXPECT_LT(std::abs(b.error()), 1e-4);
}

}  // namespace
}  // namespace motionlab::controller
