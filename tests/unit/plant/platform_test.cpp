#include "simulators/plant/platform.hpp"

#include <gtest/gtest.h>

#include "gateway/math/crane_arm.hpp"
#include "simulators/plant/calibration.hpp"

namespace motionlab::plant {
namespace {

using Eigen::Vector3d;

// One sample of an independent computation of thesis Eq 3.61–3.82 with velocity (dP/dt in N, omega in B).
TEST(Platform, APointThatMovesOnAMovingShipMovesAsTheThesisSays) {
  math::RigidTransform X_BR;
  X_BR.R << -0.49720669484525476, 0.8676177162229372, -0.00500010971420544, 0.8676248055400864,
      0.49721791453948616, 0.00124188265707309, 0.003563623519311554, -0.003720746847158507,
      -0.9999867282270865;
  X_BR.p = {-1.082, 1.536, -1.0245};
  PlatformState s;
  s.X_WB.R = math::from_euler({0.1051056362793582, -0.24173507254343676, -0.22632832341210493},
                              math::EulerOrder::zyx);
  s.X_WB.p = {0.23131113188582283, 0.08401639008130068, 0.2726078370372602};
  s.v_WB = {-0.06702798408105641, -0.4059558405187749, -0.22362291061404446};
  s.omega_WB_B = {0.04655249325077543, -0.078148768771715, 0.16034657589836387};
  s.a_WB = {0.34528457789211703, -0.3554306970708548, -0.05095346097311381};
  s.alpha_WB_B = {0.9099840021592819, -0.10067838165756857, 0.264383560973797};
  const PointMotion tool =
      point_of(s, X_BR * Vector3d(2.9455550672985398, -0.15728448864019884, 1.8799725229752258),
               X_BR.R * Vector3d(-0.11313479781434346, 0.5981693119584786, -0.14194427356490963),
               X_BR.R * Vector3d(-0.43896593365791714, -0.615479089751703, -0.09932655309020087));
  EXPECT_LT((tool.p_W - Vector3d(-0.7788987305868736, 4.726255047727437, -2.7566045640431684)).norm(), 1e-12);
  EXPECT_LT((tool.v_W - Vector3d(0.03353668919850525, -0.5415338849172256, -0.0838823769147137)).norm(),
            1e-12);
  EXPECT_LT((tool.a_W - Vector3d(-1.355873343253688, 1.0220035934445104, 3.240247552750116)).norm(), 1e-12);
}

TEST(Platform, RatesAndAccelerationsAreTheDerivativesOfThePose) {
  const Calibration calibration;
  const ShipMotion ship(scenario_named("sea").value(), 1);
  const double t = 31.0, h = 1e-4;
  const auto at = [&](double time) { return platform_state(calibration.world_to_em8000, ship.at(time)); };
  const PlatformState s = at(t), before = at(t - h), after = at(t + h);
  EXPECT_LT(((after.X_WB.p - before.X_WB.p) / (2 * h) - s.v_WB).norm(), 1e-7);
  EXPECT_LT(((after.v_WB - before.v_WB) / (2 * h) - s.a_WB).norm(), 1e-7);
  const Eigen::Matrix3d W = s.X_WB.R.transpose() * (after.X_WB.R - before.X_WB.R) / (2 * h);
  EXPECT_LT((Vector3d(W(2, 1), W(0, 2), W(1, 0)) - s.omega_WB_B).norm(), 1e-7);
  EXPECT_LT(((after.omega_WB_B - before.omega_WB_B) / (2 * h) - s.alpha_WB_B).norm(), 1e-7);
}

// Values derived from the published calibration with another program.
TEST(Calibration, PutsEverythingWhereTheLaboratoryFoundIt) {
  const Calibration c;
  const math::CraneArm arm({0.350, 1.160, 0.250, 0.830, 2.2692});
  const Vector3d p_RT = arm.position({0, 0, -1.5707963267948966});
  EXPECT_LT((c.em8000_to_comau * p_RT - Vector3d(-2.395331, 3.811376, -3.255131)).norm(), 2e-6);
  EXPECT_LT((c.world_to_em8000 * (c.em8000_to_comau * p_RT) - Vector3d(0.847625, -0.407825, 5.919269)).norm(),
            2e-6);
  EXPECT_LT(((c.world_to_em8000 * c.em8000_to_mru1).p - Vector3d(-2.389985, 0.688794, 3.628623)).norm(),
            2e-6);
  EXPECT_LT(((c.world_to_em1500 * c.em1500_to_mru2).p - Vector3d(0.392604, -1.268246, 1.859472)).norm(),
            2e-6);
}

TEST(Calibration, IsOffByTheConfiguredAmountInADirectionOfTheSeed) {
  const Calibration published;
  const Calibration a = disturbed(published, 5e-4, 8.7e-4, 1), b = disturbed(published, 5e-4, 8.7e-4, 2);
  const auto expect_off = [](const math::RigidTransform& truth, const math::RigidTransform& told) {
    EXPECT_NEAR((truth.p - told.p).norm(), 5e-4, 1e-12);
    EXPECT_NEAR(Eigen::AngleAxisd(told.R.transpose() * truth.R).angle(), 8.7e-4, 1e-9);
  };
  expect_off(a.em8000_to_comau, published.em8000_to_comau);
  expect_off(a.em8000_to_mru1, published.em8000_to_mru1);
  expect_off(a.world_to_qtm, published.world_to_qtm);
  EXPECT_EQ(a.world_to_em8000.p, published.world_to_em8000.p) << "the platform itself defines the world";
  EXPECT_GT((a.em8000_to_comau.p - b.em8000_to_comau.p).norm(), 1e-5);
  EXPECT_EQ(disturbed(published, 0, 0, 1).world_to_qtm.p, published.world_to_qtm.p);
}

}  // namespace
}  // namespace motionlab::plant
