#include "gateway/math/control_properties.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/QR>

#include "drivers/core/random.hpp"
#include "gateway/math/riccati.hpp"

namespace motionlab::math {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_matrix(Random& random, int rows, int columns) {
  MatrixXd M(rows, columns);
  for (int j = 0; j < columns; ++j) {
    for (int i = 0; i < rows; ++i) M(i, j) = random.normal();
  }
  return M;
}

TEST(ControlProperties, KalmansMatrixIsBAndItsPowers) {
  MatrixXd A(2, 2), B(2, 1), expected(2, 2);
  A << 0, 1, 0, 0;
  B << 0, 1;
  expected << 0, 1, 1, 0;
  EXPECT_EQ(controllability_matrix(A, B), expected);
}

TEST(ControlProperties, RankIsThatOfKalmansMatrixOnSmallSystems) {
  Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 2 + static_cast<int>(random.below(5)), hidden = static_cast<int>(random.below(2));
    // `hidden` states that no input reaches, behind a random change of coordinates.
    MatrixXd A = random_matrix(random, n, n), B = random_matrix(random, n, 1);
    A.bottomLeftCorner(hidden, n - hidden).setZero();
    B.bottomRows(hidden).setZero();
    const MatrixXd T = random_matrix(random, n, n) + 3 * MatrixXd::Identity(n, n);
    const MatrixXd At = T * A * T.inverse(), Bt = T * B;
    Eigen::FullPivLU<MatrixXd> lu(controllability_matrix(At, Bt));
    lu.setThreshold(1e-8);
    EXPECT_EQ(controllability_rank(At, Bt), n - hidden);
    EXPECT_EQ(controllability_rank(At, Bt), static_cast<int>(lu.rank()));
  }
}

TEST(ControlProperties, SeesAllFortyStatesOfAChainWhereKalmansMatrixHasLostItsDigits) {
  // Forty carts on springs, pushed at one end: the columns of Kalman's matrix span 40 decades.
  const int n = 20;
  MatrixXd A = MatrixXd::Zero(2 * n, 2 * n), B = MatrixXd::Zero(2 * n, 1);
  A.topRightCorner(n, n).setIdentity();
  for (int i = 0; i < n; ++i) {
    A(n + i, i) = -2 * 30.0;
    if (i > 0) A(n + i, i - 1) = 30;
    if (i + 1 < n) A(n + i, i + 1) = 30;
  }
  B(n) = 1;
  EXPECT_EQ(controllability_rank(A, B), 2 * n);
  EXPECT_EQ(observability_rank(A, B.transpose()), 2 * n);
}

TEST(ControlProperties, NamesTheStatesThatNeverShow) {
  MatrixXd A = MatrixXd::Zero(4, 4), C = MatrixXd::Zero(1, 4);
  A(0, 1) = 1;
  A(2, 3) = 1;
  C(0, 0) = 1;
  EXPECT_EQ(observability_rank(A, C), 2);
  const MatrixXd hidden = unobservable_space(A, C);
  ASSERT_EQ(hidden.cols(), 2);
  EXPECT_LT(hidden.topRows(2).norm(), 1e-14);
  EXPECT_NEAR(hidden.norm(), std::sqrt(2.0), 1e-14);
}

TEST(ControlProperties, NothingIsReachedWithoutInputs) {
  EXPECT_EQ(controllability_rank(MatrixXd::Identity(3, 3), MatrixXd::Zero(3, 2)), 0);
}

TEST(ControlProperties, WeightsComeBackFromTheGainTheyMade) {
  Random random(2);
  for (int trial = 0; trial < 50; ++trial) {
    const int n = 2 + static_cast<int>(random.below(4));
    const MatrixXd A = random_matrix(random, n, n), b = random_matrix(random, n, 1);
    VectorXd q(n);
    for (int i = 0; i < n; ++i) q[i] = std::pow(10.0, random.uniform(0, 2));
    const MatrixXd k = lqr(A, b, q.asDiagonal(), MatrixXd::Identity(1, 1));
    const auto found = recover_weights(A, b, k.row(0));
    EXPECT_LT(found.fit, 1e-10);
    EXPECT_LT(((found.q - q).array() / q.array()).abs().maxCoeff(), 1e-4) << n;
  }
}

TEST(ControlProperties, AGainThatNoRegulatorHasIsToldByANegativeWeight) {
  // Pole placement without robustness: |1 + L| < 1 somewhere.
  MatrixXd A(2, 2), b(2, 1);
  A << 0, 1, 0, 0;
  b << 0, 1;
  const auto found = recover_weights(A, b, Eigen::RowVector2d(1, 0.5));  // zeta 0.25; optimal is sqrt(1/2)
  EXPECT_LT(found.q.minCoeff(), 0);
}

}  // namespace
}  // namespace motionlab::math
