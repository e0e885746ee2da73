#include "gateway/estimator/ship_axis.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace motionlab::estimator {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector4d;

constexpr double kPeriod = 8.0;
constexpr double kDamping = 0.3;

/// The companion matrix of (s² + 2ζωs + ω²)², multiplied out by convolving the two factors.
Matrix4d companion() {
  const double w = 2 * std::acos(-1.0) / kPeriod;
  const double factor[3] = {w * w, 2 * kDamping * w, 1.0};
  double product[5] = {};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) product[i + j] += factor[i] * factor[j];
  }
  Matrix4d F = Matrix4d::Zero();
  for (int i = 0; i < 3; ++i) F(i, i + 1) = 1;
  for (int i = 0; i < 4; ++i) F(3, i) = -product[i];
  return F;
}

/// ∫₀ᵈᵗ exp(F s) G Gᵀ exp(F s)ᵀ ds by Simpson's rule.
Matrix4d integrated_noise(double dt) {
  constexpr int kIntervals = 200;
  Matrix4d sum = Matrix4d::Zero();
  for (int i = 0; i <= kIntervals; ++i) {
    const double weight = i == 0 || i == kIntervals ? 1 : (i % 2 == 1 ? 4 : 2);
    const Vector4d g = (companion() * (dt * i / kIntervals)).exp() * Vector4d::Unit(3);
    sum += weight * g * g.transpose();
  }
  return sum * dt / (3.0 * kIntervals);
}

TEST(ShipAxis, TransitionIsTheMatrixExponential) {
  const ShipAxis dut(kPeriod, kDamping);
  for (const double dt : {0.0, 1e-4, 1e-3, 5e-3, 0.012, 0.05, 0.1}) {
    const Matrix4d expected = (companion() * dt).exp();
    // The series ends: at the longest step it is good for, its rest is just visible.
    EXPECT_LT((dut.transition(dt) - expected).cwiseAbs().maxCoeff(), dt < 0.06 ? 1e-12 : 1e-10) << dt;
  }
}

TEST(ShipAxis, NothingMovesInNoTime) {
  EXPECT_EQ(ShipAxis(kPeriod, kDamping).transition(0.0), Matrix4d::Identity());
}

TEST(ShipAxis, ManySmallStepsAreOneLargeStep) {
  const ShipAxis dut(kPeriod, kDamping);
  Vector4d x(0.3, -0.2, 0.11, 0.07);
  const Vector4d expected = (companion() * 5.0).exp() * x;
  for (int i = 0; i < 1000; ++i) x = dut.transition(0.005) * x;
  EXPECT_LT((x - expected).norm(), 1e-11);
}

TEST(ShipAxis, AddsTheNoiseThatAnIntegralOverTheStepAdds) {
  // The closed form leaves out the equation's own coefficients, which matter at one order of dt higher.
  for (const double dt : {1e-3, 5e-3, 1e-2}) {
    const Matrix4d expected = integrated_noise(dt), actual = ShipAxis::noise(dt);
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        EXPECT_NEAR(actual(i, j), expected(i, j), 2 * dt * std::abs(expected(i, j))) << dt << i << j;
      }
    }
  }
}

TEST(ShipAxis, StationaryCovarianceSolvesItsEquation) {
  const ShipAxis dut(kPeriod, kDamping);
  Matrix4d Q = Matrix4d::Zero();
  Q(3, 3) = 1;
  const Matrix4d& S = dut.stationary();
  EXPECT_LT((companion() * S + S * companion().transpose() + Q).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_GT(S.llt().matrixL()(3, 3), 0);
}

TEST(ShipAxis, StationaryCovarianceIsAFixedPointOfThePrediction) {
  const ShipAxis dut(kPeriod, kDamping);
  const double dt = 0.005;
  const Matrix4d A = dut.transition(dt);
  const Matrix4d& S = dut.stationary();
  EXPECT_LT((A * S * A.transpose() + integrated_noise(dt) - S).cwiseAbs().maxCoeff(), 1e-12 * S.norm());
  // And after a minute of small steps with the closed-form noise it is still there to a few percent.
  Matrix4d P = S;
  for (int i = 0; i < 12000; ++i) P = A * P * A.transpose() + ShipAxis::noise(dt);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(P(i, i), S(i, i), 0.02 * S(i, i)) << i;
}

TEST(ShipAxis, RestsWithoutNoise) {
  const ShipAxis dut(kPeriod, kDamping);
  Vector4d x(1, 0, 0, 0);
  for (int i = 0; i < 40000; ++i) x = dut.transition(0.005) * x;
  EXPECT_LT(x.norm(), 1e-12);
}

}  // namespace
}  // namespace motionlab::estimator
