#include "gateway/math/euler_rates.hpp"

#include <gtest/gtest.h>

#include "drivers/core/random.hpp"
#include "gateway/math/moving_base.hpp"
#include "tests/unit/math/complex_pose.hpp"
#include "tests/unit/math/golden.hpp"

namespace motionlab::math {
namespace {

using test::Complex;
using test::Mat3;
template <class S>
using Vec3 = Eigen::Matrix<S, 3, 1>;

template <class S>
Mat3<S> rotation(const Vec3<S>& rpy, EulerOrder order) {
  const Mat3<S> X = test::turn_x<S>(rpy[0]), Y = test::turn_y<S>(rpy[1]), Z = test::turn_z<S>(rpy[2]);
  return order == EulerOrder::zyx ? Mat3<S>(Z * Y * X) : Mat3<S>(X * Y * Z);
}

/// E from its meaning: each Euler rate turns about the axis that the later turns leave it, seen in the body.
template <class S>
Mat3<S> rates_to_body(const Vec3<S>& rpy, EulerOrder order) {
  const Mat3<S> X = test::turn_x<S>(rpy[0]), Y = test::turn_y<S>(rpy[1]), Z = test::turn_z<S>(rpy[2]);
  Mat3<S> E;
  if (order == EulerOrder::zyx) {
    E << Vec3<S>::UnitX(), X.transpose() * Vec3<S>::UnitY(),
        X.transpose() * (Y.transpose() * Vec3<S>::UnitZ());
  } else {
    E << Z.transpose() * (Y.transpose() * Vec3<S>::UnitX()), Z.transpose() * Vec3<S>::UnitY(),
        Vec3<S>::UnitZ();
  }
  return E;
}

Vector3d random_angles(Random& random) {
  return {random.uniform(-3, 3), random.uniform(-1.4, 1.4), random.uniform(-3, 3)};
}
Vector3d random_vector(Random& random) {
  return {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
}

class EulerRates : public testing::TestWithParam<EulerOrder> {};

TEST_P(EulerRates, AreTheBodyRateOfTheRotationByComplexStep) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Vector3d rpy = random_angles(random), rate = random_vector(random);
    const Vec3<Complex> moved = rpy.cast<Complex>() + Complex(0, test::kStep) * rate.cast<Complex>();
    const Matrix3d dR = rotation<Complex>(moved, GetParam()).imag() / test::kStep;
    const Matrix3d R = rotation<double>(rpy, GetParam());
    EXPECT_LT((from_euler(rpy, GetParam()) - R).norm(), 1e-15);
    EXPECT_LT((euler_rates_to_body(rpy, GetParam()) * rate - test::unhat(R.transpose() * dR)).norm(), 1e-14);
  }
}

TEST_P(EulerRates, ChangeAsTheComplexStepSays) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    const Vector3d rpy = random_angles(random), rate = random_vector(random);
    const Vec3<Complex> moved = rpy.cast<Complex>() + Complex(0, test::kStep) * rate.cast<Complex>();
    const Matrix3d expected = rates_to_body<Complex>(moved, GetParam()).imag() / test::kStep;
    EXPECT_LT((euler_rates_to_body(rpy, GetParam()) - rates_to_body<double>(rpy, GetParam())).norm(), 1e-14);
    EXPECT_LT((euler_rates_to_body_dot(rpy, rate, GetParam()) - expected).norm(), 1e-14);
  }
}

TEST_P(EulerRates, InverseAndItsDerivativeFollow) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector3d rpy = random_angles(random), rate = random_vector(random);
    const auto T = body_to_euler_rates(rpy, GetParam());
    ASSERT_TRUE(T);
    EXPECT_LT((*T * euler_rates_to_body(rpy, GetParam()) - Matrix3d::Identity()).norm(), 1e-13);
    const Vec3<Complex> moved = rpy.cast<Complex>() + Complex(0, test::kStep) * rate.cast<Complex>();
    const Matrix3d expected = rates_to_body<Complex>(moved, GetParam()).inverse().imag() / test::kStep;
    EXPECT_LT((*body_to_euler_rates_dot(rpy, rate, GetParam()) - expected).norm(),
              1e-11 * (1 + expected.norm()));
  }
}

