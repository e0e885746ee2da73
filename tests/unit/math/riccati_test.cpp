#include "gateway/math/riccati.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "drivers/core/random.hpp"

namespace motionlab::math {
namespace {

using Eigen::MatrixXd;

MatrixXd random_matrix(Random& random, int rows, int columns) {
  MatrixXd M(rows, columns);
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) M(i, j) = random.normal();
  }
  return M;
}

/// The second method: the sign of the Hamiltonian by Newton's iteration (Roberts 1971), S ← (c S + S⁻¹/c)/2.
MatrixXd care_by_matrix_sign(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) {
  const Eigen::Index n = A.rows();
  const MatrixXd G = B * R.inverse() * B.transpose();
  MatrixXd S(2 * n, 2 * n);
  S << A, -G, -Q, -A.transpose();
  for (int i = 0; i < 200; ++i) {
    const Eigen::PartialPivLU<MatrixXd> lu(S);
    const MatrixXd inverse = lu.inverse();
    // Far from the limit the scale that makes the norms meet; near it none, which is quadratic.
    const double c = std::sqrt(std::sqrt(inverse.norm() / S.norm() * inverse.lpNorm<1>() / S.lpNorm<1>()));
    const double scale = std::abs(c - 1) < 0.05 ? 1.0 : c;
    const MatrixXd next = 0.5 * (scale * S + inverse / scale);
    const double change = (next - S).norm() / next.norm();
    S = next;
    if (change < 1e-15) break;
  }
  // The columns of [I; X] span the kernel of S + I.
  MatrixXd left(2 * n, n), right(2 * n, n);
  left << S.topRightCorner(n, n), S.bottomRightCorner(n, n) + MatrixXd::Identity(n, n);
  right << S.topLeftCorner(n, n) + MatrixXd::Identity(n, n), S.bottomLeftCorner(n, n);
  const MatrixXd X = left.colPivHouseholderQr().solve(-right);
  return 0.5 * (X + X.transpose());
}

TEST(Riccati, AgreesWithTheMatrixSignUpToFortyStates) {
  Random random(11);
  for (const int n : {1, 2, 3, 5, 8, 13, 20, 30, 40}) {
    for (int trial = 0; trial < 3; ++trial) {
      const int m = 1 + n / 5;
      const MatrixXd A = random_matrix(random, n, n), B = random_matrix(random, n, m);
      const MatrixXd root = random_matrix(random, n, n), input = random_matrix(random, m, m);
      const MatrixXd Q = root * root.transpose();
      const MatrixXd R = input * input.transpose() + MatrixXd::Identity(m, m);
      const MatrixXd X = solve_care(A, B, Q, R);
      EXPECT_LT(care_residual(A, B, Q, R, X), 1e-11) << n;
      EXPECT_LT((X - care_by_matrix_sign(A, B, Q, R)).norm(), 1e-8 * X.norm()) << n;
      EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(X).eigenvalues().minCoeff(), 0);
    }
  }
}

TEST(Riccati, SolvesWhereTheHamiltonianHasRepeatedEigenvalues) {
  // Two equal chains of three integrators: eigenvectors alone cannot span a defective subspace.
  const int n = 6;
  MatrixXd A = MatrixXd::Zero(n, n), B = MatrixXd::Zero(n, 2);
  for (const int i : {0, 1, 3, 4}) A(i, i + 1) = 1;
  B(2, 0) = B(5, 1) = 1;
  // q = (1, 0, 0): closed loop at the sixth roots of unity; q = (1, 3, 3): a triple pole at −1.
  for (const Eigen::Vector3d& q : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1, 3, 3)}) {
    Eigen::VectorXd weights(n);
    weights << q, q;
    const MatrixXd Q = weights.asDiagonal(), R = MatrixXd::Identity(2, 2);
    const MatrixXd X = solve_care(A, B, Q, R);
    EXPECT_LT(care_residual(A, B, Q, R, X), 1e-13);
  }
  const MatrixXd Q = (Eigen::VectorXd(n) << 1, 3, 3, 1, 3, 3).finished().asDiagonal();
  const MatrixXd K = lqr(A, B, Q, MatrixXd::Identity(2, 2));
  EXPECT_LT((K.row(0).head(3) - Eigen::RowVector3d(1, 3, 3)).norm(), 1e-9);  // (s + 1)³
}

TEST(Riccati, ResidualOfAWrongSolutionIsLarge) {
  const MatrixXd one = MatrixXd::Identity(2, 2);
  EXPECT_GT(care_residual(-one, one, one, one, 2 * one), 0.1);
}

TEST(Riccati, RefusesAnUnseenModeOnTheImaginaryAxis) {
  MatrixXd A(2, 2), B(2, 1);
  A << 0, 1, -1, 0;
  B << 0, 1;
  EXPECT_THROW((void)solve_care(A, B, MatrixXd::Zero(2, 2), MatrixXd::Identity(1, 1)), std::runtime_error);
}

TEST(Lyapunov, AgreesWithItsKroneckerForm) {
  Random random(12);
  for (const int n : {1, 2, 5, 12}) {
    MatrixXd A = random_matrix(random, n, n);
    A -= (A.norm() + 0.1) * MatrixXd::Identity(n, n);
    const MatrixXd root = random_matrix(random, n, n), Q = root * root.transpose();
    MatrixXd kronecker = MatrixXd::Zero(n * n, n * n);
    for (int i = 0; i < n; ++i) {
      kronecker.block(i * n, i * n, n, n) += A;
      for (int j = 0; j < n; ++j) kronecker.block(i * n, j * n, n, n) += A(i, j) * MatrixXd::Identity(n, n);
    }
    const Eigen::VectorXd x = kronecker.partialPivLu().solve(-Eigen::VectorXd::Map(Q.data(), n * n));
    EXPECT_LT((solve_lyapunov(A, Q) - MatrixXd::Map(x.data(), n, n)).norm(), 1e-12 * x.norm());
  }
}

TEST(Lyapunov, SolvesFortyStates) {
  Random random(13);
  const int n = 40;
  MatrixXd A = random_matrix(random, n, n);
  A -= 8 * MatrixXd::Identity(n, n);
  const MatrixXd Q = MatrixXd::Identity(n, n), X = solve_lyapunov(A, Q);
  EXPECT_LT((A * X + X * A.transpose() + Q).norm(), 1e-11);
}

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
