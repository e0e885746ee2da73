#include "gateway/math/serial_chain.hpp"

#include <gtest/gtest.h>

#include "drivers/core/random.hpp"
#include "gateway/math/moving_base.hpp"
#include "tests/unit/math/arms.hpp"
#include "tests/unit/math/golden.hpp"

namespace motionlab::math {
namespace {

using test::Complex;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Vector6 random_posture(Random& random) {
  Vector6 q;
  for (int i = 0; i < 6; ++i) q[i] = random.uniform(-1, 1);
  q[2] -= test::kPi / 2;
  return q;
}

Vector6 random_vector(Random& random) {
  Vector6 v;
  for (int i = 0; i < 6; ++i) v[i] = random.uniform(-1, 1);
  return v;
}

TEST(SerialChain, ThreeAxisTableGivesTheGoldenVectors) {
  const auto dut = test::three_axis_arm();
  for (const auto& golden : test::golden("thesis_arm.json").at("vectors")) {
    const Vector3d q = test::fixed<3>(golden.at("q")), qd = test::fixed<3>(golden.at("qd"));
    const RigidTransform X = dut.tool(q);
    const Eigen::Matrix4d T04 = test::fixed<4, 4>(golden.at("T04"));
    EXPECT_LT(test::deviation(X.p, T04.topRightCorner<3, 1>()), 1e-10);
    EXPECT_LT(test::deviation(X.R, T04.topLeftCorner<3, 3>()), 1e-10);
    EXPECT_LT(test::deviation(dut.jacobian(q).topRows<3>(), test::matrix(golden.at("J"))), 1e-10);
    EXPECT_LT(test::deviation(dut.jacobian_dot(q, qd).topRows<3>(), test::matrix(golden.at("Jdot"))), 1e-10);
    EXPECT_LT(test::deviation((dut.jacobian(q) * qd).head<3>(), test::matrix(golden.at("P_t"))), 1e-10);
    EXPECT_LT(test::deviation(dut.acceleration(q, qd, test::fixed<3>(golden.at("qdd"))).head<3>(),
                              test::matrix(golden.at("P_tt"))),
              1e-10);
  }
}

TEST(SerialChain, SixAxesWithTheWristAtZeroAreTheThreeAxisArm) {
  Random random(1);
  const auto six = test::six_axis_arm(test::kTool);
  const auto three = test::three_axis_arm();
  for (int i = 0; i < 50; ++i) {
    Vector6 q = random_posture(random);
    q.tail<3>().setZero();
    const RigidTransform a = six.tool(q), b = three.tool(q.head<3>());
    EXPECT_LT((a.p - b.p).norm(), 1e-14);
    EXPECT_LT((a.R - b.R).norm(), 1e-14);
  }
}

TEST(SerialChain, EveryFrameIsTheProductOfTheElementaryMatrices) {
  Random random(2);
  const auto dut = test::six_axis_arm(0.3);
  for (int i = 0; i < 50; ++i) {
    const Vector6 q = random_posture(random);
    const auto expected = test::frames_of_table_a4<double>(q);
    const auto frames = dut.frames(q);
    for (std::size_t k = 0; k <= 6; ++k) {
      EXPECT_LT((frames[k].R - expected[k].topLeftCorner<3, 3>()).norm(), 1e-14);
      EXPECT_LT((frames[k].p - expected[k].topRightCorner<3, 1>()).norm(), 1e-14);
    }
    EXPECT_LT((frames[7].p - frames[6] * Vector3d(0, 0, 0.3)).norm(), 1e-14);
    EXPECT_LT((frames[7].p - dut.tool(q).p).norm(), 1e-14);
    EXPECT_LT((frames[7].R - dut.tool(q).R).norm(), 1e-14);
  }
}

TEST(SerialChain, JacobianIsTheComplexStepDerivative) {
  Random random(3);
  const auto dut = test::six_axis_arm();
  for (int i = 0; i < 50; ++i) {
    const Vector6 q = random_posture(random);
    Matrix6 expected;
    for (int k = 0; k < 6; ++k) {
      Eigen::Matrix<Complex, 6, 1> moved = q.cast<Complex>();
      moved[k] += Complex(0, test::kStep);
      const auto T = test::frames_of_table_a4<Complex>(moved)[6];
      const Matrix3d R = T.topLeftCorner<3, 3>().real(), dR = T.topLeftCorner<3, 3>().imag() / test::kStep;
      expected.col(k) << T.topRightCorner<3, 1>().imag() / test::kStep, test::unhat(dR * R.transpose());
    }
    EXPECT_LT((dut.jacobian(q) - expected).norm(), 1e-13);
  }
}

/// The geometric Jacobian from axes and origins, for any scalar.
template <class S>
Eigen::Matrix<S, 6, 6> jacobian_of_table_a4(const Eigen::Matrix<S, 6, 1>& q) {
  const auto T = test::frames_of_table_a4<S>(q);
  Eigen::Matrix<S, 6, 6> J;
  const auto cross = [](const Eigen::Matrix<S, 3, 1>& a, const Eigen::Matrix<S, 3, 1>& b) {
    // By hand: Eigen conjugates the cross product of complex vectors.
    return Eigen::Matrix<S, 3, 1>(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                  a[0] * b[1] - a[1] * b[0]);
  };
  for (int k = 0; k < 6; ++k) {
    const auto& from = T[static_cast<std::size_t>(k)];
    const Eigen::Matrix<S, 3, 1> axis = from.template block<3, 1>(0, 2);
    const Eigen::Matrix<S, 3, 1> arm = T[6].template block<3, 1>(0, 3) - from.template block<3, 1>(0, 3);
    J.col(k) << cross(axis, arm), axis;
  }
  Eigen::Matrix<S, 6, 6> signs = Eigen::Matrix<S, 6, 6>::Zero();
  signs.diagonal() << -1, -1, 1, -1, -1, -1;
  signs(2, 1) = 1;
  return J * signs;
}

TEST(SerialChain, JacobianDotIsTheComplexStepDerivativeAlongTheMotion) {
  Random random(4);
  const auto dut = test::six_axis_arm();
  for (int i = 0; i < 50; ++i) {
    const Vector6 q = random_posture(random), qd = random_vector(random);
    const Eigen::Matrix<Complex, 6, 1> moved =
        q.cast<Complex>() + Complex(0, test::kStep) * qd.cast<Complex>();
    const Matrix6 expected = jacobian_of_table_a4<Complex>(moved).imag() / test::kStep;
    EXPECT_LT((dut.jacobian(q) - jacobian_of_table_a4<double>(q)).norm(), 1e-13);
    EXPECT_LT((dut.jacobian_dot(q, qd) - expected).norm(), 1e-13);
  }
}

TEST(SerialChain, AccelerationIsTheSecondDerivativeOfThePath) {
  const auto dut = test::six_axis_arm(0.2);
  const Vector6 q{0.2, -0.1, -1.4, 0.5, 0.8, -0.3}, qd{0.4, 0.3, -0.5, 1.0, -0.7, 0.6},
      qdd{1, -1, 0.5, 2, -2, 1};
  const double h = 1e-4;
  const auto at = [&](double t) { return dut.tool(q + t * qd + 0.5 * t * t * qdd).p; };
  const Vector3d expected = (at(h) - 2 * at(0) + at(-h)) / (h * h);
  EXPECT_LT((dut.acceleration(q, qd, qdd).head<3>() - expected).norm(), 1e-6);
}

TEST(SerialChain, InverseReturnsToThePoseFromANearbyStart) {
  Random random(5);
  const auto dut = test::six_axis_arm(test::kTool);
  int reached = 0;
  for (int i = 0; i < 500; ++i) {
    Vector6 q = random_posture(random);
    q[4] = 0.3 + 0.5 * (q[4] + 1);  // clear of the wrist's singularity
    const RigidTransform goal = dut.tool(q);
    const auto found = dut.inverse(goal, q + 0.3 * random_vector(random));
    if (!found.reached) continue;
    ++reached;
    const RigidTransform there = dut.tool(found.q);
    EXPECT_LT((there.p - goal.p).norm(), 1e-9);
    EXPECT_LT((there.R - goal.R).norm(), 2e-9);
  }
  EXPECT_GE(reached, 499);
}

TEST(SerialChain, InverseConvergesLikeNewtonNearTheGoal) {
  const auto dut = test::six_axis_arm(test::kTool);
  const Vector6 q{0.2, -0.1, -1.4, 0.5, 0.8, -0.3};
  const auto found = dut.inverse(dut.tool(q), q + 0.01 * Vector6::Ones());
  EXPECT_TRUE(found.reached);
  EXPECT_LE(found.iterations, 5);
  EXPECT_LT((found.q - q).norm(), 1e-8);
}

TEST(SerialChain, InverseSaysWhenThePoseIsOutOfReachAndStretchesTowardsIt) {
  const auto dut = test::six_axis_arm();
  const Vector6 q{0, 0.3, -1.2, 0, 0.5, 0};
  RigidTransform goal = dut.tool(q);
  goal.p *= 3;
  const auto found = dut.inverse(goal, q);
  EXPECT_FALSE(found.reached);
  EXPECT_GT(found.position_error_m, 1.0);
  EXPECT_LT(found.position_error_m, (goal.p - dut.tool(q).p).norm());
}

TEST(SerialChain, InverseOfTheThreeAxisArmFindsThePositionOnItsOwnOrientation) {
  const auto dut = test::three_axis_arm();
  const Vector3d q(0.2, -0.1, -1.4);
  const auto found = dut.inverse(dut.tool(q), Vector3d(0, 0, -test::kPi / 2));
  EXPECT_TRUE(found.reached);
  EXPECT_LT((found.q - q).norm(), 1e-8);
}

TEST(SerialChain, InverseTurnsHalfWayRoundWithoutLosingTheAxis) {
  const SerialChain<1> dut({{{0, 1, 0}}}, {}, {});
  Eigen::Matrix<double, 1, 1> start, q;
  start << 0;
  q << test::kPi;
  EXPECT_TRUE(dut.inverse(dut.tool(q), start).iterations > 0 ||
              dut.inverse(dut.tool(q), start).rotation_error_rad > 3);
  q << 3.0;
  EXPECT_TRUE(dut.inverse(dut.tool(q), start).reached);
}

TEST(SerialChain, LimitsContainTheirBordersOnly) {
  const auto limits = test::strokes();
  EXPECT_TRUE(limits.contain(limits.min_rad));
  EXPECT_TRUE(limits.contain(limits.max_rad));
  EXPECT_FALSE(limits.contain(limits.max_rad + Vector3d(0, 1e-9, 0)));
  EXPECT_FALSE(limits.contain(Vector3d::Constant(std::nan(""))));
}

}  // namespace
}  // namespace motionlab::math
