#include "gateway/math/crane_arm.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace motionlab::math {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;
const CraneArm dut({0.350, 1.160, 0.250, 0.830, 1.4922 + 0.210 + 0.567});

TEST(CraneArm, StandsAtHomeWhereTheLaboratoryMeasuredIt) {
  const Vector3d home(0, 0, -kPi / 2);
  EXPECT_TRUE(dut.position(home).isApprox(Vector3d(2.6192, 0.0, 2.24), 1e-12));
  const auto q = dut.inverse(dut.position(home));
  ASSERT_TRUE(q);
  EXPECT_NEAR((*q - home).norm(), 0, 1e-12);
}

TEST(CraneArm, InverseUndoesPositionInTheWholeBox) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int i = 0; i < 2000; ++i) {
    const Vector3d q(0.78 * uniform(random), 0.52 * uniform(random), -kPi / 2 + 0.78 * uniform(random));
    const auto back = dut.inverse(dut.position(q));
    ASSERT_TRUE(back);
    EXPECT_NEAR((*back - q).norm(), 0, 1e-9) << q.transpose();
  }
}

TEST(CraneArm, RefusesAPointOutOfReach) {
  EXPECT_FALSE(dut.inverse({4.0, 0.0, 1.0}));
  EXPECT_FALSE(dut.inverse({0.36, 0.0, 0.85}));
}

TEST(CraneArm, JacobiansAreTheDerivatives) {
  const Vector3d q(0.2, -0.3, -1.4), qd(0.5, -0.2, 0.3);
  const double h = 1e-6;
  const Vector3d v = (dut.position(q + h * qd) - dut.position(q - h * qd)) / (2 * h);
  EXPECT_NEAR((dut.jacobian(q) * qd - v).norm(), 0, 1e-9);
  const Eigen::Matrix3d Jd = (dut.jacobian(q + h * qd) - dut.jacobian(q - h * qd)) / (2 * h);
  EXPECT_NEAR((dut.jacobian_dot(q, qd) - Jd).norm(), 0, 1e-9);
}

}  // namespace
}  // namespace motionlab::math