TEST_P(EulerRates, BodyTurnAndEulerMotionUndoEachOther) {
  Random random(4);
  for (int i = 0; i < 200; ++i) {
    const EulerMotion motion{random_angles(random), random_vector(random), random_vector(random)};
    const auto back = euler_motion(motion.rpy_rad, body_turn(motion, GetParam()), GetParam());
    ASSERT_TRUE(back);
    EXPECT_LT((back->rate_radps - motion.rate_radps).norm(), 1e-13);
    EXPECT_LT((back->acceleration_radps2 - motion.acceleration_radps2).norm(), 1e-11);
  }
}

TEST_P(EulerRates, NearTheSingularPitchThereAreNone) {
  const BodyTurn turn{{0.1, 0.2, 0.3}, {0, 0, 0}};
  for (const double pitch :
       {test::kStep + std::acos(0.0), -std::acos(0.0), std::acos(0.5e-4), std::nan("")}) {
    const Vector3d rpy(0.3, pitch, -0.2);
    EXPECT_FALSE(body_to_euler_rates(rpy, GetParam()));
    EXPECT_FALSE(body_to_euler_rates_dot(rpy, rpy, GetParam()));
    EXPECT_FALSE(euler_motion(rpy, turn, GetParam()));
  }
  EXPECT_TRUE(euler_motion({0.3, std::acos(2e-4), -0.2}, turn, GetParam()));
  EXPECT_FALSE(euler_motion({0.3, std::acos(2e-4), -0.2}, turn, GetParam(), 1e-3));
}

TEST_P(EulerRates, GiveTheGoldenPlatformVectors) {
  const auto stewart = test::golden("thesis_platform.json").at("stewart");
  for (const auto& golden : stewart.at(GetParam() == EulerOrder::zyx ? "zyx" : "xyz")) {
    const auto eta = test::fixed<6>(golden.at("eta")), rate = test::fixed<6>(golden.at("eta_t"));
    const auto acceleration = test::fixed<6>(golden.at("eta_tt")), v = test::fixed<6>(golden.at("v")),
               v_dot = test::fixed<6>(golden.at("v_t"));
    const Vector3d rpy = eta.tail<3>();
    const Matrix3d R = from_euler(rpy, GetParam());
    EXPECT_LT(test::deviation(R, test::matrix(golden.at("R_nb"))), 1e-10);
    EXPECT_LT(test::deviation(*body_to_euler_rates(rpy, GetParam()), test::matrix(golden.at("T"))), 1e-10);
    const BodyTurn turn = body_turn({rpy, rate.tail<3>(), acceleration.tail<3>()}, GetParam());
    EXPECT_LT(test::deviation(turn.omega_radps, v.tail<3>()), 1e-10);
    EXPECT_LT(test::deviation(turn.alpha_radps2, v_dot.tail<3>()), 1e-10);
    EXPECT_LT(test::deviation(rate.head<3>(), v.head<3>()), 1e-10);
    EXPECT_LT(test::deviation(acceleration.head<3>(), v_dot.head<3>()), 1e-10);
    const Matrix3d Rd = R * hat(turn.omega_radps);
    EXPECT_LT(test::deviation(Rd, test::matrix(golden.at("R_t"))), 1e-10);
    EXPECT_LT(test::deviation(Rd * hat(turn.omega_radps) + R * hat(turn.alpha_radps2),
                              test::matrix(golden.at("R_tt"))),
              1e-10);
    const auto back = euler_motion(rpy, {v.tail<3>(), v_dot.tail<3>()}, GetParam());
    ASSERT_TRUE(back);
    EXPECT_LT(test::deviation(back->rate_radps, rate.tail<3>()), 1e-10);
    EXPECT_LT(test::deviation(back->acceleration_radps2, acceleration.tail<3>()), 1e-10);
  }
}

