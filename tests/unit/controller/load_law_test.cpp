#include "gateway/controller/load_law.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "gateway/controller/smooth_point.hpp"
#include "tests/unit/controller/bench.hpp"

namespace motionlab::controller {
namespace {

using test::kDegree;
using test::Pendulum;
using Vector3d = Eigen::Vector3d;

LoadLaw::Inputs seen(const Vector3d& reference, const Vector3d& p_WL, const Vector3d& v_WL, double wire_m) {
  LoadLaw::Inputs inputs;
  inputs.reference.p = reference;
  inputs.p_WL = p_WL;
  inputs.v_WL = v_WL;
  inputs.wire_length_m = wire_m;
  return inputs;
}

/// The law in closed loop with a nonlinear pendulum whose tool point does exactly what the law says.
struct Loop {
  LoadLaw law{LoadLawConfig{}};
  Vector3d reference{0.85, -0.41, 3.92};
  double wire_m;
  Pendulum pendulum;
  std::optional<math::PointMotion> moving;  ///< a reference that moves
  Vector3d offset = Vector3d::Zero();       ///< the real tool is off by this and nobody knows
  double t = 0;

  Loop(double wire, double swing_rad, double direction_rad)
      : wire_m(wire),
        pendulum(reference + Vector3d(0, 0, wire),
                 wire * Vector3d(std::sin(swing_rad) * std::cos(direction_rad),
                                 std::sin(swing_rad) * std::sin(direction_rad), -std::cos(swing_rad))) {
    law.start(reference + Vector3d(0, 0, wire), Vector3d::Zero(), reference.z() + wire);
  }
  Vector3d tool() const { return law.p_WT() + offset; }

