#include "gateway/math/pendulum.hpp"

#include <gtest/gtest.h>

#include "drivers/core/random.hpp"
#include "gateway/math/complex_step.hpp"
#include "gateway/math/euler_rates.hpp"
#include "gateway/math/integrate.hpp"
#include "tests/unit/math/arms.hpp"
#include "tests/unit/math/golden.hpp"

namespace motionlab::math {
namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;

constexpr double kGravity = 9.81;
constexpr double kTurn = 2 * test::kPi;

struct Case {
  Vector2d angles, rates;
  Vector3d a_WT;
  double L, Ld;
};

Case random_case(Random& random) {
  const auto u = [&](double a) { return random.uniform(-a, a); };
  return {{u(1.2), u(1.2)}, {u(2), u(2)}, {u(5), u(5), u(5)}, random.uniform(1, 6), u(1)};
}

TEST(Pendulum, GivesTheGoldenAccelerations) {
  const auto golden = test::golden("thesis_pendulum.json").at("acceleration");
  for (const auto* name : {"constant L", "varying L"}) {
    for (const auto& row : golden.at(name)) {
      const Vector2d angles = test::fixed<2>(row.at("phi"));
      const double L = row.at("L");
      const Vector2d result =
          swing_acceleration<double>(angles, test::fixed<2>(row.at("phi_t")), test::fixed<3>(row.at("P_tt")),
                                     L, row.at("L_t").get<double>(), kGravity);
      EXPECT_LT(test::deviation(result, test::matrix(row.at("phi_tt"))), 1e-10);
      const Vector3d wire = L * wire_direction(angles);
      EXPECT_LT(test::deviation(wire, test::matrix(row.at("load_minus_tool"))), 1e-10);
    }
  }
  for (const auto& row : golden.at("2-D, varying L, z_tt")) {
    const double result = planar_swing_acceleration<double>(
        row.at("phi"), row.at("phi_t"), row.at("x_tt"), row.at("z_tt"), row.at("L"), row.at("L_t"), kGravity);
    const double expected = row.at("phi_tt");
    EXPECT_NEAR(result, expected, 1e-10 * std::abs(expected));
  }
}

TEST(Pendulum, ObeysNewton) {
  // The load's acceleration plus gravity lies along the wire, whatever the wire length does.
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Case c = random_case(random);
    const Vector2d accelerations = swing_acceleration<double>(c.angles, c.rates, c.a_WT, c.L, c.Ld, kGravity);
    const PointMotion tool{{1, 2, 3}, {0.1, -0.2, 0.3}, c.a_WT};
    const PointMotion load =
        load_motion(tool, {c.angles, c.rates, accelerations, c.L, c.Ld, random.uniform(-1, 1)});
    const Vector3d lambda = wire_direction(c.angles);
    const Vector3d force = load.a + kGravity * Vector3d::UnitZ();
    EXPECT_LT(lambda.cross(force).norm(), 1e-12 * (1 + force.norm()));
    EXPECT_NEAR(wire_force_per_mass(load, lambda, kGravity), -lambda.dot(force), 1e-14);
  }
}

TEST(Pendulum, LoadMotionIsTheDerivativeOfThePosition) {
  constexpr double h = 1e-4;
  const auto angles = [](double t) { return Vector2d(0.3 * std::sin(2 * t), 0.4 * std::cos(t)); };
  const auto length = [](double t) { return 2 + 0.3 * std::sin(t); };
  const auto tool = [](double t) { return Vector3d(std::sin(t), t * t, std::cos(3 * t)); };
  const auto load = [&](double t) { return Vector3d(tool(t) + length(t) * wire_direction(angles(t))); };
  const auto first = [](const auto& f, double t) -> decltype(f(t)) {
    return (f(t + h) - f(t - h)) / (2 * h);
  };
  const auto second = [](const auto& f, double t) -> decltype(f(t)) {
    return (f(t + h) - 2 * f(t) + f(t - h)) / (h * h);
  };
  const double t = 0.7;
  const Swing swing{angles(t), first(angles, t), second(angles, t),
                    length(t), first(length, t), second(length, t)};
  const PointMotion dut = load_motion({tool(t), first(tool, t), second(tool, t)}, swing);
  EXPECT_LT((dut.p - load(t)).norm(), 1e-14);
  EXPECT_LT((dut.v - first(load, t)).norm(), 1e-7);
  EXPECT_LT((dut.a - second(load, t)).norm(), 1e-6);
}

