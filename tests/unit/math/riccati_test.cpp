#include "gateway/math/riccati.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

namespace motionlab::math {
namespace {

using Eigen::MatrixXd;

TEST(Riccati, DoubleIntegratorHasTheGainOfTheTextbook) {
  MatrixXd A(2, 2), B(2, 1);
  A << 0, 1, 0, 0;
  B << 0, 1;
  const MatrixXd K = lqr(A, B, Eigen::Vector2d(1, 0).asDiagonal(), MatrixXd::Identity(1, 1));
  EXPECT_NEAR(K(0, 0), 1.0, 1e-12);
  EXPECT_NEAR(K(0, 1), std::sqrt(2.0), 1e-12);
}

TEST(Riccati, ThesisTwoDimensionalPendulumGainComesBackDigitByDigit) {
  // Thesis Eq 4.24 with the weights of its code: 10, 18.1024, −101.8745, 4.7802.
  MatrixXd A = MatrixXd::Zero(4, 4), B(4, 1);
  A(0, 1) = 1;
  A(2, 3) = 1;
  A(3, 2) = -9.81 / 2;
  B << 0, 1, 0, -0.5;
  const MatrixXd K = lqr(A, B, Eigen::Vector4d(100, 100, 1e4, 100).asDiagonal(), MatrixXd::Identity(1, 1));
  EXPECT_NEAR(K(0, 0), 10.0, 1e-6);
  EXPECT_NEAR(K(0, 1), 18.10235484140682, 1e-6);
  EXPECT_NEAR(K(0, 2), -101.87452051946208, 1e-6);
  EXPECT_NEAR(K(0, 3), 4.78022747422591, 1e-6);
}

TEST(Riccati, RefusesWhatCannotBeStabilised) {
  MatrixXd A = MatrixXd::Identity(2, 2), B(2, 1);
  B << 1, 0;
  EXPECT_THROW((void)lqr(A, B, MatrixXd::Identity(2, 2), MatrixXd::Identity(1, 1)), std::runtime_error);
}

TEST(Lyapunov, FirstOrderProcessHasTheClosedFormVariance) {
  MatrixXd A(1, 1), Q(1, 1);
  A << -0.25;
  Q << 2.0;
  EXPECT_NEAR(solve_lyapunov(A, Q)(0, 0), 4.0, 1e-12);
}

}  // namespace
}  // namespace motionlab::math
