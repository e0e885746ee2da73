#include "gateway/controller/guard.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "drivers/core/random.hpp"
#include "tests/unit/controller/bench.hpp"

namespace motionlab::controller {
namespace {

using test::Joint;
using test::kDegree;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

GuardLimits lab_limits() {
  GuardLimits limits;
  const double low[] = {-45, -30, -135, -10, -10, -10}, high[] = {45, 30, -45, 10, 10, 10};
  const double fast[] = {30, 30, 30, 3, 3, 3};
  for (std::size_t i = 0; i < 6; ++i) {
    limits.q_min_rad[i] = low[i] * kDegree;
    limits.q_max_rad[i] = high[i] * kDegree;
    limits.qd_max_radps[i] = fast[i] * kDegree;
    limits.qdd_max_radps2[i] = i < 3 ? 3.0 : 0.5;
  }
  limits.wire_min_m = 1.3;
  limits.wire_max_m = 2.7;
  return limits;
}

/// The guard every millisecond; its command reaches six joints and a winch every 5 ms; their posture is
/// known as it was 5 ms ago.
struct Bench {
  GuardLimits limits = lab_limits();
  Guard dut{limits};
  std::vector<Joint> joints;
  Joint winch{2.0};
  Guard::Inputs in;
  GuardedCommand out, in_force;
  int ms = 0;
  std::deque<std::array<double, 7>> measured;
  bool posture_known = true;
  double worst_outside_rad = -1, worst_outside_m = -1;  ///< of joints and wire
  double worst_set_point = -1;                          ///< of any set point, beyond its limit

  Bench() {
    for (std::size_t i = 0; i < 6; ++i) {
      joints.emplace_back(0.5 * (limits.q_min_rad[i] + limits.q_max_rad[i]));
    }
    in.dt_s = 1e-3;
    in.may_move = true;
    in.wish = Wish{};
  }

  void wish_all(double qd, double wire) {
    in.wish = Wish{};
    in.wish->qd_radps.fill(qd);
    in.wish->wire_speed_mps = wire;
  }

  void step() {
    std::array<double, 7> now;
    for (std::size_t i = 0; i < 6; ++i) now[i] = joints[i].q();
    now[6] = winch.q();
    measured.push_back(now);
    if (measured.size() > 6) measured.pop_front();
    if (posture_known) {
      in.q_rad.emplace();
      std::copy_n(measured.front().begin(), 6, in.q_rad->begin());
      in.wire_length_m = measured.front()[6];
    }
    const GuardedCommand before = out;
    out = dut.step(in);
    check(before);
    if (ms++ % 5 == 0) in_force = out;
    for (int k = 0; k < 10; ++k) {
      for (std::size_t i = 0; i < 6; ++i) joints[i].step(in_force.follow, in_force.qd_radps[i]);
      winch.step(true, in_force.wire_speed_mps);
    }
    const auto outside = [](double x, double low, double high) { return std::max(low - x, x - high); };
    for (std::size_t i = 0; i < 6; ++i) {
      const double low = limits.q_min_rad[i], high = limits.q_max_rad[i];
      worst_outside_rad = std::max(worst_outside_rad, outside(joints[i].q(), low, high));
      worst_set_point = std::max(worst_set_point, outside(joints[i].set_point(), low, high));
    }
    worst_outside_m = std::max(worst_outside_m, outside(winch.q(), limits.wire_min_m, limits.wire_max_m));
    worst_set_point =
        std::max(worst_set_point, outside(winch.set_point(), limits.wire_min_m, limits.wire_max_m));
  }

  /// The box holds to a milliradian and a millimetre: what is under way is believed with a first-order lag,
  /// and a servo with zeta 0.7 swings past the end of a ramp by 0.35 mrad per rad/s², which nobody can
  /// command away.
  void expect_inside() const {
    EXPECT_LE(worst_set_point, 1.0e-3);
    EXPECT_LE(worst_outside_rad, 1.2e-3);
    EXPECT_LE(worst_outside_m, 1.0e-3);
  }