TEST(Pendulum, AgreesWithTheCartesianLoadOnAStiffSpringlessWire) {
  // A second formulation without any angle: the wire force that keeps |p_TL| = L(t), integrated in x, y, z.
  using State6 = Eigen::Matrix<double, 6, 1>;
  const auto length = [](double t) { return 2 + 0.5 * std::sin(0.8 * t); };
  const auto length_rate = [](double t) { return 0.4 * std::cos(0.8 * t); };
  const auto length_acceleration = [](double t) { return -0.32 * std::sin(0.8 * t); };
  const auto tool = [](double t) {
    return PointMotion{{0.5 * std::sin(t), 0.3 * std::sin(1.3 * t), 0.2 * std::cos(t)},
                       {0.5 * std::cos(t), 0.39 * std::cos(1.3 * t), -0.2 * std::sin(t)},
                       {-0.5 * std::sin(t), -0.507 * std::sin(1.3 * t), -0.2 * std::cos(t)}};
  };
  const auto newton = [&](double t, const State6& s) -> State6 {
    const Vector3d d = s.head<3>() - tool(t).p, v = s.tail<3>() - tool(t).v;
    const double L = length(t);
    const Vector3d gravity(0, 0, -kGravity);
    // d·(gravity + f d/L² − a_T) + v² = L L'' + L'², from d·d = L² twice derived.
    const double f = L * length_acceleration(t) + length_rate(t) * length_rate(t) - v.squaredNorm() -
                     d.dot(gravity - tool(t).a);
    State6 rate;
    rate << s.tail<3>(), gravity + f * d / d.squaredNorm();
    return rate;
  };
  const auto lagrange = [&](double t, const Vector4d& s) -> Vector4d {
    Vector4d rate;
    rate << s.tail<2>(),
        swing_acceleration<double>(s.head<2>(), s.tail<2>(), tool(t).a, length(t), length_rate(t), kGravity);
    return rate;
  };
  const Vector4d start(0.3, -0.4, 0.2, 0.5);
  const PointMotion load0 = load_motion(
      tool(0), {start.head<2>(), start.tail<2>(), Vector2d::Zero(), length(0), length_rate(0), 0});
  State6 cartesian;
  cartesian << load0.p, load0.v;
  cartesian = rk4<State6>(newton, 0.0, cartesian, 10.0, 20000);
  const Vector4d angles = rk4<Vector4d>(lagrange, 0.0, start, 10.0, 20000);
  const PointMotion load = load_motion(
      tool(10), {angles.head<2>(), angles.tail<2>(), Vector2d::Zero(), length(10), length_rate(10), 0});
  EXPECT_LT((load.p - cartesian.head<3>()).norm(), 1e-8);
  EXPECT_LT((load.v - cartesian.tail<3>()).norm(), 1e-8);
}

TEST(Pendulum, KeepsItsEnergyOnAFixedWireAndTheCorrectedEquation351IsIt) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random);
    const Vector3d v(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const double sa = std::sin(c.angles[0]), ca = std::cos(c.angles[0]);
    const double sb = std::sin(c.angles[1]), cb = std::cos(c.angles[1]);
    const double ad = c.rates[0], bd = c.rates[1], L = c.L, Ld = c.Ld;
    const double corrected = (v.squaredNorm() + Ld * Ld) / 2 + L * L * ad * ad / 2 +
                             L * L * bd * bd * ca * ca / 2 - Ld * v.x() * sa - L * ad * v.x() * ca -
                             Ld * v.z() * ca * cb + Ld * v.y() * ca * sb + L * bd * v.y() * ca * cb +
                             L * ad * v.z() * cb * sa + L * bd * v.z() * ca * sb - L * ad * v.y() * sa * sb;
    const PointMotion load =
        load_motion({Vector3d::Zero(), v, Vector3d::Zero()}, {c.angles, c.rates, Vector2d::Zero(), L, Ld, 0});
    EXPECT_NEAR(load.v.squaredNorm() / 2, corrected, 1e-12 * (1 + corrected));
  }
  const auto energy = [](const Vector4d& s) {
    const PointMotion load = load_motion({}, {s.head<2>(), s.tail<2>(), Vector2d::Zero(), 2.0, 0, 0});
    return load.v.squaredNorm() / 2 + kGravity * load.p.z();
  };
  const auto rate = [](double, const Vector4d& s) -> Vector4d {
    Vector4d d;
    d << s.tail<2>(),
        swing_acceleration<double>(s.head<2>(), s.tail<2>(), Vector3d::Zero(), 2.0, 0.0, kGravity);
    return d;
  };
  const Vector4d start(0.5, 0.6, 0, 0);
  EXPECT_NEAR(energy(rk4<Vector4d>(rate, 0.0, start, 20.0, 20000)), energy(start), 1e-9);
}

