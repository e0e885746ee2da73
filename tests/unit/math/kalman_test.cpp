#include "gateway/math/kalman.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "drivers/core/random.hpp"
#include "gateway/math/control_properties.hpp"
#include "gateway/math/pendulum.hpp"
#include "gateway/math/riccati.hpp"
#include "tests/unit/math/golden.hpp"

namespace motionlab::math {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kGravity = 9.81;

template <int Rows, int Columns>
Eigen::Matrix<double, Rows, Columns> random_matrix(Random& random) {
  Eigen::Matrix<double, Rows, Columns> M;
  for (int j = 0; j < Columns; ++j) {
    for (int i = 0; i < Rows; ++i) M(i, j) = random.normal();
  }
  return M;
}

MatrixXd random_covariance(Eigen::Index size, Random& random) {
  const MatrixXd root = MatrixXd::NullaryExpr(size, size, [&] { return random.normal(); });
  const MatrixXd P = root * root.transpose() + 0.1 * MatrixXd::Identity(size, size);
  return 0.5 * (P + P.transpose());
}

template <int N>
KalmanState<N> random_state(Random& random) {
  KalmanState<N> s;
  s.P = random_covariance(N, random);
  s.x = random_matrix<N, 1>(random);
  return s;
}

TEST(Kalman, ScalarRandomWalkSettlesAtTheClosedForm) {
  // Known from every textbook: with F = H = Q = R = 1 the predicted variance is the golden ratio.
  using One = Eigen::Matrix<double, 1, 1>;
  KalmanState<1> dut;
  dut.P << 5;
  const One one = One::Identity(), zero = One::Zero();
  for (int i = 0; i < 60; ++i) {
    predict<1>(dut, one, zero, one);
    const auto done = update<1, 1>(dut, one, zero, one);
    ASSERT_TRUE(done);
    if (i == 59) {
      EXPECT_NEAR(done->S(0, 0), 1 + (1 + std::sqrt(5.0)) / 2, 1e-14);
      EXPECT_NEAR(done->K(0, 0), (std::sqrt(5.0) - 1) / 2, 1e-14);
    }
  }
  EXPECT_NEAR(dut.P(0, 0), (std::sqrt(5.0) - 1) / 2, 1e-14);
}

TEST(Kalman, ConstantIsTheMeanOfItsMeasurements) {
  using One = Eigen::Matrix<double, 1, 1>;
  KalmanState<1> dut;
  dut.P << 1e12;
  double sum = 0;
  Random random(1);
  for (int i = 1; i <= 100; ++i) {
    const double z = random.normal();
    sum += z;
    ASSERT_TRUE((update<1, 1>(dut, One::Identity(), One(z - dut.x[0]), One::Identity())));
    EXPECT_NEAR(dut.x[0], sum / i, 1e-9);
    EXPECT_NEAR(dut.P(0, 0), 1.0 / i, 1e-10);
  }
}

TEST(Kalman, UpdateIsTheInformationFormOfADenseReference) {
  Random random(2);
  for (int trial = 0; trial < 200; ++trial) {
    auto dut = random_state<10>(random);
    const auto H = random_matrix<5, 10>(random);
    const MatrixXd R = random_covariance(5, random);
    const VectorXd z = random_matrix<5, 1>(random);
    // P⁺ = (P⁻¹ + HᵀR⁻¹H)⁻¹, x⁺ = P⁺ (P⁻¹x + HᵀR⁻¹z): shares no step with the gain form.
    const MatrixXd P0 = dut.P, H0 = H;
    const VectorXd x0 = dut.x;
    const MatrixXd prior = P0.inverse(), weighted = R.inverse() * H0;
    const MatrixXd information = prior + H0.transpose() * weighted;
    const MatrixXd P = information.inverse();
    const VectorXd told = prior * x0 + weighted.transpose() * z;
    const VectorXd x = P * told, innovation = z - H0 * x0;
    const MatrixXd PHt = P0 * H0.transpose();
    const MatrixXd S = H0 * PHt + R;
    const VectorXd normalised = S.inverse() * innovation;
    const auto done = update<10, 5>(dut, H, innovation, R);
    ASSERT_TRUE(done);
    EXPECT_LT((dut.P - P).norm(), 1e-9 * P.norm());
    EXPECT_LT((dut.x - x).norm(), 1e-9 * (1 + x.norm()));
    EXPECT_LT((done->S - S).norm(), 1e-13 * S.norm());
    EXPECT_NEAR(done->nis, innovation.dot(normalised), 1e-9 * (1 + done->nis));
    EXPECT_EQ(dut.P, dut.P.transpose());
  }
}

TEST(Kalman, RowByRowEqualsAllAtOnce) {
  Random random(3);
  for (int trial = 0; trial < 200; ++trial) {
    auto one = random_state<10>(random);
    auto other = one;
    const auto H = random_matrix<5, 10>(random);
    const auto innovation = random_matrix<5, 1>(random);
    const Eigen::Matrix<double, 5, 1> variances = random_matrix<5, 1>(random).cwiseAbs2().array() + 0.01;
    ASSERT_TRUE((update<10, 5>(one, H, innovation, variances.asDiagonal())));
    EXPECT_EQ((update_row_by_row<10, 5>(other, H, innovation, variances)), 5);
    EXPECT_LT((one.x - other.x).norm(), 1e-11 * (1 + one.x.norm()));
    EXPECT_LT((one.P - other.P).norm(), 1e-11 * one.P.norm());
  }
}

TEST(Kalman, RowByRowLeavesOutWhatLiesBeyondTheGate) {
  KalmanState<2> dut;
  dut.P.setIdentity();
  EXPECT_EQ((update_row_by_row<2, 2>(dut, Eigen::Matrix2d::Identity(), {1.0, 100.0}, {1, 1}, 5.0)), 1);
  EXPECT_DOUBLE_EQ(dut.x[0], 0.5);
  EXPECT_EQ(dut.x[1], 0);
  EXPECT_EQ(
      (update_row_by_row<2, 2>(dut, Eigen::Matrix2d::Identity(), Vector2d::Constant(std::nan("")), {1, 1})),
      0);
}

TEST(Kalman, JosephsFormStaysPositiveWhereTheShortFormFails) {
  // A measurement 10⁹ times better than the belief, again and again.
  KalmanState<2> dut;
  dut.P << 1e9, 0.9e9, 0.9e9, 1e9;
  Eigen::Matrix2d H;
  H << 1, 1, 1, -1;
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE((update<2, 2>(dut, H, Vector2d::Zero(), 1e-9 * Eigen::Matrix2d::Identity())));
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(dut.P).eigenvalues().minCoeff(), 0);
  }
}

