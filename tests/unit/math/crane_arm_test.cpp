#include "gateway/math/crane_arm.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/unit/math/arms.hpp"
#include "tests/unit/math/golden.hpp"

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

/// The same angles but for whole turns.
Vector3d turned(Vector3d q, const Vector3d& towards) {
  for (int i = 0; i < 3; ++i) q[i] -= 2 * kPi * std::round((q[i] - towards[i]) / (2 * kPi));
  return q;
}

TEST(CraneArm, GivesTheGoldenVectors) {
  for (const auto& golden : test::golden("thesis_arm.json").at("vectors")) {
    const Vector3d q = test::fixed<3>(golden.at("q")), qd = test::fixed<3>(golden.at("qd"));
    EXPECT_LT(test::deviation(dut.position(q), test::matrix(golden.at("P"))), 1e-10);
    EXPECT_LT(test::deviation(dut.jacobian(q), test::matrix(golden.at("J"))), 1e-10);
    EXPECT_LT(test::deviation(dut.jacobian_dot(q, qd), test::matrix(golden.at("Jdot"))), 1e-10);
    EXPECT_LT(test::deviation(dut.acceleration(q, qd, test::fixed<3>(golden.at("qdd"))),
                              test::matrix(golden.at("P_tt"))),
              1e-10);
    const auto all = dut.inverse(dut.position(q), test::strokes());
    ASSERT_EQ(all.reach, Reach::reached);
    const Vector3d up = test::fixed<3>(golden.at("ik_elbow_up(sign -1)"));
    const Vector3d down = test::fixed<3>(golden.at("ik_elbow_down(sign +1)"));
    EXPECT_LT(test::deviation(turned(all.elbow_up->q, up), up), 1e-10);
    EXPECT_LT(test::deviation(turned(all.elbow_down->q, down), down), 1e-10);
    EXPECT_LT((dut.position(all.elbow_up->q) - dut.position(q)).norm(), 1e-12);
    EXPECT_LT((dut.position(all.elbow_down->q) - dut.position(q)).norm(), 1e-12);
    const auto plain = dut.inverse(dut.position(q));
    ASSERT_TRUE(plain);
    EXPECT_LT((turned(*plain, up) - up).norm(), 1e-10);
  }
}

TEST(CraneArm, GivesTheTablesOfTheThesisForBothForearms) {
  const auto tables = test::golden("thesis_arm.json").at("tables");
  const Vector3d home(0, 0, -kPi / 2);
  EXPECT_LT((test::crane_arm(1.492).position(home) -
             test::fixed<3>(tables.at("4.1/4.3 home").at("Tab3.1 L=2.2690")))
                .norm(),
            1e-12);
  EXPECT_LT((test::crane_arm().position(home) - test::fixed<3>(tables.at("4.1/4.3 home").at("code L=2.2692")))
                .norm(),
            1e-12);
  // Tab 4.2 prints no joint angles beside its point: the arm must stand there and come back.
  for (const auto& [name, d4] : {std::pair("Tab3.1 L=2.2690", 1.492), std::pair("code L=2.2692", 1.4922)}) {
    const Vector3d p = test::fixed<3>(tables.at("4.2 offset").at(name));
    const auto q = test::crane_arm(d4).inverse(p, test::strokes()).best();
    ASSERT_TRUE(q);
    EXPECT_LT((test::crane_arm(d4).position(*q) - p).norm(), 1e-12);
  }
}

TEST(CraneArm, HomeIsElbowUpAndItsOtherBranchLeavesTheStroke) {
  const Vector3d home(0, 0, -kPi / 2);
  const auto all = dut.inverse(dut.position(home), test::strokes());
  ASSERT_EQ(all.reach, Reach::reached);
  EXPECT_LT((all.elbow_up->q - home).norm(), 1e-12);
  EXPECT_TRUE(all.elbow_up->within_limits);
  EXPECT_NEAR(all.elbow_down->q[1] * 180 / kPi, 116.3, 0.05);
  EXPECT_NEAR(all.elbow_down->q[2] * 180 / kPi, -38.9, 0.05);
  EXPECT_FALSE(all.elbow_down->within_limits);
  EXPECT_NEAR(all.shoulder_distance_m, 2.672, 5e-4);
  EXPECT_NEAR(all.nearest_m, 1.123, 5e-4);
  EXPECT_NEAR(all.farthest_m, 3.443, 5e-4);
  EXPECT_LT((*all.best() - home).norm(), 1e-12);
}

TEST(CraneArm, TakesTheElbowDownWhereOnlyThatIsWithinLimits) {
  const Vector3d q(0, 1.0, -0.3);
  const auto limits = JointLimits<3>{Vector3d(-1, 0.8, -0.5), Vector3d(1, 1.2, -0.1)};
  const auto all = dut.inverse(dut.position(q), limits);
  ASSERT_EQ(all.reach, Reach::reached);
  EXPECT_FALSE(all.elbow_up->within_limits);
  ASSERT_TRUE(all.best());
  EXPECT_LT((*all.best() - q).norm(), 1e-10);
}

TEST(CraneArm, TurnsTheForearmIntoItsStrokeByWholeTurns) {
  // −200° lies in the stroke of joint 3; the same posture as +160° does not.
  const Vector3d q(0.1, 0.9, -200 * kPi / 180);
  const auto all = dut.inverse(dut.position(q), test::strokes());
  ASSERT_EQ(all.reach, Reach::reached);
  const bool up = (all.elbow_up->q - q).norm() < 1e-10, down = (all.elbow_down->q - q).norm() < 1e-10;
  EXPECT_TRUE(up || down);
  EXPECT_TRUE(all.best());
}

TEST(CraneArm, SaysWhyAPointIsOutOfReach) {
  EXPECT_EQ(dut.inverse({4.0, 0.0, 1.0}, test::strokes()).reach, Reach::too_far);
  EXPECT_EQ(dut.inverse({0.36, 0.0, 0.85}, test::strokes()).reach, Reach::too_near);
  EXPECT_EQ(dut.inverse({0.0, 0.0, 3.0}, test::strokes()).reach, Reach::too_near);
  EXPECT_EQ(dut.inverse(Vector3d::Constant(std::nan("")), test::strokes()).reach, Reach::too_far);
  EXPECT_FALSE(dut.inverse({4.0, 0.0, 1.0}, test::strokes()).best());
  EXPECT_FALSE(dut.inverse(Vector3d::Constant(std::nan(""))));
}

TEST(CraneArm, IsTheThreeAxisSerialChain) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto chain = test::three_axis_arm();
  for (int i = 0; i < 200; ++i) {
    const Vector3d q(uniform(random), uniform(random), -kPi / 2 + uniform(random));
    const Vector3d qd(uniform(random), uniform(random), uniform(random));
    EXPECT_LT((dut.position(q) - chain.tool(q).p).norm(), 1e-14);
    EXPECT_LT((dut.jacobian(q) - chain.jacobian(q).topRows<3>()).norm(), 1e-13);
    EXPECT_LT((dut.jacobian_dot(q, qd) - chain.jacobian_dot(q, qd).topRows<3>()).norm(), 1e-13);
  }
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