INSTANTIATE_TEST_SUITE_P(BothOrders, EulerRates, testing::Values(EulerOrder::zyx, EulerOrder::xyz),
                         [](const testing::TestParamInfo<EulerOrder>& order) {
                           return order.param == EulerOrder::zyx ? "zyx" : "xyz";
                         });

TEST(EulerRates, AsPrintedInEquation375AreWrong) {
  // J' eta' in place of J' v, on a motion rougher than the wave of Tab 4.4.
  const EulerMotion motion{{0.3, -0.35, 0.2}, {0.9, -0.8, 1.1}, {0.5, 0.4, -0.6}};
  const Matrix3d T = *body_to_euler_rates(motion.rpy_rad, EulerOrder::zyx);
  const Matrix3d Td = *body_to_euler_rates_dot(motion.rpy_rad, motion.rate_radps, EulerOrder::zyx);
  const BodyTurn right = body_turn(motion, EulerOrder::zyx);
  const Vector3d corrected = T.inverse() * (motion.acceleration_radps2 - Td * right.omega_radps);
  const Vector3d printed = T.inverse() * (motion.acceleration_radps2 - Td * motion.rate_radps);
  EXPECT_LT((corrected - right.alpha_radps2).norm(), 1e-12);
  EXPECT_GT((printed - right.alpha_radps2).norm(), 0.1);
}

TEST(ToolOnPlatform, MovesAsTheGoldenVectorsSay) {
  const auto golden = test::golden("thesis_platform.json");
  const Eigen::Matrix4d Hbr = test::fixed<4, 4>(golden.at("Hbr_printed"));
  const Matrix3d printed = Hbr.topLeftCorner<3, 3>();
  const Matrix3d projected = nearest_rotation(printed);
  EXPECT_LT((projected - test::fixed<3, 3>(golden.at("Rbr_projected_to_SO3"))).norm(), 1e-12);
  const Matrix3d R_WN = test::fixed<3, 3>(golden.at("R_gn"));
  for (const auto& row : golden.at("toolpoint_on_platform")) {
    const auto eta = test::fixed<6>(row.at("eta")), v = test::fixed<6>(row.at("v")),
               v_dot = test::fixed<6>(row.at("v_t"));
    // v is mixed: its linear part is dP/dt in N, its angular part the body's own rate.
    const BodyMotion body{{from_euler(eta.tail<3>(), EulerOrder::zyx), eta.head<3>()},
                          v.head<3>(),
                          v_dot.head<3>(),
                          v.tail<3>(),
                          v_dot.tail<3>()};
    for (const auto& [name, R_BR] :
         {std::pair("projected Rbr", projected), std::pair("printed Rbr", printed)}) {
      const PointMotion in_B{R_BR * test::fixed<3>(row.at("p")) + Hbr.topRightCorner<3, 1>(),
                             R_BR * test::fixed<3>(row.at("p_t")), R_BR * test::fixed<3>(row.at("p_tt"))};
      const PointMotion in_N = carried(body, in_B);
      EXPECT_LT(test::deviation(in_N.p, test::matrix(row.at(name).at("P_n"))), 1e-10);
      EXPECT_LT(test::deviation(in_N.v, test::matrix(row.at(name).at("P_n_t"))), 1e-10);
      EXPECT_LT(test::deviation(in_N.a, test::matrix(row.at(name).at("P_n_tt"))), 1e-10);
      if (!row.at(name).contains("P_g")) continue;  // in the world with the projected calibration only
      EXPECT_LT(test::deviation(R_WN * in_N.p, test::matrix(row.at(name).at("P_g"))), 1e-10);
      EXPECT_LT(test::deviation(R_WN * in_N.v, test::matrix(row.at(name).at("P_g_t"))), 1e-10);
      EXPECT_LT(test::deviation(R_WN * in_N.a, test::matrix(row.at(name).at("P_g_tt"))), 1e-10);
    }
  }
}

}  // namespace
}  // namespace motionlab::math
