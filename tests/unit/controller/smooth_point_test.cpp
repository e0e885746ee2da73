#include "gateway/controller/smooth_point.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace motionlab::controller {
namespace {

using Vector3d = Eigen::Vector3d;

TEST(SmoothPoint, ArrivesWithoutOvershootWithinItsBounds) {
  const SmoothPointLimits limits;
  for (const double distance : {0.02, 0.3, 1.0, 3.0}) {
    SmoothPoint dut(limits);
    dut.reset(Vector3d::Zero());
    Vector3d a_before = Vector3d::Zero();
    for (int i = 0; i < 30000; ++i) {
      dut.step(1e-3, Vector3d(distance, -distance, 0));
      ASSERT_LE(dut.v().cwiseAbs().maxCoeff(), limits.speed_mps * 1.001);
      ASSERT_LE(dut.a().cwiseAbs().maxCoeff(), limits.acceleration_mps2 + 1e-12);
      ASSERT_LE((dut.a() - a_before).cwiseAbs().maxCoeff(), limits.jerk_mps3 * 1e-3 + 1e-12);
      ASSERT_LE(dut.p().x(), distance + 1e-4);
      a_before = dut.a();
    }
    EXPECT_NEAR(dut.p().x(), distance, 1e-4);
    EXPECT_NEAR(dut.p().y(), -distance, 1e-4);
    EXPECT_NEAR(dut.v().norm(), 0, 1e-4);
  }
}

TEST(SmoothPoint, SurvivesATargetThatKeepsJumping) {
  const SmoothPointLimits limits;
  SmoothPoint dut(limits);
  dut.reset(Vector3d::Zero());
  for (int i = 0; i < 60000; ++i) {
    dut.step(1e-3, Vector3d((i / 700) % 2 == 0 ? 2.0 : -2.0, 0, 0));
    ASSERT_LE(std::abs(dut.v().x()), limits.speed_mps * 1.2);
    ASSERT_LE(std::abs(dut.a().x()), limits.acceleration_mps2 + 1e-12);
  }
}

}  // namespace
}  // namespace motionlab::controller
