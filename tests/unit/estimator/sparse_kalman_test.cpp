#include "gateway/math/sparse_kalman.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "drivers/core/random.hpp"

namespace motionlab::math {
namespace {

constexpr int kSize = 12;
using State = KalmanState<kSize>;
using Eigen::MatrixXd;
using Eigen::VectorXd;

template <int N>
KalmanState<N> random_state(Random& random) {
  KalmanState<N> s;
  MatrixXd root(N, N);
  for (int i = 0; i < N; ++i) {
    s.x[i] = random.normal();
    for (int j = 0; j < N; ++j) root(i, j) = random.normal();
  }
  const MatrixXd P = root * root.transpose();
  s.P = 0.5 * (P + P.transpose());
  s.P.diagonal().array() += 0.1;
  return s;
}

/// One update with all rows of H, by Joseph's form.
struct DenseUpdate {
  VectorXd x;
  MatrixXd P;

  DenseUpdate(const VectorXd& x_before, const MatrixXd& P_before, const MatrixXd& H,
              const VectorXd& innovation, const MatrixXd& R) {
    const MatrixXd HP = H * P_before;
    const MatrixXd S = HP * H.transpose() + R;
    const MatrixXd K = S.llt().solve(HP).transpose();
    const MatrixXd I_KH = MatrixXd::Identity(P_before.rows(), P_before.cols()) - K * H;
    const MatrixXd half = I_KH * P_before, KR = K * R;
    x = x_before + K * innovation;
    P = half * I_KH.transpose() + KR * K.transpose();
  }
};

/// A row of three random entries, sparse and dense.
template <int N>
std::pair<SparseRow, typename KalmanState<N>::Vector> random_row(Random& random) {
  std::pair<SparseRow, typename KalmanState<N>::Vector> row{{}, KalmanState<N>::Vector::Zero()};
  for (int k = 0; k < 3; ++k) {
    const int index = static_cast<int>(random.below(N));
    const double value = random.normal();
    row.first.add(index, value);
    row.second[index] += value;
  }
  return row;
}

TEST(SparseKalman, AgreesWithTheDenseJosephForm) {
  Random random(1);
  for (int trial = 0; trial < 200; ++trial) {
    State dut = random_state<kSize>(random);
    const auto [sparse, h] = random_row<kSize>(random);
    const double innovation = random.normal(), variance = random.uniform(0.1, 2.0);
    const DenseUpdate expected(dut.x, dut.P, h.transpose(), VectorXd::Constant(1, innovation),
                               MatrixXd::Constant(1, 1, variance));
    ASSERT_TRUE(dut.update(sparse, innovation, variance, 100));
    EXPECT_LT((dut.x - expected.x).cwiseAbs().maxCoeff(), 1e-12 * (1 + expected.x.norm()));
    EXPECT_LT((dut.P - expected.P).cwiseAbs().maxCoeff(), 1e-12 * expected.P.norm());
  }
}

/// A moment's measurements one by one, each with an innovation of its own, against all of them at once.
template <int N>
void expect_one_dense_update(std::uint64_t seed) {
  constexpr int kRows = 5;
  Random random(seed);
  for (int trial = 0; trial < 100; ++trial) {
    auto dut = random_state<N>(random);
    const auto before = dut;
    MatrixXd H(kRows, N), R = MatrixXd::Zero(kRows, kRows);
    VectorXd innovation(kRows);
    {
      SparseUpdates<N, kRows> updates(dut);
      for (int i = 0; i < kRows; ++i) {
        const auto [sparse, h] = random_row<N>(random);
        H.row(i) = h.transpose();
        innovation[i] = random.normal();
        R(i, i) = random.uniform(0.1, 2.0);
        ASSERT_TRUE(updates.update(sparse, innovation[i], R(i, i), 100));
        ASSERT_EQ(dut.P, before.P) << "until the end";
      }
    }
    const DenseUpdate expected(before.x, before.P, H, innovation, R);
    EXPECT_LT((dut.x - expected.x).cwiseAbs().maxCoeff(), 1e-11 * (1 + expected.x.norm()));
    EXPECT_LT((dut.P - expected.P).cwiseAbs().maxCoeff(), 1e-11 * before.P.norm());
    EXPECT_EQ(dut.P, dut.P.transpose());
  }
}

TEST(SparseKalman, AMomentsMeasurementsAreOneDenseUpdate) {
  expect_one_dense_update<12>(3);  // whole tiles
  expect_one_dense_update<13>(4);  // and what is left beside them
  expect_one_dense_update<3>(5);   // no whole tile
}

TEST(SparseKalman, WhatIsRefusedTellsTheOthersNothing) {
  Random random(6);
  State dut = random_state<kSize>(random), without = dut;
  const auto [first, h] = random_row<kSize>(random);
  const auto [last, g] = random_row<kSize>(random);
  {
    SparseUpdates<kSize, 3> updates(dut);
    EXPECT_TRUE(updates.update(first, 0.3, 1, 8));
    EXPECT_FALSE(updates.update(first, 1e9, 1, 8));
    EXPECT_FALSE(updates.update(last, std::numeric_limits<double>::quiet_NaN(), 1, 8));
    EXPECT_TRUE(updates.update(last, -0.2, 1, 8));
  }
  {
    SparseUpdates<kSize, 2> updates(without);
    updates.update(first, 0.3, 1, 8);
    updates.update(last, -0.2, 1, 8);
  }
  EXPECT_EQ(dut.x, without.x);
  EXPECT_EQ(dut.P, without.P);
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
  State dut = random_state<kSize>(random);
  for (int i = 0; i < 100000; ++i) {
    const auto [sparse, h] = random_row<kSize>(random);
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