TEST(Pendulum, JacobianIsTheComplexStepDerivative) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random);
    Eigen::Matrix<double, 9, 1> at;
    at << c.angles, c.rates, c.a_WT, c.L, c.Ld;
    const auto f = [](const auto& x) {
      using S = typename std::decay_t<decltype(x)>::Scalar;
      return swing_acceleration<S>(x.template segment<2>(0), x.template segment<2>(2),
                                   x.template segment<3>(4), x[7], x[8], kGravity);
    };
    const SwingJacobian expected = complex_step_jacobian<9>(f, at);
    const SwingJacobian dut = swing_jacobian(c.angles, c.rates, c.a_WT, c.L, c.Ld, kGravity);
    EXPECT_LT((dut - expected).norm(), 1e-13 * (1 + expected.norm()));
  }
}

TEST(Pendulum, AnglesAndRatesComeBackFromTheWire) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random);
    const PointMotion wire = load_motion({}, {c.angles, c.rates, Vector2d::Zero(), c.L, c.Ld, 0});
    EXPECT_LT((swing_angles(wire.p) - c.angles).norm(), 1e-14);
    EXPECT_LT((swing_rates(wire.p, wire.v) - c.rates).norm(), 1e-13);
  }
  EXPECT_EQ(swing_angles(Vector3d::Zero()), Vector2d::Zero());
  EXPECT_NEAR(swing_angles({-1, 0, 0})[0], test::kPi / 2, 1e-15);
}

TEST(Pendulum, PlanarFormIsTheSpatialOneInItsPlane) {
  Random random(5);
  for (int i = 0; i < 200; ++i) {
    const Case c = random_case(random);
    // In the plane b = 0 the angle a counts the other way: the load is at −L sin a.
    const Vector2d space = swing_acceleration<double>({c.angles[0], 0}, {c.rates[0], 0},
                                                      {c.a_WT.x(), 0, c.a_WT.z()}, c.L, c.Ld, kGravity);
    const double plane = planar_swing_acceleration<double>(-c.angles[0], -c.rates[0], c.a_WT.x(), c.a_WT.z(),
                                                           c.L, c.Ld, kGravity);
    EXPECT_NEAR(space[0], -plane, 1e-12);
    EXPECT_EQ(space[1], 0);
  }
}

/// The wave of Tab 4.4 at the neutral pose's tool point, in W.
PointMotion tool_on_the_wave(const test::Json& golden, double t) {
  const auto amplitude = test::fixed<6>(golden.at("wave_amp")),
             frequency = test::fixed<6>(golden.at("wave_freq_hz")),
             phase = test::fixed<6>(golden.at("wave_phase"));
  Eigen::Matrix<double, 6, 1> eta, rate, acceleration;
  for (int i = 0; i < 6; ++i) {
    const double w = kTurn * frequency[i];
    eta[i] = amplitude[i] * std::sin(w * t + phase[i]);
    rate[i] = amplitude[i] * w * std::cos(w * t + phase[i]);
    acceleration[i] = -w * w * eta[i];
  }
  const BodyTurn turn = body_turn({eta.tail<3>(), rate.tail<3>(), acceleration.tail<3>()}, EulerOrder::zyx);
  const BodyMotion body{{from_euler(eta.tail<3>(), EulerOrder::zyx), eta.head<3>()},
                        rate.head<3>(),
                        acceleration.head<3>(),
                        turn.omega_radps,
                        turn.alpha_radps2};
  const Matrix3d R_BR = test::fixed<3, 3>(golden.at("Rbr_projected_to_SO3"));
  const Vector3d p_BR = test::fixed<4, 4>(golden.at("Hbr_printed")).topRightCorner<3, 1>();
  const Vector3d home = test::crane_arm().position({0, 0, -test::kPi / 2});
  const PointMotion in_N = carried(body, {R_BR * home + p_BR, Vector3d::Zero(), Vector3d::Zero()});
  const Matrix3d R_WN = test::fixed<3, 3>(golden.at("R_gn"));
  return {R_WN * in_N.p, R_WN * in_N.v, R_WN * in_N.a};
}

TEST(Wave, IsThatOfTable44) {
  const auto golden = test::golden("thesis_platform.json");
  const auto amplitude = test::fixed<6>(golden.at("wave_amp")),
             frequency = test::fixed<6>(golden.at("wave_freq_hz")),
             phase = test::fixed<6>(golden.at("wave_phase"));
  for (const auto& row : golden.at("wave_eta")) {
    const double t = row.at("t");
    const auto w = kTurn * frequency.array();
    const Eigen::Matrix<double, 6, 1> eta = amplitude.array() * (w * t + phase.array()).sin();
    EXPECT_LT(test::deviation(eta, test::matrix(row.at("eta"))), 1e-10);
    EXPECT_LT(
        test::deviation(amplitude.array() * w * (w * t + phase.array()).cos(), test::matrix(row.at("eta_t"))),
        1e-10);
    EXPECT_LT(test::deviation(-w.square() * eta.array(), test::matrix(row.at("eta_tt"))), 1e-10);
  }
}

