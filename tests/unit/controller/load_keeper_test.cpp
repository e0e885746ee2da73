#include "gateway/controller/load_keeper.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/allocations.hpp"
#include "tests/unit/controller/bench.hpp"

namespace motionlab::controller {
namespace {

using Eigen::Matrix3d;
using test::Joint;
using test::kDegree;
using test::kPi;
using Vector3d = Eigen::Vector3d;

const math::RigidTransform kX_WN = math::RigidTransform::from_quaternion(
    {6.0198987883e-05, 0.705931944115, 0.708279565403954, 0.000379322138596},
    {-2.969661622702265, 1.976311036084776, 2.662845015592614});

LoadKeeperConfig lab_config() {
  LoadKeeperConfig config;
  config.arm = {0.350, 1.160, 0.250, 0.830, 1.4922 + 0.210 + 0.567};
  config.X_BR = math::RigidTransform::from_quaternion(
      {0.002461288106714, -0.501408337431486, -0.865206982556575, 0.000706081011787},
      {-1.082024099747949, 1.536041691521612, -1.024461448780775});
  return config;
}

/// An arm of three servos behind a robot computer on a ship that moves on known sinusoids. The estimate is
/// perfect and the load hangs still at its reference, so that the tool is to stand still above it.
struct Bench {
  LoadKeeperConfig config = lab_config();
  LoadKeeper dut{config};
  std::vector<Joint> joints{Joint(0), Joint(0), Joint(-kPi / 2)};
  double wave = 1;
  bool engaged = true;
  Vector3d reference, held;
  std::int64_t us = 0;
  std::uint64_t count = 0;
  std::optional<Wish> wish;
  topic::ArmCommand in_force, on_its_way;
  std::size_t allocated = 0;

  Bench() {
    held = tool(0);
    reference = held - Vector3d(0, 0, 2);
  }

