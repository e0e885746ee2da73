// The six-axis arm of thesis Tab A.4 in Orocos KDL: people who know neither us nor the thesis.
#include <gtest/gtest.h>

#ifdef MOTIONLAB_HAVE_KDL

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_lma.hpp>
#include <kdl/chainjnttojacdotsolver.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <kdl/framevel.hpp>
#include <kdl/jntarrayvel.hpp>

#include "drivers/core/random.hpp"
#include "tests/unit/math/arms.hpp"
#include "tests/unit/math/kdl_arm.hpp"

namespace motionlab::math {
namespace {

using test::Vector6;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// From the angles of the table to plate values.
const Matrix6 kSigns = [] {
  Matrix6 S = Matrix6::Zero();
  S.diagonal() << -1, -1, 1, -1, -1, -1;
  S(2, 1) = 1;
  return S;
}();

class Kdl : public testing::Test {
 protected:
  const SerialChain<6> dut = test::six_axis_arm(test::kTool);
  const KDL::Chain chain = test::kdl_six_axis_arm(test::kTool);
  Random random{17};

  Vector6 vector(double size) {
    Vector6 v;
    for (int i = 0; i < 6; ++i) v[i] = random.uniform(-size, size);
    return v;
  }
  Vector6 posture() { return test::six_axis_home() + vector(1.0); }
};

TEST_F(Kdl, AgreesOnEveryFrame) {
  KDL::ChainFkSolverPos_recursive solver(chain);
  for (int i = 0; i < 200; ++i) {
    const Vector6 q = posture();
    const auto frames = dut.frames(q);
    for (int link = 1; link <= 7; ++link) {
      KDL::Frame X;
      ASSERT_GE(solver.JntToCart(test::table_angles(q), X, link), 0);
      const auto& ours = frames[static_cast<std::size_t>(link)];
      EXPECT_LT((ours.p - test::position(X)).norm(), 1e-14);
      EXPECT_LT((ours.R - test::rotation(X)).norm(), 1e-14);
    }
  }
}

TEST_F(Kdl, AgreesOnTheJacobianAndItsDerivative) {
  KDL::ChainJntToJacSolver jacobian(chain);
  KDL::ChainJntToJacDotSolver jacobian_dot(chain);
  for (int i = 0; i < 200; ++i) {
    const Vector6 q = posture(), qd = vector(2.0);
    KDL::Jacobian J(6), Jd(6);
    ASSERT_GE(jacobian.JntToJac(test::table_angles(q), J), 0);
    KDL::JntArray theta_dot(6);
    theta_dot.data = kSigns * qd;
    ASSERT_GE(jacobian_dot.JntToJacDot(KDL::JntArrayVel(test::table_angles(q), theta_dot), Jd), 0);
    EXPECT_LT((dut.jacobian(q) - Matrix6(J.data) * kSigns).norm(), 1e-13);
    EXPECT_LT((dut.jacobian_dot(q, qd) - Matrix6(Jd.data) * kSigns).norm(), 1e-12);
  }
}

TEST_F(Kdl, FindsTheSamePostureFromTheSameStart) {
  KDL::ChainIkSolverPos_LMA solver(chain, 1e-9);
  int both = 0;
  for (int i = 0; i < 100; ++i) {
    Vector6 q = posture();
    q[4] = 0.4 + 0.3 * (q[4] + 1);  // clear of the wrist's singularity
    const RigidTransform goal = dut.tool(q);
    const Vector6 start = q + vector(0.1);
    const auto ours = dut.inverse(goal, start);
    KDL::JntArray found(6);
    const bool theirs = solver.CartToJnt(test::table_angles(start), test::frame(goal), found) >= 0;
    EXPECT_TRUE(ours.reached);
    if (!theirs) continue;
    EXPECT_LT((dut.tool(ours.q).p - goal.p).norm(), 1e-9);
    // Theirs stops some 1e-7 off, for it weighs turning by 0.01: how far apart the angles may then be is the
    // Jacobian's to say.
    const double smallest = dut.jacobian(q).jacobiSvd().singularValues()[5];
    if (smallest < 0.01) continue;
    ++both;
    EXPECT_LT((test::table_angles(ours.q).data - found.data).norm(), 1e-6 / smallest);
  }
  EXPECT_GE(both, 90);
}

}  // namespace
}  // namespace motionlab::math

#else

TEST(Kdl, AgreesWithUs) {
  GTEST_SKIP()
      << "Orocos KDL was not found when this was configured: install liborocos-kdl-dev to compare the "
         "serial chains with it.";
}

#endif