  /// What holds in every step, whatever is asked.
  void check(const GuardedCommand& before) {
    const double credit = std::isnan(in.dt_s) ? 0.0 : std::clamp(in.dt_s, 0.0, 0.005);
    for (std::size_t i = 0; i < 6; ++i) {
      const double v = out.qd_radps[i], v0 = before.qd_radps[i];
      ASSERT_TRUE(std::isfinite(v));
      ASSERT_LE(std::abs(v), limits.qd_max_radps[i] + 1e-12);
      const double towards = std::max(limits.qdd_max_radps2[i], limits.stop_deceleration_radps2);
      const bool away = std::abs(v) > std::abs(v0) || v * v0 < 0;
      ASSERT_LE(std::abs(v - v0), (away ? limits.qdd_max_radps2[i] : towards) * credit + 1e-12) << i;
    }
    ASSERT_TRUE(std::isfinite(out.wire_speed_mps));
    ASSERT_LE(std::abs(out.wire_speed_mps), limits.wire_speed_max_mps + 1e-12);
    ASSERT_LE(std::abs(out.wire_speed_mps - before.wire_speed_mps),
              limits.wire_acceleration_max_mps2 * credit + 1e-12);
    // The robot is let go of only at rest.
    if (before.follow && !out.follow) {
      for (const double v : out.qd_radps) ASSERT_EQ(v, 0);
    }
  }

