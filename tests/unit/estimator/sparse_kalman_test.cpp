#include "gateway/math/sparse_kalman.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "drivers/core/random.hpp"

namespace motionlab::math {
namespace {

constexpr int kSize = 12;
using State = KalmanState<kSize>;
using Vector = State::Vector;
using Matrix = State::Matrix;

State random_state(Random& random) {
  State s;
  Matrix root;
  for (int i = 0; i < kSize; ++i) {
    s.x[i] = random.normal();
    for (int j = 0; j < kSize; ++j) root(i, j) = random.normal();
  }
  s.P = root * root.transpose() + 0.1 * Matrix::Identity();
  s.P = (0.5 * (s.P + s.P.transpose())).eval();
  return s;
}

/// A row of three random entries, sparse and dense.
std::pair<SparseRow, Vector> random_row(Random& random) {
  std::pair<SparseRow, Vector> row{{}, Vector::Zero()};
  for (int k = 0; k < 3; ++k) {
    const int index = static_cast<int>(random.below(kSize));
    const double value = random.normal();
    row.first.add(index, value);
    row.second[index] += value;
  }
  return row;
}

TEST(SparseKalman, AgreesWithTheDenseJosephForm) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    State dut = random_state(random);
    const auto [sparse, h] = random_row(random);
    const double innovation = random.normal(), variance = random.uniform(0.1, 2.0);
    const double s = h.dot(dut.P * h) + variance;
    const Vector K = dut.P * h / s;
    const Matrix I_KH = Matrix::Identity() - K * h.transpose();
    const Matrix P = I_KH * dut.P * I_KH.transpose() + variance * K * K.transpose();
    const Vector x = dut.x + K * innovation;
    ASSERT_TRUE(dut.update(sparse, innovation, variance, 100));
    EXPECT_LT((dut.x - x).cwiseAbs().maxCoeff(), 1e-12 * (1 + x.norm()));
    EXPECT_LT((dut.P - P).cwiseAbs().maxCoeff(), 1e-12 * P.norm());
  }
}

TEST(SparseKalman, ScalarGainIsTheClosedForm) {
  KalmanState<1> dut;
  dut.P(0, 0) = 4;
  SparseRow row;
  row.add(0, 1);
  ASSERT_TRUE(dut.update(row, 5, 1, 8));
  EXPECT_DOUBLE_EQ(dut.x[0], 4);
  EXPECT_NEAR(dut.P(0, 0), 0.8, 1e-15);
}

TEST(SparseKalman, RefusesWhatLiesBeyondTheGateAndChangesNothing) {
  KalmanState<1> dut;
  dut.P(0, 0) = 3;
  SparseRow row;
  row.add(0, 1);
  // s = 4, so that two standard deviations of the innovation are 4.
  EXPECT_FALSE(dut.update(row, 4.0001, 1, 2));
  EXPECT_FALSE(dut.update(row, -4.0001, 1, 2));
  EXPECT_EQ(dut.x[0], 0);
  EXPECT_EQ(dut.P(0, 0), 3);
  EXPECT_TRUE(dut.update(row, 3.9999, 1, 2));
}

TEST(SparseKalman, RefusesWhatIsNotANumber) {
  KalmanState<1> dut;
  dut.P(0, 0) = 3;
  SparseRow row;
  row.add(0, 1);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity(), 1e300}) {
    EXPECT_FALSE(dut.update(row, bad, 1, 8));
  }
  SparseRow nan_row;
  nan_row.add(0, std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(dut.update(nan_row, 0, 1, 8));
  EXPECT_EQ(dut.x[0], 0);
  EXPECT_EQ(dut.P(0, 0), 3);
}

TEST(SparseKalman, StaysSymmetricAndPositiveDefiniteOverManyUpdates) {
  Random random(2);
  State dut = random_state(random);
  for (int i = 0; i < 100000; ++i) {
    const auto [sparse, h] = random_row(random);
    dut.update(sparse, random.normal(), random.uniform(1e-4, 1.0), 8);
    dut.P.diagonal().array() += 1e-6;
    if (i % 1000 == 0) {
      ASSERT_EQ((dut.P - dut.P.transpose()).cwiseAbs().maxCoeff(), 0) << i;
      ASSERT_EQ(dut.P.llt().info(), Eigen::Success) << i;
    }
  }
  EXPECT_TRUE(dut.x.allFinite());
}

}  // namespace
}  // namespace motionlab::math
