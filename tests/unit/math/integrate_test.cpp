#include "gateway/math/integrate.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace motionlab::math {
namespace {

using Eigen::Vector2d;

/// A smooth problem that depends on time and is not linear.
Vector2d smooth(double t, const Vector2d& x) {
  return {-2 * x[0] * t + std::cos(3 * t) * x[1], std::sin(t) - x[0] * x[1]};
}

template <class Step>
double error_at_two(const Step& step, int steps) {
  static const Vector2d exact = rk4<Vector2d>(smooth, 0.0, Vector2d(1, 0.5), 2.0, 40000);
  Vector2d x(1, 0.5);
  const double h = 2.0 / steps;
  for (int i = 0; i < steps; ++i) x = step(i * h, x, h);
  return (x - exact).norm();
}

template <class Step>
void expect_order(const Step& step, int order) {
  for (const int steps : {80, 160}) {
    const double ratio = error_at_two(step, steps) / error_at_two(step, 2 * steps);
    EXPECT_NEAR(std::log2(ratio), order, 0.35) << steps;
  }
}

TEST(Rk4, IsOfFourthOrder) {
  expect_order([](double t, const Vector2d& x, double h) { return rk4_step<Vector2d>(smooth, t, x, h); }, 4);
}

TEST(Rk4, IsExactForCubicsInTime) {
  using One = Eigen::Matrix<double, 1, 1>;
  const auto f = [](double t, const One&) { return One(4 * t * t * t - 3 * t * t); };
  EXPECT_NEAR(rk4<One>(f, 0.0, One(1.0), 2.0, 1)[0], 1 + 16 - 8, 1e-13);
}

TEST(StiffStep, IsOfThirdOrderWithAGivenJacobianAndWithDifferences) {
  const auto jacobian = [](double t, const Vector2d& x) {
    Eigen::Matrix2d J;
    J << -2 * t, std::cos(3 * t), -x[1], -x[0];
    return J;
  };
  expect_order([&](double t, const Vector2d& x,
                   double h) { return stiff_step<Vector2d>(smooth, jacobian(t, x), t, x, h).x; },
               3);
  expect_order([](double t, const Vector2d& x, double h) { return stiff_step<Vector2d>(smooth, t, x, h).x; },
               3);
}

TEST(StiffStep, ErrorEstimateIsOfTheSizeOfASecondOrderError) {
  const auto estimate = [](double h) {
    return stiff_step<Vector2d>(smooth, 0.3, Vector2d(1, 0.5), h).error.norm();
  };
  EXPECT_NEAR(std::log2(estimate(0.02) / estimate(0.01)), 3, 0.2);
}

TEST(StiffStep, ForgetsAFastModeInOneStep) {
  // Prothero and Robinson: x' = −10⁶ (x − cos t) − sin t. From a wrong start, one step lands on the slow
  // path.
  using One = Eigen::Matrix<double, 1, 1>;
  const auto f = [](double t, const One& x) { return One(-1e6 * (x[0] - std::cos(t)) - std::sin(t)); };
  One x(3.0);
  for (int i = 0; i < 100; ++i) {
    x = stiff_step<One>(f, 0.1 * i, x, 0.1).x;
    if (i > 0) {
      EXPECT_NEAR(x[0], std::cos(0.1 * (i + 1)), 2e-6) << i;
    }
  }
  // The explicit step explodes.
  One y(1.0);
  for (int i = 0; i < 10; ++i) y = rk4_step<One>(f, 0.1 * i, y, 0.1);
  EXPECT_FALSE(std::abs(y[0]) < 1e6);
}

TEST(StiffStep, HoldsALoadOnAStiffWireAtStepsFarBeyondItsPeriod) {
  // A load of 12 kg on a wire of EA = 2e5 N and 2 m, released 3 mm too low: 14.5 Hz, critically damped here.
  // The steps are 50 ms; what remains is the static stretch.
  const double mass = 12, stiffness = 2e5 / 2, gravity = 9.81, damping = 2 * std::sqrt(stiffness * mass);
  const auto f = [&](double, const Vector2d& s) {
    return Vector2d(s[1], gravity - (stiffness * s[0] + damping * s[1]) / mass);
  };
  Vector2d s(mass * gravity / stiffness + 3e-3, 0);
  for (int i = 0; i < 40; ++i) s = stiff_step<Vector2d>(f, 0.05 * i, s, 0.05).x;
  EXPECT_NEAR(s[0], mass * gravity / stiffness, 1e-9);
  EXPECT_NEAR(s[1], 0, 1e-8);
}

TEST(IntegrateStiff, SolvesVanDerPolWithMuOfAThousand) {
  // Reference: Hairer & Wanner's test set, problem VDPOL (epsilon 1e-6, t = 2), in unscaled time.
  const auto f = [](double, const Vector2d& x) {
    return Vector2d(x[1], 1000 * (1 - x[0] * x[0]) * x[1] - x[0]);
  };
  const auto path = integrate_stiff<Vector2d>(f, 0.0, Vector2d(2, 0), 2000.0, {1e-10, 1e-8, 1e-6});
  EXPECT_TRUE(path.arrived);
  EXPECT_EQ(path.t, 2000.0);
  EXPECT_NEAR(path.x[0], 1.706167732170469, 2e-6);
  EXPECT_NEAR(path.x[1], -0.8928097010248125e-3, 2e-9);
  EXPECT_LT(path.taken + path.refused, 30000);
}

TEST(IntegrateStiff, ErrorFollowsTheTolerance) {
  const auto f = [](double t, const Vector2d& x) { return smooth(t, x); };
  const Vector2d exact = rk4<Vector2d>(smooth, 0.0, Vector2d(1, 0.5), 2.0, 40000);
  double before = 1;
  for (const double tolerance : {1e-4, 1e-6, 1e-8}) {
    const auto path = integrate_stiff<Vector2d>(f, 0.0, Vector2d(1, 0.5), 2.0, {tolerance, tolerance, 1e-3});
    EXPECT_TRUE(path.arrived);
    const double error = (path.x - exact).norm();
    EXPECT_LT(error, 100 * tolerance);
    EXPECT_LT(error, before / 10);
    before = error;
  }
}

TEST(IntegrateStiff, SaysWhenItDidNotArrive) {
  using One = Eigen::Matrix<double, 1, 1>;
  const auto ends = [](double t, const One&) { return One(std::sqrt(1 - t)); };  // no number beyond t = 1
  const auto path = integrate_stiff<One>(ends, 0.0, One(0.0), 2.0);
  EXPECT_FALSE(path.arrived);
  EXPECT_NEAR(path.t, 1.0, 1e-6);
  EXPECT_NEAR(path.x[0], 2.0 / 3.0, 1e-5);
  const auto f = [](double, const One& x) { return One(-x[0]); };
  const auto stopped = integrate_stiff<One>(f, 0.0, One(1.0), 2.0, {1e-9, 1e-6, 1e-6, 3});
  EXPECT_FALSE(stopped.arrived);
  EXPECT_EQ(stopped.taken + stopped.refused, 3);
}

}  // namespace
}  // namespace motionlab::math
