// The load as a body under its hook, and the arm that gives way.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "simulators/plant/load.hpp"
#include "simulators/plant/world.hpp"

namespace motionlab::plant {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kTick_s = 0.0004;

LoadConfig frictionless() {
  LoadConfig c;
  c.wire_damping_ratio = 0;
  c.swing_damping_ratio = 0;
  c.tilt_damping_ratio = 0;
  c.drag_coefficient = 0;
  return c;
}

ArmMode undamped() {
  ArmMode arm;
  arm.damping_ratio = 0;
  return arm;
}

const Suspension kFixed{Vector3d::Zero(), Vector3d::Zero(), 2.0, 0};

/// Swinging, tilting against the wire, bouncing a little, and pulling at the arm.
LoadState lively(const Load& load, const ArmMode& arm) {
  LoadState s = load.at_rest(Vector3d::Zero(), 2.0);
  const double below = load.config().below_hook_m();
  const auto turn = Eigen::AngleAxisd(0.3, Vector3d(0.6, 0.8, 0));
  const Vector3d hook = turn * (s.p_WL + below * s.up);
  s.up = Eigen::AngleAxisd(0.15, Vector3d::UnitX()) * (turn * s.up);
  s.p_WL = hook - below * s.up;
  s.v_WL = {0.1, -0.05, 0.02};
  s.omega_radps = s.up.cross(Vector3d(0.1, 0.05, -0.08));
  if (arm.flexible) s.tip_m += Vector3d(2e-4, -1e-4, 1e-4);
  return s;
}

double energy(const LoadConfig& c, const ArmMode& arm, const LoadState& s) {
  const double wire = 2.0 - c.below_hook_m();
  const Vector3d hook = s.p_WL + c.below_hook_m() * s.up;
  const double stretch = std::max(0.0, (s.tip_m - hook).norm() - wire), w = arm.omega_radps();
  double e = 0.5 * c.mass_kg *
                 (s.v_WL.squaredNorm() + std::pow(c.gyration_radius_m, 2) * s.omega_radps.squaredNorm()) +
             c.mass_kg * c.gravity_mps2 * s.p_WL.z() + 0.5 * c.wire_ea_n / wire * stretch * stretch;
  if (arm.flexible) e += 0.5 * arm.mass_kg * (s.tip_mps.squaredNorm() + w * w * s.tip_m.squaredNorm());
  return e;
}

double energy_error(const ArmMode& arm) {
  const LoadConfig c = frictionless();
  const Load load(c, arm);
  LoadState s = lively(load, arm);
  const double start = energy(c, arm, s);
  double worst = 0;
  for (int i = 0; i < 12500; ++i) {
    s = load.step(s, kFixed, kFixed, kTick_s);
    worst = std::max(worst, std::abs(energy(c, arm, s) - start));
  }
  return worst;
}

TEST(RigidLoad, KeepsItsEnergyWithoutFriction) {
  EXPECT_LT(energy_error(ArmMode::rigid()), 2e-5);
}

TEST(RigidLoad, AndTheArmKeepTheirEnergyTogether) {
  EXPECT_LT(energy_error(undamped()), 2e-5);
}

TEST(RigidLoad, LosesEnergyToEveryDamperAndNeverGainsAny) {
  const ArmMode arm;
  LoadConfig c;
  c.swing_damping_ratio = 0;  // stands for losses that are not on one body alone
  const Load load(c, arm);
  LoadState s = lively(load, arm);
  double last = energy(c, arm, s);
  for (int i = 0; i < 5000; ++i) {
    s = load.step(s, kFixed, kFixed, kTick_s);
    const double now = energy(c, arm, s);
    ASSERT_LT(now, last + 1e-9) << "step " << i;
    last = now;
  }
}

TEST(RigidLoad, IsIntegratedWithFourthOrderTogetherWithTheArm) {
  const ArmMode arm = undamped();
  const Load load(frictionless(), arm);
  const auto after = [&](int steps) {
    LoadState s = lively(load, arm);
    for (int i = 0; i < steps; ++i) s = load.step(s, kFixed, kFixed, 0.5 / steps);
    return s.p_WL;
  };
  const Vector3d fine = after(20000);
  EXPECT_NEAR(std::log2((after(625) - fine).norm() / (after(1250) - fine).norm()), 4.0, 0.3);
}

TEST(RigidLoad, KeepsItsAngularMomentumAboutTheVertical) {
  const LoadConfig c = frictionless();
  const Load load(c);
  LoadState s = lively(load, ArmMode::rigid());
  const auto momentum = [&] {
    return s.p_WL.cross(s.v_WL).z() + std::pow(c.gyration_radius_m, 2) * s.omega_radps.z();
  };
  const double start = momentum();
  for (int i = 0; i < 12500; ++i) s = load.step(s, kFixed, kFixed, kTick_s);
  EXPECT_NEAR(momentum(), start, 1e-7);
  EXPECT_NEAR(s.up.norm(), 1, 1e-14);
  EXPECT_LT(std::abs(s.up.dot(s.omega_radps)), 1e-6) << "it does not begin to spin";
}

// Small motion of a body under a massless wire: M theta'' + K theta = 0 in the angles of wire and body.
TEST(RigidLoad, SwingsAndTiltsWithTheTwoPeriodsOfItsLinearModel) {
  LoadConfig c = frictionless();
  c.wire_ea_n = 2e7;  // the model knows no stretch
  const Load load(c);
  const double a = 1.7, l = 0.3, rho = c.gyration_radius_m, g = c.gravity_mps2;
  Matrix2d M, K;
  M << a * a, a * l, a * l, l * l + rho * rho;
  K << g * a, 0, 0, g * l;
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix2d> modes(K, M);
  for (int mode = 0; mode < 2; ++mode) {
    const Vector2d theta = 1e-4 * modes.eigenvectors().col(mode).normalized();
    LoadState s;
    const Vector3d wire(std::sin(theta[0]), 0, -std::cos(theta[0])),
        body(std::sin(theta[1]), 0, -std::cos(theta[1]));
    s.p_WL = a * (1 + c.mass_kg * g / c.wire_ea_n) * wire + l * body;
    s.v_WL.setZero();
    s.up = -body;
    const double x = s.up.x(), period = 2 * std::numbers::pi / std::sqrt(modes.eigenvalues()[mode]);
    const double h = period / 8000;
    for (int i = 0; i < 2000; ++i) s = load.step(s, kFixed, kFixed, h);
    EXPECT_NEAR(s.up.x() / x, 0, 2e-3) << "after a quarter of mode " << mode;
    for (int i = 0; i < 30000; ++i) s = load.step(s, kFixed, kFixed, h);
    EXPECT_NEAR(s.up.x() / x, 1, 2e-3) << "after four periods of mode " << mode;
  }
}

TEST(RigidLoad, WithItsCentreAtTheHookIsAPointMass) {
  LoadConfig c;
  c.rigid_body = false;
  const Load point(c);
  c.rigid_body = true;
  c.hook_to_centre_m = 0;
  const Load body(c);
  LoadState s = point.at_rest(Vector3d::Zero(), 2.0), t = body.at_rest(Vector3d::Zero(), 2.0);
  s.v_WL = t.v_WL = {0.4, 0.2, 0.1};
  for (int i = 0; i < 2500; ++i) {
    s = point.step(s, kFixed, kFixed, kTick_s);
    t = body.step(t, kFixed, kFixed, kTick_s);
  }
  EXPECT_EQ(s.p_WL, t.p_WL);
}

TEST(RigidLoad, TiltIsTheSwingWhileItHangsStraight) {
  LoadState s{{0, 0, -2}, Vector3d::Zero()};
  const Vector2d swing(0.1, -0.2);
  s.up = Vector3d(std::sin(swing[0]), -std::cos(swing[0]) * std::sin(swing[1]),
                  std::cos(swing[0]) * std::cos(swing[1]));
  EXPECT_LT((tilt_angles_rad(s) - swing).norm(), 1e-15);
}

TEST(ArmMode, GivesWayUnderTheLoadByWeightOverStiffness) {
  const ArmMode arm;
  const Load load(LoadConfig{}, arm);
  const LoadState s = load.at_rest(Vector3d::Zero(), 2.0);
  EXPECT_NEAR(s.tip_m.z(), -12 * 9.81 / (100 * std::pow(2 * std::numbers::pi * 12, 2)), 1e-12);
  const LoadRates r = load.rates(s, kFixed, Vector3d::Zero(), Vector3d::Zero());
  EXPECT_LT(r.a_WL.norm() + r.tip_mps.norm(), 1e-9) << "at rest";
}

TEST(ArmMode, RingsAtItsFrequencyWithItsDampingWhileTheWireIsSlack) {
  const ArmMode arm;
  const Load load(LoadConfig{}, arm);
  LoadState s{{0, 0, -1}, Vector3d::Zero()};
  s.tip_m = {1e-3, 0, 0};
  const double w = arm.omega_radps(), z = arm.damping_ratio, wd = w * std::sqrt(1 - z * z), t = 500 * kTick_s;
  for (int i = 0; i < 500; ++i) s = load.step(s, kFixed, kFixed, kTick_s);
  ASSERT_EQ(load.tension_n(s, kFixed), 0);
  EXPECT_NEAR(s.tip_m.x(), 1e-3 * std::exp(-z * w * t) * (std::cos(wd * t) + z * w / wd * std::sin(wd * t)),
              1e-9);
}

TEST(ArmMode, LagsBehindAnAcceleratedPosture) {
  const ArmMode arm;
  const Load load(LoadConfig{}, arm);
  LoadState s{{0, 0, -1}, Vector3d::Zero()};
  const double a = 0.5;
  const auto at = [&](int i) {
    const double t = i * kTick_s;
    return Suspension{{0.5 * a * t * t, 0, 0}, {a * t, 0, 0}, 100.0, 0};
  };
  for (int i = 0; i < 7500; ++i) s = load.step(s, at(i), at(i + 1), kTick_s);
  EXPECT_NEAR(s.tip_m.x(), -a / (arm.omega_radps() * arm.omega_radps()), 1e-7);
}

TEST(ArmMode, OnANeutralShipOnlyTheLoadBendsTheArm) {
  WorldConfig flexible, rigid;
  rigid.arm_mode = ArmMode::rigid();
  const auto calm = scenario_named("calm").value();
  const Vector3d bent =
      World(flexible, calm, 1).state().crane.tool.p_W - World(rigid, calm, 1).state().crane.tool.p_W;
  EXPECT_NEAR(bent.z(), -12 * 9.81 / (100 * std::pow(2 * std::numbers::pi * 12, 2)), 1e-6);
  EXPECT_LT(bent.head<2>().norm(), 1e-5) << "what is left is the calibration error of the seed";
}

TEST(World, APushHoldsTheLoadAslant) {
  World world({}, scenario_named("calm").value(), 1);
  world.set_push({11.772, 0, 0});
  world.advance(LabTime{from_seconds(100)});
  const WorldState s = world.state();
  const Vector3d off = s.crane.p_WL - s.crane.tool.p_W;
  EXPECT_NEAR(off.x() / -off.z(), 0.1, 1e-3);
  EXPECT_NEAR(s.crane.tilt_rad[0], s.crane.swing_rad[0], 1e-3);
  EXPECT_NEAR(s.twin.swing_rad[0], s.crane.swing_rad[0], 1e-6) << "the twin feels it too";
}

}  // namespace
}  // namespace motionlab::plant