  [[nodiscard]] math::RigidTransform ship(double t) const {
    const double fade = wave * (t < 5 ? std::pow(std::sin(0.1 * kPi * std::max(t, 0.0)), 4) : 1.0);
    const auto sine = [&](double amplitude, double frequency, double phase_deg) {
      return fade * amplitude * std::sin(2 * kPi * frequency * t + phase_deg * kDegree);
    };
    const Matrix3d R = (Eigen::AngleAxisd(sine(5 * kDegree, 0.2, 120), Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(sine(5 * kDegree, 0.1, 0), Vector3d::UnitY()) *
                        Eigen::AngleAxisd(sine(5 * kDegree, 0.15, 90), Vector3d::UnitX()))
                           .toRotationMatrix();
    return kX_WN * math::RigidTransform{R, {sine(0.1, 0.1, 0), sine(0.2, 0.1, 45), sine(0.2, 0.1, 90)}};
  }
  [[nodiscard]] Vector3d tool(double t) const {
    const Vector3d q(joints[0].q(), joints[1].q(), joints[2].q());
    return ship(t) * (config.X_BR * math::CraneArm(config.arm).position(q));
  }

  [[nodiscard]] topic::Estimate estimate(double t) const {
    constexpr double h = 1e-3;
    const auto omega = [this](double s) -> Vector3d {
      const Eigen::AngleAxisd turn(Matrix3d(ship(s - h).R.transpose() * ship(s + h).R));
      return turn.angle() * turn.axis() / (2 * h);
    };
    const auto put = [](std::array<double, 3>& to, const Vector3d& v) { to = {v.x(), v.y(), v.z()}; };
    topic::Estimate e;
    e.valid = true;
    const math::RigidTransform X = ship(t);
    const Eigen::Quaterniond q(X.R);
    e.q_world_platform = {q.w(), q.x(), q.y(), q.z()};
    put(e.p_world_platform_m, X.p);
    put(e.v_world_platform_mps, (ship(t + h).p - ship(t - h).p) / (2 * h));
    put(e.a_world_platform_mps2, (ship(t + h).p - 2 * X.p + ship(t - h).p) / (h * h));
    put(e.omega_world_platform_radps, omega(t));
    put(e.alpha_world_platform_radps2, (omega(t + 0.005) - omega(t - 0.005)) / 0.01);
    put(e.p_world_tool_m, tool(t));
    const Vector3d in_B = X.inverse() * tool(t);
    put(e.v_world_tool_mps, (ship(t + h) * in_B - ship(t - h) * in_B) / (2 * h));
    e.wire_length_m = 2;
    put(e.p_world_load_m, reference);
    return e;
  }

  /// One millisecond: the keeper, perhaps a command, and the world in fine steps.
  void step() {
    const double t = 1e-6 * static_cast<double>(us);
    KeeperInputs in;
    in.t = LabTime{Nanoseconds{us * 1000}};
    const bool sends = us % 5000 == 0;
    in.t_send = LabTime{Nanoseconds{(us + 4999) / 5000 * 5000 * 1000}};
    in.estimate = estimate(t);
    in.arm.sequence_number = ++count;
    in.arm.t_measured_ns = us * 1000;
    for (std::size_t i = 0; i < 3; ++i) {
      in.arm.q_rad[i] = joints[i].q();
      in.arm.qd_radps[i] = joints[i].qd();
    }
    in.reference.p_WL = reference;
    in.engaged = engaged;
    const std::size_t before = test::allocations;
    wish = dut.step(in);
    if (sends) {
      on_its_way.follow = wish.has_value();
      on_its_way.qd_wanted_radps = wish ? wish->qd_radps : std::array<double, 6>{};
      dut.sent(in.t_send, on_its_way);
    }
    allocated += test::allocations - before;
    for (int k = 0; k < 10; ++k) {
      // Half a millisecond from sending to the integrator.
      if (us % 5000 == 500) in_force = on_its_way;
      for (std::size_t i = 0; i < 3; ++i) joints[i].step(in_force.follow, in_force.qd_wanted_radps[i]);
      us += 100;
    }
  }
  void seconds(double s) {
    for (int i = 0; i < static_cast<int>(1000 * s + 0.5); ++i) step();
  }
  [[nodiscard]] double error() const { return (tool(1e-6 * static_cast<double>(us)) - held).norm(); }
};

TEST(LoadKeeper, HoldsTheToolWithinAMillimetreOfAPointInTheWorldWhileTheShipMoves) {
  Bench b;
  double worst = 0;
  for (int i = 0; i < 40000; ++i) {
    b.step();
    ASSERT_TRUE(b.wish.has_value());
    worst = std::max(worst, b.error());
  }
  EXPECT_LT(worst, 1e-3);
  // Without the arm the tool would have gone for a walk.
  Bench still;
  still.engaged = false;
  still.seconds(20);
  EXPECT_GT(still.error(), 0.05);
}

TEST(LoadKeeper, ASlowerServoCostsMillimetresNotTheLoop) {
  Bench b;
  for (std::size_t i = 0; i < 3; ++i) b.joints[i] = Joint(i == 2 ? -kPi / 2 : 0, 0.9 * 25.1327);
  double worst = 0;
  for (int i = 0; i < 40000; ++i) {
    b.step();
    worst = std::max(worst, b.error());
  }
  EXPECT_LT(worst, 6e-3);
}

TEST(LoadKeeper, WishesRestWhileNotEngaged) {
  Bench b;
  b.engaged = false;
  for (int i = 0; i < 10000; ++i) {
    b.step();
    ASSERT_TRUE(b.wish.has_value());
    for (const double qd : b.wish->qd_radps) ASSERT_EQ(qd, 0);
    ASSERT_EQ(b.wish->wire_speed_mps, 0);
  }
}

TEST(LoadKeeper, EngagingOnAMovingShipBeginsWithoutAStep) {
  Bench b;
  b.engaged = false;
  b.seconds(12.3);
  b.engaged = true;
  std::array<double, 6> before{};
  double worst = 0;
  for (int i = 0; i < 100; ++i) {
    b.step();
    ASSERT_TRUE(b.wish.has_value());
    for (std::size_t k = 0; k < 3; ++k) {
      worst = std::max(worst, std::abs(b.wish->qd_radps[k] - before[k]));
    }
    before = b.wish->qd_radps;
  }
  // The law's bounded acceleration begins at once, and the lag of the servo is inverted for it: 1.5 m/s² on
  // an arm of two metres, times 2 zeta/omega and once more through the pull to the set point.
  EXPECT_LT(worst, 0.11);
  b.seconds(20);
  EXPECT_LT(b.error(), 2e-3);
}

TEST(LoadKeeper, APostureOutOfReachGivesNoWish) {
  Bench b;
  b.engaged = false;
  b.seconds(1);
  b.reference += Vector3d(40, 0, 0);
  b.engaged = true;
  bool none = false;
  for (int i = 0; i < 30000 && !none; ++i) {
    b.step();
    none = !b.wish.has_value();
  }
  EXPECT_TRUE(none);
}

TEST(LoadKeeper, TheWinchBringsTheLoadToItsHeightAtABoundedSpeed) {
  Bench b;
  b.wave = 0;
  b.seconds(0.1);
  const double at_reference = b.wish->wire_speed_mps;
  EXPECT_EQ(at_reference, 0);
  KeeperInputs in;
  in.estimate = b.estimate(0);
  in.engaged = true;
  in.reference.p_WL = b.reference;
  const auto wire_speed = [&](double too_high) {
    LoadKeeper keeper(b.config);
    in.t = in.t_send = LabTime{1ms};
    in.estimate.p_world_load_m[2] = b.reference.z() + too_high;
    (void)keeper.step(in);
    in.t = in.t_send = LabTime{2ms};
    return keeper.step(in).value().wire_speed_mps;
  };
  EXPECT_NEAR(wire_speed(0.02), 0.01, 1e-12) << "too high: pay out";
  EXPECT_NEAR(wire_speed(-0.02), -0.01, 1e-12);
  EXPECT_EQ(wire_speed(5), 0.05);
  EXPECT_EQ(wire_speed(-5), -0.05);
}

TEST(LoadKeeper, NeverAllocates) {
  Bench b;
  b.seconds(0.1);
  b.allocated = 0;
  b.seconds(3);
  EXPECT_EQ(b.allocated, 0u);
}

}  // namespace
}  // namespace motionlab::controller