  /// Permission is withdrawn: rest within speed / deceleration.
  void expect_rest() {
    in.may_move = false;
    const double longest = 1e3 * (30 * kDegree / 1.0);
    int steps = 0;
    do {
      step();
      ++steps;
    } while (!dut.at_rest() && steps < 2000);
    EXPECT_LE(steps, longest + 2);
    EXPECT_FALSE(out.follow);
    for (int i = 0; i < 300; ++i) {
      step();
      ASSERT_TRUE(dut.at_rest());
    }
  }
};

TEST(Guard, PassesAWishWithinTheLimitsUnchanged) {
  Bench b;
  b.wish_all(0.0004, 0.0004);
  b.step();
  EXPECT_TRUE(b.out.follow);
  for (const double v : b.out.qd_radps) EXPECT_EQ(v, 0.0004);
  EXPECT_EQ(b.out.wire_speed_mps, 0.0004);
  EXPECT_EQ(b.out.changed, 0u);
  EXPECT_EQ(b.dut.changed_count(), 0u);
}

TEST(Guard, EveryBitSaysWhichLimitActed) {
  {
    Bench b;
    b.wish_all(9, 0);
    b.in.wish->qd_radps = {9, 0, 0, 0, 0, 0};
    b.step();
    EXPECT_EQ(b.out.changed, kGuardPosition | kGuardVelocity | kGuardAcceleration);
  }
  {
    Bench b;
    b.in.wish->qd_radps = {0, 0, 0.6, 0, 0, 0};
    b.step();
    EXPECT_EQ(b.out.changed, (kGuardVelocity | kGuardAcceleration) << 2);
  }
  {
    Bench b;
    b.in.wish->qd_radps = {0, 0, 0, 0, -0.01, 0};
    b.step();
    EXPECT_EQ(b.out.changed, kGuardAcceleration << 4);
  }
  {
    Bench b;
    b.in.wish->wire_speed_mps = 1;
    b.step();
    EXPECT_EQ(b.out.changed, kGuardWinch);
    EXPECT_EQ(b.dut.changed_count(), 1u);
  }
  {
    Bench b;
    b.in.wish->qd_radps[3] = kNan;
    b.step();
    EXPECT_EQ(b.out.changed, kGuardNotFinite);
    b.in.wish.reset();
    b.step();
    EXPECT_EQ(b.out.changed, kGuardNotFinite);
    EXPECT_EQ(b.dut.changed_count(), 2u);
  }
}

TEST(Guard, IsAtRestBeforeAnythingWasAsked) {
  EXPECT_TRUE(Guard{lab_limits()}.at_rest());
  Bench b;
  b.in.may_move = false;
  b.wish_all(1, 1);
  b.step();
  EXPECT_TRUE(b.dut.at_rest());
  EXPECT_FALSE(b.out.follow);
  EXPECT_EQ(b.out.changed, 0u);
}

TEST(Guard, AtRestWaitsForTheWinchToo) {
  Bench b;
  b.in.wish->wire_speed_mps = 0.2;
  for (int i = 0; i < 1000; ++i) b.step();
  b.in.may_move = false;
  b.step();
  EXPECT_FALSE(b.out.follow) << "the robot stood still and is let go of";
  EXPECT_FALSE(b.dut.at_rest());
  for (int i = 0; i < 405; ++i) b.step();
  EXPECT_TRUE(b.dut.at_rest());
}

TEST(Guard, FullSpeedIntoEveryLimitStaysInTheBox) {
  for (const double sign : {1.0, -1.0}) {
    Bench b;
    b.wish_all(10 * sign, 10 * sign);
    for (int i = 0; i < 30000; ++i) b.step();
    b.expect_inside();
    // And it does get there.
    for (std::size_t i = 0; i < 6; ++i) {
      const double edge = sign > 0 ? b.limits.q_max_rad[i] : b.limits.q_min_rad[i];
      EXPECT_NEAR(b.joints[i].q(), edge, 0.01) << i;
    }
    EXPECT_NEAR(b.winch.q(), sign > 0 ? 2.7 : 1.3, 0.01);
    b.expect_rest();
  }
}

TEST(Guard, NoSequenceOfWishesLeavesTheBoxOrTheLimits) {
  Random random(3);
  for (int run = 0; run < 30; ++run) {
    Bench b;
    for (int i = 0; i < 8000; ++i) {
      if (random.chance(0.01)) {
        for (double& qd : b.in.wish->qd_radps) qd = random.uniform(-2, 2);
        b.in.wish->wire_speed_mps = random.uniform(-1, 1);
      }
      if (random.chance(0.003)) b.wish_all(random.chance(0.5) ? 1e300 : -1e300, random.uniform(-1e9, 1e9));
      if (!b.in.wish) b.in.wish = Wish{};
      const Guard::Inputs kept = b.in;
      // Bad luck, one step long.
      if (random.chance(0.02)) b.in.wish->qd_radps[random.below(6)] = random.chance(0.5) ? kNan : kInfinity;
      if (random.chance(0.01)) b.in.wish->wire_speed_mps = -kInfinity;
      if (random.chance(0.01)) b.in.wish.reset();
      if (random.chance(0.01)) b.in.may_move = false;
      if (random.chance(0.02)) {
        const double odd[] = {0, -1, 1e9, kNan, kInfinity, -kInfinity, 1e-12};
        b.in.dt_s = odd[random.below(7)];
      }
      b.posture_known = !random.chance(0.01);
      if (!b.posture_known) b.in.q_rad.reset();
      b.step();
      if (testing::Test::HasFatalFailure()) return;
      b.in = kept;
    }
    SCOPED_TRACE(run);
    b.expect_inside();
    b.expect_rest();
  }
}

TEST(Guard, AWishThatAlwaysTurnsAtTheWorstMomentStaysInTheBox) {
  // Towards the limit whenever the guard lets it, with pauses that try to cheat the stopping distance.
  Random random(4);
  for (int run = 0; run < 20; ++run) {
    Bench b;
    const int pause = 5 + static_cast<int>(random.below(200));
    const double sign = random.chance(0.5) ? 1 : -1;
    for (int i = 0; i < 15000; ++i) {
      b.wish_all(i / pause % 2 == 0 ? 5 * sign : -0.05 * sign, i / pause % 2 == 0 ? sign : 0);
      b.step();
    }
    SCOPED_TRACE(pause);
    b.expect_inside();
  }
}

TEST(Guard, AnUnknownPostureBringsItToRestButKeepsTheRobot) {
  Bench b;
  b.wish_all(0.3, 0.1);
  for (int i = 0; i < 500; ++i) b.step();
  EXPECT_FALSE(b.dut.at_rest());
  b.posture_known = false;
  b.in.q_rad.reset();
  for (int i = 0; i < 320; ++i) b.step();
  EXPECT_TRUE(b.dut.at_rest());
  EXPECT_TRUE(b.out.follow);
  EXPECT_EQ(b.out.changed, kGuardNotFinite);
  b.in.wire_length_m = kNan;
  b.in.q_rad.emplace();
  b.step();
  EXPECT_TRUE(b.dut.at_rest());
}

TEST(Guard, APostureOutsideOfTheBoxMayOnlyComeBack) {
  Bench b;
  b.joints[0] = Joint(50 * kDegree);
  b.wish_all(0.5, 0);
  for (int i = 0; i < 200; ++i) {
    b.step();
    ASSERT_EQ(b.out.qd_radps[0], 0);
  }
  b.wish_all(-0.5, 0);
  for (int i = 0; i < 1000; ++i) b.step();
  EXPECT_LT(b.joints[0].q(), 45 * kDegree);
}

TEST(Guard, AWithdrawnPermissionBrakesEveryJointAtTheStopDeceleration) {
  Bench b;
  b.wish_all(1, 0.2);
  for (int i = 0; i < 400; ++i) b.step();
  const auto speed = b.out.qd_radps;
  EXPECT_GT(speed[0], 0.5);
  b.in.may_move = false;
  for (int i = 1; i < 200; ++i) {
    b.step();
    for (std::size_t k = 0; k < 6; ++k) {
      ASSERT_NEAR(b.out.qd_radps[k], std::max(0.0, speed[k] - 1e-3 * i * 1.0), 1e-9);
    }
    ASSERT_TRUE(b.out.follow);
  }
  b.expect_rest();
}

TEST(Guard, ATenthOfTheAuthorityIsATenthOfSpeedAndAcceleration) {
  Bench b;
  b.in.authority = 0.1;
  b.wish_all(5, 5);
  std::array<double, 6> before{};
  for (int i = 0; i < 3000; ++i) {
    b.step();
    for (std::size_t k = 0; k < 6; ++k) {
      ASSERT_LE(b.out.qd_radps[k], 0.1 * b.limits.qd_max_radps[k] + 1e-12);
      ASSERT_LE(b.out.qd_radps[k] - before[k], 0.1 * b.limits.qdd_max_radps2[k] * 1e-3 + 1e-12);
    }
    ASSERT_LE(b.out.wire_speed_mps, 0.02 + 1e-12);
    before = b.out.qd_radps;
  }
  EXPECT_NEAR(b.out.qd_radps[0], 3 * kDegree, 1e-9);
}

TEST(Guard, AnAuthorityThatIsNotANumberIsNone) {
  for (const double authority : {0.0, -1.0, kNan, kInfinity}) {
    Bench b;
    b.in.authority = authority;
    b.wish_all(5, 5);
    for (int i = 0; i < 100; ++i) b.step();
    EXPECT_TRUE(b.dut.at_rest()) << authority;
  }
}

TEST(Guard, ALateStepBuysNoJump) {
  Bench b;
  b.wish_all(1, 1);
  b.in.dt_s = 3600;
  b.step();
  EXPECT_NEAR(b.out.qd_radps[0], 3.0 * 0.005, 1e-12);
  for (const double dt : {0.0, -5.0, kNan}) {
    b.in.dt_s = dt;
    const auto before = b.out.qd_radps;
    b.step();
    EXPECT_EQ(b.out.qd_radps, before) << dt;
  }
}

}  // namespace
}  // namespace motionlab::controller