TEST(Kalman, RefusesWhatIsNotFiniteOrHasNoVariance) {
  Random random(4);
  auto dut = random_state<2>(random);
  const auto before = dut;
  const Eigen::Matrix2d H = Eigen::Matrix2d::Identity(), R = H, negative = -1e9 * H;
  EXPECT_FALSE((update<2, 2>(dut, H, {0, std::numeric_limits<double>::quiet_NaN()}, R)));
  EXPECT_FALSE((update<2, 2>(dut, H, {std::numeric_limits<double>::infinity(), 0}, R)));
  EXPECT_FALSE((update<2, 2>(dut, H, {1, 1}, negative)));
  EXPECT_EQ(dut.x, before.x);
  EXPECT_EQ(dut.P, before.P);
}

TEST(Kalman, PredictionIsTheDenseFormula) {
  Random random(5);
  auto dut = random_state<10>(random);
  const auto before = dut;
  const auto F = random_matrix<10, 10>(random);
  const auto b = random_matrix<10, 1>(random);
  const MatrixXd Q = random_covariance(10, random);
  predict<10>(dut, F, b, Q);
  const MatrixXd F0 = F, P0 = before.P, FP = F0 * P0;
  const MatrixXd P = FP * F0.transpose() + Q;
  const VectorXd x0 = before.x, x = F0 * x0 + b;
  EXPECT_LT((dut.x - x).norm(), 1e-13);
  EXPECT_LT((dut.P - P).norm(), 1e-12 * dut.P.norm());
  EXPECT_EQ(dut.P, dut.P.transpose());
}

/// What `dx/dt = A x` does in one Euler step, the thesis' way to make its models discrete.
template <int N>
Eigen::Matrix<double, N, N> euler_step(const Eigen::Matrix<double, N, N>& A, double dt) {
  return Eigen::Matrix<double, N, N>::Identity() + dt * A;
}

TEST(ExtendedKalman, FourStatesOfThePlanarPendulumStepAsTheGoldenFilter) {
  const auto golden = test::golden("thesis_kalman.json").at("ekf4");
  const double dt = golden.at("dt"), L = golden.at("L"), u = golden.at("u");
  KalmanState<4> dut;
  dut.x = test::fixed<4>(golden.at("x"));
  dut.P = test::fixed<4, 4>(golden.at("P"));
  const double angle = dut.x[2];
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A(0, 1) = A(2, 3) = 1;
  A(3, 2) = (u * std::sin(angle) - kGravity * std::cos(angle)) / L;
  const Eigen::Matrix4d F = euler_step<4>(A, dt);
  EXPECT_LT(test::deviation(F, test::matrix(golden.at("F"))), 1e-10);
  const Eigen::Vector4d rate(dut.x[1], u, dut.x[3],
                             planar_swing_acceleration<double>(angle, dut.x[3], u, 0.0, L, 0.0, kGravity));
  predict_extended<4>(dut, dut.x + dt * rate, F, test::fixed<4>(golden.at("Q")).asDiagonal());
  EXPECT_LT(test::deviation(dut.x, test::matrix(golden.at("x_pred"))), 1e-10);
  EXPECT_LT(((dut.P - test::fixed<4, 4>(golden.at("P_pred"))).norm()), 1e-10 * dut.P.norm());
  Eigen::Matrix<double, 2, 4> H = Eigen::Matrix<double, 2, 4>::Zero();
  H(0, 0) = H(1, 2) = 1;
  const auto done = update<4, 2>(dut, H, test::fixed<2>(golden.at("z")) - H * dut.x,
                                 test::fixed<2>(golden.at("R")).asDiagonal());
  ASSERT_TRUE(done);
  EXPECT_LT(test::deviation(done->K, test::matrix(golden.at("K"))), 1e-10);
  EXPECT_LT(test::deviation(dut.x, test::matrix(golden.at("x_upd"))), 1e-10);
  EXPECT_LT(((dut.P - test::fixed<4, 4>(golden.at("P_upd"))).norm()), 1e-10 * dut.P.norm());
}

