#include "gateway/controller/carried_place.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace motionlab::controller {
namespace {

using Eigen::Vector3d;
using math::BodyMotion;
using math::PointMotion;
using math::RigidTransform;

const RigidTransform kNeutral{math::rot_z(0.7), Vector3d(1, -2, 3)};
const PointMotion kPlace{Vector3d(2, 1, 4), Vector3d::Zero(), Vector3d::Zero()};

/// A ship that heaves, rolls and turns on known sinusoids.
BodyMotion ship(double t) {
  BodyMotion b;
  const double w = 0.8, a = 0.1 * std::sin(w * t), a_dot = 0.1 * w * std::cos(w * t);
  b.X_WB = {kNeutral.R * math::rot_x(a), kNeutral.p + Vector3d(0, 0, 0.2 * std::sin(t))};
  b.v_WB = Vector3d(0, 0, 0.2 * std::cos(t));
  b.a_WB = Vector3d(0, 0, -0.2 * std::sin(t));
  b.omega_B = Vector3d(a_dot, 0, 0);
  b.alpha_B = Vector3d(-w * w * a, 0, 0);
  return b;
}

TEST(CarriedPlace, StandsInTheWorldUntilAShipCarriesIt) {
  CarriedPlace dut(kNeutral);
  for (int i = 0; i < 1000; ++i) dut.step(0.001, false);
  const PointMotion m = dut.motion(kPlace, ship(3.0));
  EXPECT_EQ(m.p, kPlace.p);
  EXPECT_EQ(m.v, kPlace.v);
  EXPECT_EQ(m.a, kPlace.a);
}

TEST(CarriedPlace, RidesWithTheShipOnceHandedOver) {
  CarriedPlace dut(kNeutral);
  for (int i = 0; i < 20'000; ++i) dut.step(0.001, true);
  const BodyMotion now = ship(3.0);
  const PointMotion m = dut.motion(kPlace, now);
  EXPECT_LT((m.p - now.X_WB * (kNeutral.inverse() * kPlace.p)).norm(), 1e-6);
}

TEST(CarriedPlace, NeverJumpsAndItsDerivativesAreItsDerivatives) {
  CarriedPlace dut(kNeutral);
  constexpr double dt = 0.0005;
  PointMotion last = dut.motion(kPlace, ship(0));
  double speed_gap = 0, acceleration_gap = 0, jump = 0;
  for (int i = 1; i < 16'000; ++i) {
    const double t = dt * i;
    dut.step(dt, t > 1 && t < 5);  // handed over and back
    const PointMotion m = dut.motion(kPlace, ship(t));
    speed_gap = std::max(speed_gap, ((m.p - last.p) / dt - 0.5 * (m.v + last.v)).norm());
    acceleration_gap = std::max(acceleration_gap, ((m.v - last.v) / dt - 0.5 * (m.a + last.a)).norm());
    jump = std::max(jump, (m.a - last.a).norm());
    last = m;
  }
  EXPECT_LT(speed_gap, 1e-3);
  EXPECT_LT(acceleration_gap, 2e-3);
  EXPECT_LT(jump, 2e-3) << "of the acceleration, in half a millisecond";
}

}  // namespace
}  // namespace motionlab::controller
