#include "simulators/plant/load.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "simulators/plant/calibration.hpp"
#include "simulators/plant/platform.hpp"

namespace motionlab::plant {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

LoadConfig frictionless(double ea_n = 2e5) {
  LoadConfig c;
  c.wire_ea_n = ea_n;
  c.wire_damping_ratio = 0;
  c.swing_damping_ratio = 0;
  c.drag_coefficient = 0;
  c.rigid_body = false;
  return c;
}

Suspension fixed(double length_m = 2.0) {
  return {Vector3d::Zero(), Vector3d::Zero(), length_m, 0};
}

Vector3d hanging_at(const Vector2d& swing, double length) {
  return length * Vector3d(-std::sin(swing[0]), std::cos(swing[0]) * std::sin(swing[1]),
                           -std::cos(swing[0]) * std::cos(swing[1]));
}

double energy(const LoadConfig& c, const LoadState& s, double length) {
  const double stretch = std::max(0.0, s.p_WL.norm() - length);
  return 0.5 * c.mass_kg * s.v_WL.squaredNorm() + c.mass_kg * c.gravity_mps2 * s.p_WL.z() +
         0.5 * c.wire_ea_n / length * stretch * stretch;
}

/// Largest change of energy in 5 s of a swing that also bounces.
double energy_error(double step_s) {
  const LoadConfig c = frictionless();
  const Load load(c);
  LoadState s{hanging_at({0.3, 0.5}, 2.001), {0.02, -0.01, 0.005}};
  const double start = energy(c, s, 2.0);
  double worst = 0;
  for (int i = 0; i < std::lround(5 / step_s); ++i) {
    s = load.step(s, fixed(), fixed(), step_s);
    worst = std::max(worst, std::abs(energy(c, s, 2.0) - start));
  }
  return worst;
}

TEST(Load, KeepsItsEnergyOnAnUndampedWire) {
  EXPECT_LT(energy_error(0.0004), 1e-6);
}

TEST(Load, IsIntegratedWithFourthOrder) {
  const LoadConfig c = frictionless();
  const Load load(c);
  const auto after_a_second = [&](int steps) {
    LoadState s{hanging_at({0.3, 0.5}, 2.001), {0.02, -0.01, 0.005}};
    for (int i = 0; i < steps; ++i) s = load.step(s, fixed(), fixed(), 1.0 / steps);
    return s.p_WL;
  };
  const Vector3d fine = after_a_second(40000);
  const double coarse = (after_a_second(1250) - fine).norm(), half = (after_a_second(2500) - fine).norm();
  EXPECT_NEAR(std::log2(coarse / half), 4.0, 0.2);
}

TEST(Load, MomentumChangesByTensionAndGravityOnly) {
  const LoadConfig c = frictionless();
  const Load load(c);
  const double h = 1e-4;
  LoadState s{hanging_at({0.2, -0.4}, 2.002), {0.3, 0.2, 0}};
  const Vector3d momentum = c.mass_kg * s.v_WL;
  Vector3d impulse = Vector3d::Zero();
  const auto force = [&] {
    return Vector3d(-load.tension_n(s, fixed()) * s.p_WL.normalized() -
                    c.mass_kg * c.gravity_mps2 * Vector3d::UnitZ());
  };
  for (int i = 0; i < 10000; ++i) {
    impulse += 0.5 * h * force();
    s = load.step(s, fixed(), fixed(), h);
    impulse += 0.5 * h * force();
  }
  EXPECT_LT((c.mass_kg * s.v_WL - momentum - impulse).norm(), 1e-3);
}

TEST(Load, HangsStretchedByItsWeight) {
  const LoadConfig c = frictionless();
  const Load load(c);
  const LoadState s = load.at_rest(Vector3d(1, 2, 5), 2.0);
  EXPECT_NEAR((s.p_WL - Vector3d(1, 2, 3)).z(), -c.mass_kg * c.gravity_mps2 * 2.0 / c.wire_ea_n, 1e-12);
  const Suspension at{Vector3d(1, 2, 5), Vector3d::Zero(), 2.0, 0};
  EXPECT_NEAR(load.tension_n(s, at), c.mass_kg * c.gravity_mps2, 1e-9);
  EXPECT_LT(load.acceleration_mps2(s, at).norm(), 1e-9);
}

TEST(Load, FallsFreelyWhileTheWireIsSlack) {
  const Load load(frictionless());
  LoadState s{{0.1, 0.2, -1.0}, {0.5, 0, 1.0}};
  const LoadState start = s;
  for (int i = 0; i < 500; ++i) s = load.step(s, fixed(), fixed(), 0.0004);
  const double t = 0.2;
  const Vector3d fall = start.p_WL + t * start.v_WL - 0.5 * 9.81 * t * t * Vector3d::UnitZ();
  EXPECT_EQ(load.tension_n(s, fixed()), 0);
  EXPECT_LT((s.p_WL - fall).norm(), 1e-12);
}

TEST(Load, TheWireNeverPushes) {
  LoadConfig c;
  c.wire_damping_ratio = 0.9;
  const Load load(c);
  // Barely stretched and flying towards the tool point: the damper alone would push.
  const LoadState s{{0, 0, -2.00001}, {0, 0, 3.0}};
  EXPECT_EQ(load.tension_n(s, fixed()), 0);
}

TEST(Load, ComesBackOntoTheWireAfterAHop) {
  LoadConfig c;
  const Load load(c);
  LoadState s = load.at_rest(Vector3d::Zero(), 2.0);
  s.v_WL.z() = 1.5;
  bool was_slack = false;
  for (int i = 0; i < 12500; ++i) {
    s = load.step(s, fixed(), fixed(), 0.0004);
    was_slack |= load.tension_n(s, fixed()) == 0;
  }
  EXPECT_TRUE(was_slack);
  EXPECT_LT((s.p_WL - load.at_rest(Vector3d::Zero(), 2.0).p_WL).norm(), 1e-3);
}

TEST(Load, SwingsWithThePeriodOfAPendulum) {
  const LoadConfig c = frictionless();
  const Load load(c);
  const double length = load.at_rest(Vector3d::Zero(), 2.0).p_WL.norm();
  LoadState s{hanging_at({0.001, 0}, length), Vector3d::Zero()};
  double crossing = 0, h = 0.0004, last = s.p_WL.x();
  int crossings = 0;
  for (int i = 1; crossings < 10; ++i) {
    s = load.step(s, fixed(), fixed(), h);
    if (s.p_WL.x() * last < 0) {
      ++crossings;
      crossing = (i - s.p_WL.x() / (s.p_WL.x() - last)) * h;
    }
    last = s.p_WL.x();
  }
  // Ten zero crossings after starting at the end of the swing: 4.75 periods.
  EXPECT_NEAR(crossing / 4.75, 2 * std::numbers::pi * std::sqrt(length / 9.81), 1e-4);
}

TEST(Load, SwingDecaysWithTheConfiguredRatioAndTheBounceWithItsOwn) {
  LoadConfig c = frictionless();
  c.swing_damping_ratio = 0.03;
  const Load load(c);
  const double w = std::sqrt(9.81 / 2.0);
  LoadState s{hanging_at({0.01, 0}, 2.0012), Vector3d::Zero()};
  const int steps = static_cast<int>(10 * 2 * std::numbers::pi / w / 0.0004);
  double last_period_max = 0;  // reached nine periods after the start
  for (int i = 0; i < steps; ++i) {
    s = load.step(s, fixed(), fixed(), 0.0004);
    if (i > steps * 9 / 10) last_period_max = std::max(last_period_max, std::abs(s.p_WL.x()));
  }
  EXPECT_NEAR(last_period_max / (2.0 * 0.01), std::exp(-0.03 * 2 * std::numbers::pi * 9), 0.002);

  c = frictionless();
  c.wire_damping_ratio = 0.05;
  const Load bouncing(c);
  const Vector3d rest = bouncing.at_rest(Vector3d::Zero(), 2.0).p_WL;
  s = {rest - Vector3d(0, 0, 0.0005), Vector3d::Zero()};
  const double wz = std::sqrt(c.wire_ea_n / 2.0 / c.mass_kg);
  const double t = 2 * std::numbers::pi / (wz * std::sqrt(1 - 0.05 * 0.05));  // one period
  const int n = 200;
  for (int i = 0; i < n; ++i) s = bouncing.step(s, fixed(), fixed(), t / n);
  EXPECT_NEAR((rest.z() - s.p_WL.z()) / 0.0005, std::exp(-0.05 * wz * t), 1e-4);
}

TEST(Load, AirSlowsItWithTheSquareOfItsSpeed) {
  LoadConfig c;
  const Load load(c);
  const LoadState slack{{0, 0, -1}, {2, 0, 0}};
  const double drag = -c.mass_kg * load.acceleration_mps2(slack, fixed()).x();
  EXPECT_NEAR(drag, 0.5 * 1.2 * 0.47 * std::numbers::pi * 0.15 * 0.15 * 4, 1e-12);
}

TEST(Load, SwingAnglesAreThoseOfTheThesis) {
  const Vector2d swing(0.12, -0.34);
  const Vector3d tool(1, 2, 3);
  EXPECT_LT((swing_angles_rad(tool, tool + hanging_at(swing, 1.7)) - swing).norm(), 1e-14);
  EXPECT_EQ(swing_angles_rad(tool, tool - Vector3d::UnitZ()).norm(), 0);
}

// The judges below know nothing of wires: they are solutions of the angle equations of a rigid wire (thesis
// Eq 3.56, 3.57 in their corrected form), integrated to 1e-12 by an independent computation. Rows: t, alpha,
// beta.
using Row = std::array<double, 3>;

constexpr double kRigid_n = 2e9;
constexpr double kFine_s = 2e-5;

/// Runs the load under a moving suspension and compares the angles at the rows' times.
template <class Hang>
void expect_angles(const Load& load, LoadState s, const Hang& hang, const std::vector<Row>& rows,
                   double tolerance) {
  long step = 0;
  Suspension now = hang(0.0);
  for (const Row& row : rows) {
    for (; static_cast<double>(step) * kFine_s < row[0] - kFine_s / 2; ++step) {
      const Suspension next = hang(static_cast<double>(step + 1) * kFine_s);
      s = load.step(s, now, next, kFine_s);
      now = next;
    }
    const Vector2d swing = swing_angles_rad(now.p_WT, s.p_WL);
    EXPECT_NEAR(swing[0], row[1], tolerance) << "alpha at " << row[0] << " s";
    EXPECT_NEAR(swing[1], row[2], tolerance) << "beta at " << row[0] << " s";
  }
}

/// A load at rest relative to the angles, stretched as gravity along the wire demands.
LoadState at_angles(const LoadConfig& c, const Vector2d& swing, double length, double length_rate) {
  const double pull = c.mass_kg * c.gravity_mps2 * std::cos(swing[0]) * std::cos(swing[1]);
  const Vector3d along = hanging_at(swing, 1.0);
  return {length * (1 + pull / c.wire_ea_n) * along, length_rate * along};
}

TEST(Load, OnANearlyRigidWireSwingsAsTheAngleEquationsSay) {
  const LoadConfig c = frictionless(kRigid_n);
  expect_angles(
      Load(c), at_angles(c, {15 * kDegree, 20 * kDegree}, 2.0, 0), [](double) { return fixed(); },
      {{0.5, 0.12236057068668935, 0.15762153946777752},
       {1.0, -0.15413574855063128, -0.19964105486718448},
       {5.0, -0.01384221986898523, -0.017670763591809305},
       {10.0, -0.26047156807828215, -0.34713406731806046}},
      2e-6);
}

TEST(Load, WithAWinchThatRunsSwingsAsTheAngleEquationsSay) {
  const LoadConfig c = frictionless(kRigid_n);
  const double w = 2 * std::numbers::pi * 0.05;
  const auto hang = [w](double t) {
    return Suspension{Vector3d::Zero(), Vector3d::Zero(), 2 + 0.75 * std::sin(w * t),
                      0.75 * w * std::cos(w * t)};
  };
  expect_angles(Load(c), at_angles(c, {15 * kDegree, 20 * kDegree}, 2.0, 0.75 * w), hang,
                {{0.5, 0.12980395461473954, 0.16740418000296395},
                 {1.0, -0.12167615071989088, -0.15672371693594417},
                 {5.0, -0.1873695781911576, -0.24443078630568307},
                 {10.0, 0.15777320767300962, 0.20449764867519218}},
                2e-6);
}

TEST(Load, UnderTheArmOfARollingShipSwingsAsTheAngleEquationsSay) {
  // The thesis' wave from t = 0 without a fade-in, arm at home, world turned as in the thesis (z up, x as
  // surge).
  Scenario scenario;
  scenario.fade_in_s = 0;
  const ShipMotion ship(scenario, 1);
  math::RigidTransform X_WN;
  X_WN.R = Vector3d(1, -1, -1).asDiagonal();
  // The printed mounting of the robot (thesis App. C.6.1), projected to a rotation.
  math::RigidTransform X_BR;
  X_BR.R << -0.49720669484525476, 0.8676177162229372, -0.00500010971420544, 0.8676248055400864,
      0.49721791453948616, 0.00124188265707309, 0.003563623519311554, -0.003720746847158507,
      -0.9999867282270865;
  X_BR.p = {-1.082, 1.536, -1.0245};
  const Vector3d p_BT = X_BR * Vector3d(2.6192, 0, 2.24);
  const auto hang = [&](double t) {
    const PointMotion tool = point_of(platform_state(X_WN, ship.at(t)), p_BT);
    return Suspension{tool.p_W, tool.v_W, 2.0, 0};
  };
  const LoadConfig c = frictionless(kRigid_n);
  const Suspension start = hang(0);
  LoadState s = at_angles(c, Vector2d::Zero(), 2.0, 0);
  s.p_WL += start.p_WT;
  s.v_WL = start.v_WT;
  expect_angles(Load(c), s, hang,
                {{0.5, 0.02351376535069075, -0.0007206514804861117},
                 {1.0, 0.04553084265458237, -0.016468267850226558},
                 {2.0, -0.08683603172587984, -0.06896174291915855},
                 {5.0, 0.0061890552749640755, 0.04135981890978634},
                 {10.0, 0.11177048204786083, 0.0997297071045849}},
                2e-6);
}

}  // namespace
}  // namespace motionlab::plant
