#include "gateway/math/rotation.hpp"

#include <gtest/gtest.h>

#include <random>

namespace motionlab::math {
namespace {

TEST(Rotation, EulerAnglesComeBackInBothOrders) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.4, 1.4);
  for (const auto order : {EulerOrder::zyx, EulerOrder::xyz}) {
    for (int i = 0; i < 500; ++i) {
      const Vector3d rpy(2 * uniform(random), uniform(random), 2 * uniform(random));
      EXPECT_NEAR((to_euler(from_euler(rpy, order), order) - rpy).norm(), 0, 1e-9);
    }
  }
}

TEST(Rotation, ZyxTurnsYawFirst) {
  const Matrix3d R = from_euler({0.1, 0.2, 0.3}, EulerOrder::zyx);
  const Matrix3d other =
      (Eigen::AngleAxisd(0.3, Vector3d::UnitZ()) * Eigen::AngleAxisd(0.2, Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.1, Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_NEAR((R - other).norm(), 0, 1e-15);
}

TEST(Rotation, EulerRatesGiveTheBodyRateOfTheRotationItself) {
  const Vector3d rpy(0.3, -0.4, 1.1), rate(0.2, 0.5, -0.7);
  const double h = 1e-6;
  const auto R = [&](double t) { return from_euler(rpy + t * rate, EulerOrder::zyx); };
  const Matrix3d W = R(0).transpose() * (R(h) - R(-h)) / (2 * h);
  const Vector3d omega(W(2, 1), W(0, 2), W(1, 0));
  EXPECT_NEAR((euler_zyx_rates_to_body(rpy) * rate - omega).norm(), 0, 1e-9);
  const Matrix3d Td =
      (euler_zyx_rates_to_body(rpy + h * rate) - euler_zyx_rates_to_body(rpy - h * rate)) / (2 * h);
  EXPECT_NEAR((euler_zyx_rates_to_body_dot(rpy, rate) - Td).norm(), 0, 1e-9);
}

TEST(Rotation, QuaternionOfTheLaboratoryGivesTheMatrixOfTheLaboratory) {
  // WORLD_TO_EM8000 of the published calibration, both forms.
  const auto X = RigidTransform::from_quaternion(
      {6.0198987883e-05, 0.705931944115, 0.708279565403954, 0.000379322138596}, Vector3d::Zero());
  Matrix3d published;
  published << -0.0033201733081971, 0.9999942954954632, 0.0006208266554409, 0.9999943868346984,
      0.0033198927854635, 0.0004523394618457, 0.0004502758035388, 0.0006223250160457, -0.9999997049815943;
  EXPECT_NEAR((X.R - published).norm(), 0, 1e-8);
  EXPECT_NEAR((X.quaternion_wxyz() -
               Eigen::Vector4d(6.0198987883e-05, 0.705931944115, 0.708279565403954, 0.000379322138596))
                  .norm(),
              0, 1e-8);
}

TEST(Rotation, TransformsComposeAndInvert) {
  const RigidTransform X{from_euler({0.1, 0.2, 0.3}, EulerOrder::zyx), {1, 2, 3}};
  const RigidTransform Y{from_euler({-0.5, 0.1, 2.0}, EulerOrder::xyz), {-1, 0.5, 0.25}};
  const Vector3d p(0.3, -0.2, 0.7);
  EXPECT_NEAR((((X * Y) * p) - (X * (Y * p))).norm(), 0, 1e-12);
  EXPECT_NEAR((X.inverse() * (X * p) - p).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace motionlab::math
