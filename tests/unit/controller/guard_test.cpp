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
  LeaseDesk desk;
  std::optional<Lease> lease = desk.grant("anna", false, LabTime{});
  std::vector<Joint> joints;
  Joint winch{2.0};
  Guard::Inputs in;
  GuardedCommand out, in_force;
  int ms = 0;
  std::deque<std::array<double, 7>> measured;
  bool posture_known = true;
  bool commanding = true;                               ///< the owner goes on giving commands
  double worst_outside_rad = -1, worst_outside_m = -1;  ///< of joints and wire
  double worst_set_point = -1;                          ///< of any set point, beyond its limit

  /// @param jerk  limit of what is wished
  explicit Bench(double jerk_radps3 = 2000) {
    limits.jerk_max_radps3 = jerk_radps3;
    dut = Guard(limits);
    for (std::size_t i = 0; i < 6; ++i) {
      joints.emplace_back(0.5 * (limits.q_min_rad[i] + limits.q_max_rad[i]));
    }
    in.dt_s = 1e-3;
    in.may_move = true;
    in.lease = &*lease;
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
    in.t = LabTime{Nanoseconds{1'000'000LL * ms}};
    if (commanding) lease->renew(in.t);
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
    Bench b(1e9);
    b.wish_all(9, 0);
    b.in.wish->qd_radps = {9, 0, 0, 0, 0, 0};
    b.step();
    EXPECT_EQ(b.out.changed, kGuardPosition | kGuardVelocity | kGuardAcceleration);
  }
  {
    Bench b(1e9);
    b.in.wish->qd_radps = {0, 0, 0.6, 0, 0, 0};
    b.step();
    EXPECT_EQ(b.out.changed, (kGuardVelocity | kGuardAcceleration) << 2);
  }
  {
    Bench b(1e9);
    b.in.wish->qd_radps = {0, 0, 0, 0, -0.01, 0};
    b.step();
    EXPECT_EQ(b.out.changed, kGuardAcceleration << 4);
  }
  {
    Bench b(1e9);
    b.in.wish->wire_speed_mps = 1;
    b.step();
    EXPECT_EQ(b.out.changed, kGuardWinch);
    EXPECT_EQ(b.dut.changed_count(), 1u);
  }
  {
    Bench b(1e9);
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

TEST(Guard, ForgetsACommandThatOthersHaveBrakedAndKeepsItsCount) {
  Bench b;
  b.wish_all(1, 0.2);
  for (int i = 0; i < 400; ++i) b.step();
  const auto count = b.dut.changed_count();
  ASSERT_GT(count, 0u);
  b.dut.forget_command();
  EXPECT_TRUE(b.dut.at_rest());
  EXPECT_EQ(b.dut.changed_count(), count);
  b.in.may_move = false;
  const GuardedCommand next = b.dut.step(b.in);
  EXPECT_FALSE(next.follow) << "nothing is taken up again to be braked";
  EXPECT_EQ(next.qd_radps, (std::array<double, 6>{}));
  EXPECT_EQ(next.wire_speed_mps, 0.0);
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

TEST(Guard, NothingMovesWithoutALeaseOrAfterItHasExpired) {
  Bench b;
  b.in.lease = nullptr;
  b.wish_all(0.3, 0.1);
  for (int i = 0; i < 100; ++i) b.step();
  EXPECT_TRUE(b.dut.at_rest());
  EXPECT_FALSE(b.out.follow);

  Bench c;
  c.wish_all(0.3, 0.1);
  for (int i = 0; i < 300; ++i) c.step();
  EXPECT_FALSE(c.dut.at_rest());
  c.commanding = false;
  for (int i = 0; i < 98; ++i) c.step();
  const auto before = c.out.qd_radps;
  EXPECT_GT(before[0], 0.2);
  c.expect_rest();
  c.in.may_move = true;
  c.commanding = true;
  for (int i = 0; i < 100; ++i) c.step();
  EXPECT_TRUE(c.dut.at_rest()) << "what has expired is not renewed";
}

TEST(Guard, AnOldPostureIsNone) {
  for (const bool wire : {false, true}) {
    Bench b;
    b.wish_all(0.3, 0.1);
    for (int i = 0; i < 300; ++i) b.step();
    (wire ? b.in.wire_age_s : b.in.q_age_s) = b.limits.posture_age_max_s + 0.001;
    b.step();
    EXPECT_EQ(b.out.changed, kGuardNotFresh);
    for (int i = 0; i < 400; ++i) b.step();
    EXPECT_TRUE(b.dut.at_rest());
    (wire ? b.in.wire_age_s : b.in.q_age_s) = kNan;
    b.step();
    EXPECT_EQ(b.out.changed, kGuardNotFresh);
  }
}

TEST(Guard, AWishMayNotJerk) {
  Bench b(100);
  b.in.wish->qd_radps[0] = 0.2;
  double before = 0, slope_before = 0;
  for (int i = 0; i < 150; ++i) {
    b.step();
    const double slope = (b.out.qd_radps[0] - before) / 1e-3;
    // Until the limit itself, at which the acceleration ends at once, it changes by no more than the jerk.
    if (b.out.qd_radps[0] < 0.2) {
      ASSERT_LE(std::abs(slope - slope_before), 0.1 + 1e-9) << i;
    }
    before = b.out.qd_radps[0];
    slope_before = slope;
  }
  EXPECT_TRUE(b.dut.changed_count() > 0);
  b.expect_rest();
}

TEST(Guard, NothingIsPaidOutOnASlackWireNorHauledInOnOneThatIsHeld) {
  Bench b;
  b.limits.motor_torque_min_nm = 0.1;
  b.limits.motor_torque_max_nm = 2.5;
  b.dut = Guard(b.limits);
  const auto speed_after = [&b](double torque, double wish) {
    b.in.motor_torque_nm = torque;
    b.wish_all(0, wish);
    for (int i = 0; i < 500; ++i) b.step();
    return b.out.wire_speed_mps;
  };
  EXPECT_GT(speed_after(1.0, 0.1), 0.05);
  EXPECT_EQ(speed_after(0.05, 0.1), 0.0);
  EXPECT_TRUE(b.out.changed & kGuardTension);
  EXPECT_LT(speed_after(0.05, -0.1), -0.05) << "a slack wire may be hauled in";
  EXPECT_EQ(speed_after(3.0, -0.1), 0.0);
  EXPECT_GT(speed_after(3.0, 0.1), 0.05);
}

// ---------------------------------------------------------------- fences

FenceLimits lab_fences() {
  return {.arm = {0.350, 1.160, 0.250, 0.830, 2.2692},
          .p_base_tool_min_m = {1.0, -1.0, 0.3},
          .p_base_tool_max_m = {3.2, 1.0, 2.5},
          .load_height_min_m = 0.5,
          .p_world_second_m = {9, 9, 9},
          .distance_to_second_min_m = 1.0};
}

/// How far tool and load are within all fences.
double inside(const FenceLimits& limits, const Bench& b, const math::RigidTransform& X_WR) {
  const Eigen::Vector3d q(b.joints[0].q(), b.joints[1].q(), b.joints[2].q());
  double least = 1e9;
  for (const Fence& fence : fences(limits, q, b.winch.q(), X_WR)) least = std::min(least, fence.distance_m);
  return least;
}

TEST(Fences, TheSlopeIsTheDerivativeOfTheDistance) {
  const FenceLimits limits = lab_fences();
  const math::RigidTransform X_WR{math::from_euler({0.1, -0.2, 0.7}, math::EulerOrder::zyx), {0.3, 0.2, 1.5}};
  const Eigen::Vector3d q(0.2, -0.1, -1.4);
  constexpr double kStep = 1e-6;
  const auto at = [&](Eigen::Index i, double by) {
    Eigen::Vector3d moved = q;
    if (i < 3) moved[i] += by;
    return fences(limits, moved, i == 6 ? 2.0 + by : 2.0, X_WR);
  };
  const auto here = fences(limits, q, 2.0, X_WR);
  for (const Eigen::Index i : {0, 1, 2, 6}) {
    const auto more = at(i, kStep), less = at(i, -kStep);
    for (std::size_t k = 0; k < kFences; ++k) {
      EXPECT_NEAR(here[k].slope[i], (more[k].distance_m - less[k].distance_m) / (2 * kStep), 1e-7) << k << i;
    }
  }
}

TEST(Fences, AStopFromTheShareThatFitsEndsAtTheFence) {
  Fence fence;
  fence.distance_m = 0.2;
  fence.slope[1] = -2.0;
  Eigen::Matrix<double, 7, 1> speeds = Eigen::Matrix<double, 7, 1>::Zero();
  const Eigen::Matrix<double, 7, 1> decelerations = Eigen::Matrix<double, 7, 1>::Constant(1.5);
  speeds[1] = 1.0;
  const double share = share_that_fits(fence, speeds, decelerations);
  const double v = share * 1.0;
  EXPECT_NEAR(2.0 * v * v / (2 * 1.5), 0.2, 1e-12);
  speeds[1] = -1.0;
  EXPECT_EQ(share_that_fits(fence, speeds, decelerations), 1.0) << "away from it everything fits";
  fence.distance_m = -0.1;
  EXPECT_EQ(share_that_fits(fence, speeds, decelerations), 1.0);
  speeds[1] = 1.0;
  EXPECT_EQ(share_that_fits(fence, speeds, decelerations), 0.0);
}

TEST(Fences, NoSequenceOfWishesPassesThem) {
  Random random(5);
  const math::RigidTransform X_WR{math::Matrix3d::Identity(), {0, 0, 1.2}};
  double nearest = 1e9;
  std::uint32_t acted = 0;
  for (int run = 0; run < 30; ++run) {
    Bench b;
    b.limits.fences = lab_fences();
    // In front of the tool's home, so that both the tool and the load can run into it.
    b.limits.fences->p_world_second_m = {2.3, 1.6, 1.3};
    b.dut = Guard(b.limits);
    b.joints[2] = Joint(-90 * kDegree);
    b.in.X_WR = X_WR;
    ASSERT_GT(inside(*b.limits.fences, b, X_WR), 0);
    for (int i = 0; i < 8000; ++i) {
      if (random.chance(0.005)) {
        for (double& qd : b.in.wish->qd_radps) qd = random.uniform(-2, 2);
        b.in.wish->wire_speed_mps = random.uniform(-1, 1);
      }
      if (random.chance(0.002)) b.wish_all(random.chance(0.5) ? 5 : -5, random.chance(0.5) ? 1 : -1);
      b.step();
      if (testing::Test::HasFatalFailure()) return;
      acted |= b.out.changed;
      nearest = std::min(nearest, inside(*b.limits.fences, b, X_WR));
    }
    b.expect_rest();
    nearest = std::min(nearest, inside(*b.limits.fences, b, X_WR));
  }
  EXPECT_GE(nearest, -0.01) << "servos swing past the end of a ramp, and the slope bends on the way";
  EXPECT_LE(nearest, 0.02) << "and they are reached";
  EXPECT_TRUE(acted & kGuardWorkspace);
  EXPECT_TRUE(acted & kGuardFloor);
  EXPECT_TRUE(acted & kGuardSecondPlatform);
}

TEST(Fences, WithoutTheShipsPoseNothingMoves) {
  Bench b;
  b.limits.fences = lab_fences();
  b.dut = Guard(b.limits);
  b.wish_all(0.1, 0.1);
  b.step();
  EXPECT_EQ(b.out.changed, kGuardNotFinite);
  b.in.X_WR = math::RigidTransform{};
  b.in.X_WR->p.x() = kNan;
  b.step();
  EXPECT_EQ(b.out.changed, kGuardNotFinite);
  EXPECT_TRUE(b.dut.at_rest());
}

TEST(Fences, BeyondThemOnlyTheWayBackIsOpen) {
  Bench b;
  b.limits.fences = lab_fences();
  b.limits.fences->p_base_tool_max_m.x() = 2.0;  // the tool is beyond
  b.dut = Guard(b.limits);
  b.joints[2] = Joint(-90 * kDegree);
  b.in.X_WR = math::RigidTransform{math::Matrix3d::Identity(), {0, 0, 1.2}};
  const double before = inside(*b.limits.fences, b, *b.in.X_WR);
  ASSERT_LT(before, 0);
  b.in.wish->qd_radps = {0, 0.3, 0, 0, 0, 0};  // leans forward
  for (int i = 0; i < 300; ++i) b.step();
  EXPECT_EQ(b.out.qd_radps[1], 0);
  EXPECT_TRUE(b.out.changed & kGuardWorkspace);
  b.in.wish->qd_radps = {0, -0.3, 0, 0, 0, 0};
  for (int i = 0; i < 600; ++i) b.step();
  EXPECT_GT(inside(*b.limits.fences, b, *b.in.X_WR), before + 0.05);
}

}  // namespace
}  // namespace motionlab::controller