/// dx/dt of (P, P', phi, phi') and its derivative, wire of constant length.
std::pair<Eigen::Matrix<double, 10, 1>, Eigen::Matrix<double, 10, 10>> suspended_load(
    const Eigen::Matrix<double, 10, 1>& x, const Vector3d& u, double L) {
  const Vector2d angles = x.segment<2>(6), rates = x.tail<2>();
  Eigen::Matrix<double, 10, 1> f;
  f << x.segment<3>(3), u, rates, swing_acceleration<double>(angles, rates, u, L, 0.0, kGravity);
  Eigen::Matrix<double, 10, 10> A = Eigen::Matrix<double, 10, 10>::Zero();
  A.block<3, 3>(0, 3).setIdentity();
  A.block<2, 2>(6, 8).setIdentity();
  A.block<2, 4>(8, 6) = swing_jacobian(angles, rates, u, L, 0.0, kGravity).leftCols<4>();
  return {f, A};
}

Eigen::Matrix<double, 5, 10> tool_and_angles() {
  Eigen::Matrix<double, 5, 10> H = Eigen::Matrix<double, 5, 10>::Zero();
  H.block<3, 3>(0, 0).setIdentity();
  H.block<2, 2>(3, 6).setIdentity();
  return H;
}

TEST(ExtendedKalman, TenStatesOfTheSuspendedLoadStepAsTheGoldenFilter) {
  const auto golden = test::golden("thesis_kalman.json").at("ekf10");
  KalmanState<10> dut;
  dut.x = test::fixed<10>(golden.at("x"));
  dut.P = test::fixed<10, 10>(golden.at("P"));
  const auto [f, A] = suspended_load(dut.x, test::fixed<3>(golden.at("u")), 2.0);
  const double dt = 1e-3;
  const Eigen::Matrix<double, 10, 10> F = euler_step<10>(A, dt);
  EXPECT_LT(test::deviation(F, test::matrix(golden.at("F"))), 1e-10);
  predict_extended<10>(dut, dut.x + dt * f, F, test::fixed<10>(golden.at("Q")).asDiagonal());
  EXPECT_LT(test::deviation(dut.x, test::matrix(golden.at("x_pred"))), 1e-10);
  EXPECT_LT(((dut.P - test::fixed<10, 10>(golden.at("P_pred"))).norm()), 1e-10 * dut.P.norm());
  const auto H = tool_and_angles();
  const Eigen::Matrix<double, 5, 1> innovation = test::fixed<5>(golden.at("z")) - H * dut.x;
  auto rows = dut;
  const auto done = update<10, 5>(dut, H, innovation, test::fixed<5>(golden.at("R")).asDiagonal());
  ASSERT_TRUE(done);
  EXPECT_LT(test::deviation(done->K, test::matrix(golden.at("K"))), 1e-10);
  EXPECT_LT(test::deviation(dut.x, test::matrix(golden.at("x_upd"))), 1e-10);
  EXPECT_LT(((dut.P - test::fixed<10, 10>(golden.at("P_upd"))).norm()), 1e-10 * dut.P.norm());
  EXPECT_EQ((update_row_by_row<10, 5>(rows, H, innovation, test::fixed<5>(golden.at("R")))), 5);
  EXPECT_LT(test::deviation(rows.x, test::matrix(golden.at("x_upd"))), 1e-10);
}

TEST(ThesisModels, AreObservableFromPositionsAndAngles) {
  const auto golden = test::golden("thesis_kalman.json").at("observability_rank");
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  A(0, 1) = A(2, 3) = 1;
  A(3, 2) = -kGravity / 2;
  Eigen::Matrix<double, 2, 4> H = Eigen::Matrix<double, 2, 4>::Zero();
  H(0, 0) = H(1, 2) = 1;
  EXPECT_EQ(observability_rank(A, H), golden.at("4-state").get<int>());
  const auto load = suspended_load(Eigen::Matrix<double, 10, 1>::Zero(), Vector3d::Zero(), 2.0);
  EXPECT_EQ(observability_rank(load.second, tool_and_angles()), golden.at("10-state").get<int>());
}

}  // namespace
}  // namespace motionlab::math
