#include "gateway/math/moving_base.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace motionlab::math {
namespace {

/// A body that tumbles smoothly, with a point that wanders on it.
RigidTransform pose(double t) {
  return {from_euler({0.3 * std::sin(t), 0.2 * std::cos(0.7 * t), 0.5 * t}, EulerOrder::zyx),
          {std::sin(t), 0.5 * t * t, std::cos(2 * t)}};
}
Vector3d point(double t) {
  return {1 + 0.1 * t, std::sin(3 * t), 2 - t * t};
}

BodyMotion body(double t, double h) {
  const auto omega = [&](double s) {
    const Matrix3d W = pose(s).R.transpose() * (pose(s + h).R - pose(s - h).R) / (2 * h);
    return Vector3d(W(2, 1), W(0, 2), W(1, 0));
  };
  return {pose(t), (pose(t + h).p - pose(t - h).p) / (2 * h),
          (pose(t + h).p - 2 * pose(t).p + pose(t - h).p) / (h * h), omega(t),
          (omega(t + h) - omega(t - h)) / (2 * h)};
}

TEST(MovingBase, CarriesAPointAsDifferencesOfItsWorldPositionSay) {
  const double t = 0.8, h = 1e-4;
  const PointMotion in_B{point(t), (point(t + h) - point(t - h)) / (2 * h),
                         (point(t + h) - 2 * point(t) + point(t - h)) / (h * h)};
  const PointMotion in_W = carried(body(t, h), in_B);
  const auto world = [](double s) { return pose(s) * point(s); };
  EXPECT_NEAR((in_W.p - world(t)).norm(), 0, 1e-12);
  EXPECT_NEAR((in_W.v - (world(t + h) - world(t - h)) / (2 * h)).norm(), 0, 1e-6);
  EXPECT_NEAR((in_W.a - (world(t + h) - 2 * world(t) + world(t - h)) / (h * h)).norm(), 0, 1e-4);
}

TEST(MovingBase, ExtrapolatesToThirdOrder) {
  const double t = 0.8, dt = 0.01;
  const BodyMotion later = body(t, 1e-4).after(dt);
  EXPECT_NEAR((later.X_WB.p - pose(t + dt).p).norm(), 0, 3e-6);
  EXPECT_NEAR((later.X_WB.R - pose(t + dt).R).norm(), 0, 3e-6);
}

}  // namespace
}  // namespace motionlab::math