template <class Rate>
void expect_path(const test::Json& golden, const char* key, const Rate& rate, const Vector4d& start) {
  const auto& path = golden.at("openloop").at(key);
  Vector4d x = start;
  double t = 0;
  for (std::size_t i = 0; i < path.at("t").size(); ++i) {
    const double next = path.at("t")[i];
    x = rk4<Vector4d>(rate, t, x, next, static_cast<int>(std::lround((next - t) / 5e-4)));
    t = next;
    EXPECT_LT((x - test::fixed<4>(path.at("phi_phi_t")[i])).cwiseAbs().maxCoeff(), 1e-8)
        << key << " at " << t;
  }
}

TEST(Pendulum, SwingsFreelyAsTheGoldenRunsDo) {
  const auto golden = test::golden("thesis_pendulum.json");
  const Vector4d start(15 * test::kPi / 180, 20 * test::kPi / 180, 0, 0);
  const auto with_length = [](auto length, auto length_rate) {
    return [=](double t, const Vector4d& s) -> Vector4d {
      Vector4d d;
      d << s.tail<2>(), swing_acceleration<double>(s.head<2>(), s.tail<2>(), Vector3d::Zero(), length(t),
                                                   length_rate(t), kGravity);
      return d;
    };
  };
  expect_path(golden, "free 15/20 deg, L=2",
              with_length([](double) { return 2.0; }, [](double) { return 0.0; }), start);
  const double w = kTurn * 0.05;
  expect_path(golden, "free 15/20 deg, L=2+0.75 sin(2 pi 0.05 t)",
              with_length([w](double t) { return 2 + 0.75 * std::sin(w * t); },
                          [w](double t) { return 0.75 * w * std::cos(w * t); }),
              start);
}

TEST(Pendulum, IsCarriedByTheWaveAsTheGoldenRunIs) {
  const auto wave = test::golden("thesis_platform.json");
  // The wave once for all half steps: parsing JSON in every one would take minutes.
  std::vector<Vector3d> a;
  for (int i = 0; i <= 20 * 4000; ++i) a.push_back(tool_on_the_wave(wave, i / 4000.0).a);
  const auto rate = [&](double t, const Vector4d& s) -> Vector4d {
    Vector4d d;
    const auto i = static_cast<std::size_t>(std::lround(4000 * t));
    d << s.tail<2>(), swing_acceleration<double>(s.head<2>(), s.tail<2>(), a[i], 2.0, 0.0, kGravity);
    return d;
  };
  expect_path(test::golden("thesis_pendulum.json"),
              "robot locked at home on the Tab 4.4 wave, L=2, from rest (motion scenario 4, world frame, "
              "projected Rbr)",
              rate, Vector4d::Zero());
}

TEST(Pendulum, AnswersTheStepOfTheTwoDimensionalLawsAsTheGoldenRunsDo) {
  const auto golden = test::golden("thesis_pendulum.json").at("closedloop_2d_step_1m");
  const auto gains = test::golden("thesis_gains.json").at("gains");
  using State5 = Eigen::Matrix<double, 5, 1>;  // x, x', theta, theta', integral of x − 1
  const auto expect = [&](const char* key, const auto& law) {
    const auto rate = [&law](double, const State5& s) -> State5 {
      const double u = law(s);
      return State5{s[1], u, s[3], planar_swing_acceleration<double>(s[2], s[3], u, 0.0, 2.0, 0.0, kGravity),
                    s[0] - 1};
    };
    State5 x = State5::Zero();
    double t = 0;
    for (std::size_t i = 0; i < golden.at(key).at("t").size(); ++i) {
      const double next = golden.at(key).at("t")[i];
      x = rk4<State5>(rate, t, x, next, static_cast<int>(std::lround((next - t) / 2.5e-4)));
      t = next;
      const auto& expected = golden.at(key).at("x")[i];
      for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_NEAR(x[static_cast<int>(k)], expected[k].get<double>(), 1e-8) << key << " at " << t;
      }
    }
  };
  const auto& fpf = gains.at("2D FPF code weights");
  const Eigen::RowVector4d K = test::fixed<1, 4>(fpf.at("computed"));
  const double N = fpf.at("N")[0][0];
  expect("FPF code weights", [&](const State5& s) { return N - K * s.head<4>(); });
  const auto K_i = test::fixed<1, 5>(gains.at("2D IC code weights, +C (sign as printed)").at("computed"));
  expect("IC code weights", [&](const State5& s) { return -K_i[0] * s[4] - K_i.tail<4>().dot(s.head<4>()); });
  // Eq 4.39/4.40 with the sign that damps.
  expect("virtual damper, corrected sign u=+L d th_t/cos th + 0.2(1-x) - 0.85 x_t, d=5",
         [](const State5& s) { return 2.0 * 5.0 * s[3] / std::cos(s[2]) + 0.2 * (1 - s[0]) - 0.85 * s[1]; });
}

}  // namespace
}  // namespace motionlab::math