  /// One millisecond: the law, then ten fine steps of the world.
  void step() {
    const Vector3d p = law.p_WT(), v = law.v_WT();
    LoadLaw::Inputs inputs = seen(reference, pendulum.p, pendulum.v, wire_m);
    if (moving) inputs.reference = *moving;
    law.step(1e-3, inputs);
    for (int k = 0; k < 10; ++k) {
      const double s = 1e-4 * (k + 1);
      pendulum.step(p + s * v + 0.5 * s * s * law.a_WT() + offset, v + s * law.a_WT(), law.a_WT());
    }
    t += 1e-3;
  }
};

TEST(LoadLaw, SettlesAnEightDegreeSwingBelowOneDegreeWithinFourSeconds) {
  for (const double wire : {1.2, 2.0, 2.7}) {
    for (const double direction : {0.0, 0.7, 2.5}) {
      Loop loop(wire, 8 * kDegree, direction);
      double last_above = 0;
      while (loop.t < 20) {
        loop.step();
        if (loop.pendulum.swing(loop.tool()) > kDegree) last_above = loop.t;
        ASSERT_LE(loop.law.a_WT().norm(), 1.5 + 1e-12);
        ASSERT_LE(loop.law.v_WT().norm(), 0.6 + 1e-12);
      }
      EXPECT_LT(last_above, 4.0) << wire << " m, " << direction << " rad";
      EXPECT_LT((loop.pendulum.p - loop.reference).norm(), 2e-3) << wire;
      EXPECT_LT(loop.pendulum.swing(loop.tool()), 0.02 * kDegree) << wire;
    }
  }
}

TEST(LoadLaw, StartsWithoutAStep) {
  LoadLaw dut{LoadLawConfig{}};
  const Vector3d p(0.9, -0.3, 5.9), v(0.11, -0.07, 0.05);
  dut.start(p, v, 2.0);
  EXPECT_EQ(dut.p_WT(), p);
  EXPECT_EQ(dut.v_WT(), v);
  EXPECT_EQ(dut.a_WT(), Vector3d::Zero());
  // Wherever load and reference are, the first step moves the tool by no more than the bounded acceleration.
  dut.step(1e-3, seen(Vector3d(5, 5, 5), Vector3d(-4, 9, 1), Vector3d(3, 3, 3), 2.0));
  EXPECT_LT((dut.p_WT() - p - 1e-3 * v).norm(), 0.5 * 1.5e-6 + 1e-12);
  EXPECT_LT((dut.v_WT() - v).norm(), 1.5e-3 + 1e-12);
}

TEST(LoadLaw, AtItsPlaceItAsksForNothing) {
  Loop loop(2.0, 0, 0);
  for (int i = 0; i < 2000; ++i) {
    loop.step();
    ASSERT_LT(loop.law.a_WT().norm(), 1e-9);
  }
}

TEST(LoadLaw, KeepsItsSpeedWithinTheBound) {
  LoadLaw dut{LoadLawConfig{}};
  Vector3d load(0, 0, 2);
  dut.start(Vector3d(0, 0, 4), Vector3d::Zero(), 11.0);
  double fastest = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d before = dut.v_WT();
    dut.step(1e-3, seen(Vector3d(30, -20, 9), load, dut.v_WT(), 2.0));
    load = dut.p_WT() - Vector3d(0, 0, 2);
    fastest = std::max(fastest, dut.v_WT().norm());
    ASSERT_LE((dut.v_WT() - before).norm(), 1.5e-3 + 1e-12);
  }
  EXPECT_LE(fastest, 0.6 + 1e-12);
  EXPECT_GT(fastest, 0.59);
}

TEST(LoadLaw, ATooFastBeginningIsSlowedNotCut) {
  LoadLaw dut{LoadLawConfig{}};
  dut.start(Vector3d(0, 0, 4), Vector3d(1.0, 0, 0), 4.0);
  double before = 1.0;
  for (int i = 0; i < 3000; ++i) {
    dut.step(1e-3, seen(Vector3d(0, 0, 2), Vector3d(dut.p_WT() - Vector3d(0, 0, 2)), dut.v_WT(), 2.0));
    const double speed = dut.v_WT().norm();
    ASSERT_LE(speed, std::max(before, 0.6) + 1e-12);
    ASSERT_GE(speed, before - 1.5e-3 - 1e-12);
    before = speed;
  }
  EXPECT_LT(before, 0.6);
}

TEST(LoadLaw, TheIntegralRemovesAConstantToolOffset) {
  Loop loop(2.0, 0, 0);
  loop.offset = Vector3d(0.006, -0.008, 0);
  loop.pendulum.p += loop.offset;
  double worst = 0;
  while (loop.t < 60) {
    loop.step();
    const double error = (loop.pendulum.p - loop.reference).head<2>().norm();
    if (loop.t < 3) worst = std::max(worst, error);
  }
  EXPECT_GT(worst, 5e-3);
  EXPECT_LT((loop.pendulum.p - loop.reference).head<2>().norm(), 2e-4);
}

TEST(LoadLaw, WithoutTheIntegralTheSameOffsetStays) {
  LoadLawConfig config;
  config.integral_zone_m = 0;
  Loop loop(2.0, 0, 0);
  loop.law = LoadLaw(config);
  loop.law.start(loop.reference + Vector3d(0, 0, 2), Vector3d::Zero(), loop.reference.z() + 2.0);
  loop.offset = Vector3d(0.006, -0.008, 0);
  loop.pendulum.p += loop.offset;
  while (loop.t < 60) loop.step();
  EXPECT_GT((loop.pendulum.p - loop.reference).head<2>().norm(), 5e-3);
}

TEST(LoadLaw, BringsTheToolToItsHeight) {
  LoadLaw dut{LoadLawConfig{}};
  dut.start(Vector3d(0, 0, 4.3), Vector3d::Zero(), 4.0);
  for (int i = 0; i < 15000; ++i) {
    dut.step(1e-3, seen(Vector3d(0, 0, 2), Vector3d(0, 0, 2.3), Vector3d::Zero(), 2.0));
    ASSERT_GT(dut.p_WT().z(), 4.0 - 1e-6) << "critically damped: no overshoot";
  }
  EXPECT_NEAR(dut.p_WT().z(), 4.0, 1e-3);
}

TEST(LoadLaw, WireLengthsOutsideOfItsTableUseTheNearestGain) {
  for (const double wire : {0.0, 0.3, 4.0, 9.0, 1e6}) {
    LoadLaw dut{LoadLawConfig{}};
    dut.start(Vector3d::Zero(), Vector3d::Zero(), 2.0);
    dut.step(1e-3, seen(Vector3d::Zero(), Vector3d(0.1, 0, -2), Vector3d::Zero(), wire));
    EXPECT_TRUE(dut.a_WT().allFinite()) << wire;
  }
}

TEST(LoadLaw, WithoutItsShareTheToolRidesWithTheShipAndKeepsItsHeight) {
  LoadLaw dut{LoadLawConfig{}};
  const Vector3d reference(0, 0, 2), load(0.1, 0, 2);
  dut.start(Vector3d(0, 0, 4), Vector3d(0.2, 0, 0), 4.0);
  LoadLaw::Inputs inputs = seen(reference, load, Vector3d::Zero(), 2.0);
  inputs.v_ship = Vector3d(0.3, -0.1, 0.4);
  Vector3d before = dut.v_WT();
  // Taken back and given again over seconds, the tool's speed never jumps.
  for (int i = 0; i < 20000; ++i) {
    const double t = 1e-3 * i;
    inputs.share = t < 7 ? 1 - t / 7 : t < 12 ? 0 : std::min(1.0, (t - 12) / 2);
    dut.step(1e-3, inputs);
    ASSERT_LT((dut.v_WT() - before).norm(), 3e-3) << t;
    before = dut.v_WT();
    if (t > 11 && t < 12) {
      ASSERT_NEAR(dut.v_WT().x(), 0.3, 0.01);
      ASSERT_NEAR(dut.v_WT().y(), -0.1, 0.01);
      ASSERT_NEAR(dut.v_WT().z(), 0.0, 1e-9);
      ASSERT_NEAR(dut.p_WT().z(), 4.0, 1e-9);
    }
  }
}

TEST(LoadLaw, FollowsAReferenceThatMovesSmoothly) {
  Loop loop(2.0, 0, 0);
  SmoothPoint moving{SmoothPointLimits{}};
  moving.reset(loop.reference);
  const Vector3d target = loop.reference + Vector3d(0.5, -0.3, 0);
  double worst_swing = 0;
  while (loop.t < 20) {
    moving.step(1e-3, target);
    loop.moving = {moving.p(), moving.v(), moving.a()};
    loop.step();
    worst_swing = std::max(worst_swing, loop.pendulum.swing(loop.tool()));
  }
  EXPECT_LT((loop.pendulum.p - target).norm(), 2e-3);
  EXPECT_LT(worst_swing, 4 * kDegree);
}

TEST(LoadLaw, RefusesWeightsWithoutASolution) {
  LoadLawConfig config;
  config.weight_load_error = config.weight_load_error_integral = 0;
  config.weight_tool_speed = config.weight_swing_rate = 0;
  EXPECT_THROW(LoadLaw{config}, std::runtime_error);
}

}  // namespace
}  // namespace motionlab::controller
