// What runs in the control cycle takes nothing from the heap.
#include <gtest/gtest.h>

#include "gateway/math/euler_rates.hpp"
#include "gateway/math/integrate.hpp"
#include "gateway/math/kalman.hpp"
#include "gateway/math/pendulum.hpp"
#include "tests/support/malloc_calls.hpp"
#include "tests/unit/math/arms.hpp"

namespace motionlab::math {
namespace {

using Eigen::Vector4d;

template <class Work>
void expect_no_allocation(const Work& work) {
  if (!MOTIONLAB_COUNTS_MALLOC) GTEST_SKIP() << "a sanitizer owns malloc";
  work();
  const std::size_t before = test::malloc_calls;
  work();
  EXPECT_EQ(test::malloc_calls, before);
}

TEST(NoAllocation, IsCountedAtAll) {
  if (!MOTIONLAB_COUNTS_MALLOC) GTEST_SKIP() << "a sanitizer owns malloc";
  const std::size_t before = test::malloc_calls;
  volatile Eigen::Index size = 100;  // unknown to the compiler, or it would drop the vector
  Eigen::VectorXd v(size);
  v.setOnes();
  EXPECT_EQ(v.sum(), 100);
  EXPECT_GT(test::malloc_calls, before);
}

TEST(NoAllocation, InTheKinematics) {
  const auto chain = test::six_axis_arm(0.5);
  const auto crane = test::crane_arm();
  Eigen::Matrix<double, 6, 1> q, qd;
  q << 0.1, 0.2, -1.4, 0.3, 0.7, -0.2;
  qd << 1, 2, 3, 4, 5, 6;
  double sum = 0;
  expect_no_allocation([&] {
    sum += chain.frames(q)[6].p.x() + chain.jacobian(q).sum() + chain.jacobian_dot(q, qd).sum() +
           chain.acceleration(q, qd, qd).sum() + chain.inverse(chain.tool(q), q + 0.01 * qd).q.sum() +
           crane.inverse(crane.position(q.head<3>()), test::strokes()).best()->sum();
    sum += body_turn({{0.1, 0.2, 0.3}, {1, 2, 3}, {4, 5, 6}}, EulerOrder::xyz).alpha_radps2.sum();
  });
  EXPECT_TRUE(std::isfinite(sum));
}

TEST(NoAllocation, InAFilterOfThirtyFiveStates) {
  using Vector = Eigen::Matrix<double, 35, 1>;
  using Matrix = Eigen::Matrix<double, 35, 35>;
  KalmanState<35> state;
  state.P.setIdentity();
  const Matrix F = Matrix::Identity() + 1e-3 * Matrix::Ones(), Q = 1e-3 * Matrix::Identity();
  const Eigen::Matrix<double, 23, 35> H = Eigen::Matrix<double, 23, 35>::Identity();
  const Eigen::Matrix<double, 23, 1> innovation = Eigen::Matrix<double, 23, 1>::Constant(0.1);
  const Eigen::Matrix<double, 23, 1> variances = Eigen::Matrix<double, 23, 1>::Constant(0.01);
  const Eigen::Matrix<double, 23, 23> R = variances.asDiagonal();
  expect_no_allocation([&] {
    predict_extended<35>(state, Vector(F * state.x), F, Q);
    EXPECT_TRUE((update<35, 23>(state, H, innovation, R)));
    EXPECT_EQ((update_row_by_row<35, 23>(state, H, innovation, variances)), 23);
  });
}

TEST(NoAllocation, InTheIntegrators) {
  const auto swing = [](double, const Vector4d& s) -> Vector4d {
    Vector4d d;
    d << s.tail<2>(),
        swing_acceleration<double>(s.head<2>(), s.tail<2>(), Vector3d(0.1, 0.2, 0.3), 2.0, 0.0, 9.81);
    return d;
  };
  const Vector4d start(0.2, 0.3, 0, 0);
  double sum = 0;
  expect_no_allocation([&] {
    sum += rk4<Vector4d>(swing, 0.0, start, 0.1, 10).sum() +
           stiff_step<Vector4d>(swing, 0.0, start, 0.01).x.sum() +
           integrate_stiff<Vector4d>(swing, 0.0, start, 0.1).x.sum();
    sum += swing_jacobian({0.1, 0.2}, {0.3, 0.4}, {1, 2, 3}, 2, 0.1, 9.81).sum();
  });
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace motionlab::math
