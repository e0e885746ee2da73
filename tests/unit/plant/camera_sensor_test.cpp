#include "simulators/plant/camera_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "simulators/plant/calibration.hpp"
#include "simulators/plant/encoder.hpp"

namespace motionlab::plant {
namespace {

using Eigen::Vector3d;

math::RigidTransform load_pose() {
  return {load_orientation({0.1, -0.2}), {0.85, -0.41, 3.92}};
}

TEST(CameraSensor, WithoutErrorsSeesThePoseInItsOwnFrame) {
  const Calibration lab;
  CameraSensor cameras(CameraConfig{}.without_errors(), lab.world_to_qtm, 1);
  const auto frame = cameras.sample(load_pose(), lab.world_to_em8000);
  ASSERT_TRUE(frame.load.tracked);
  ASSERT_TRUE(frame.platform.tracked);
  EXPECT_LT((lab.world_to_qtm * frame.load.X_QB.p - load_pose().p).norm(), 1e-12);
  EXPECT_LT(((lab.world_to_qtm * frame.load.X_QB).R - load_pose().R).norm(), 1e-12);
  EXPECT_LT((lab.world_to_qtm * frame.platform.X_QB.p - lab.world_to_em8000.p).norm(), 1e-12);
}

TEST(CameraSensor, APlatformWithoutMarkersIsNeverTracked) {
  CameraConfig c;
  c.platform_tracked = false;
  CameraSensor cameras(c, {}, 1);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(cameras.sample({}, {}).platform.tracked);
}

TEST(CameraSensor, TheLoadsAxisPointsAlongTheWire) {
  const double a = 0.12, b = -0.3;
  const Vector3d to_tool(std::sin(a), -std::cos(a) * std::sin(b), std::cos(a) * std::cos(b));
  EXPECT_LT((load_orientation({a, b}).col(2) - to_tool).norm(), 1e-15);
  EXPECT_EQ(load_orientation({0, 0}), Eigen::Matrix3d::Identity());
}

TEST(CameraSensor, ErrorsHaveTheConfiguredSizeAndCorrelation) {
  CameraConfig c;
  CameraSensor cameras(c, {}, 1);
  const int n = 100000, lag = 200;  // one correlation time
  std::vector<double> x;
  double angle2 = 0;
  for (int i = 0; i < n; ++i) {
    const auto frame = cameras.sample({}, {});
    x.push_back(frame.load.X_QB.p.x());
    angle2 += math::to_euler(frame.load.X_QB.R, math::EulerOrder::zyx).squaredNorm() / 3 / n;
  }
  double variance = 0, covariance = 0, step = 0;
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    variance += x[k] * x[k] / n;
    if (i >= lag) covariance += x[k] * x[k - lag] / (n - lag);
    if (i >= 1) step += std::pow(x[k] - x[k - 1], 2) / n;
  }
  const double white = 0.0005 / 2;
  EXPECT_NEAR(variance, 1e-6 + white * white, 0.15e-6);
  EXPECT_NEAR(covariance / 1e-6, std::exp(-1.0), 0.15);
  EXPECT_NEAR(step, 2 * white * white + 2e-6 * (1 - std::exp(-0.005)), 0.05e-7);
  EXPECT_NEAR(std::sqrt(angle2), c.angle_noise_rms_rad, 0.01 * c.angle_noise_rms_rad);
}

TEST(CameraSensor, LosesBodiesAsOftenAndAsLongAsConfigured) {
  CameraConfig c;
  c.dropouts_per_minute = 6;
  c.dropout_s = 0.5;
  CameraSensor cameras(c, {}, 1);
  const int n = 200000;
  int lost = 0;
  for (int i = 0; i < n; ++i) {
    const auto frame = cameras.sample({}, {});
    if (frame.load.tracked) continue;
    ++lost;
    EXPECT_EQ(frame.load.X_QB.p.norm(), 0) << "a lost body has no pose";
  }
  EXPECT_NEAR(static_cast<double>(lost) / n, 0.05, 0.015);
}

TEST(Encoders, RoundToTheirQuantum) {
  JointEncoders encoders(
      {.joint_noise_rms_rad = 0, .joint_quantum_rad = 1e-5, .joint_speed_noise_rms_radps = 0}, 1);
  const auto r = encoders.read({0.1234567, 0, -1.5707963, 0, 0, 0}, {0.5, 0, 0, 0, 0, 0});
  EXPECT_NEAR(r.q_rad[0], 0.12346, 1e-12);
  EXPECT_NEAR(r.q_rad[2], -1.57080, 1e-12);
  EXPECT_EQ(r.qd_radps[0], 0.5);
}

}  // namespace
}  // namespace motionlab::plant
