#include "simulators/plant/camera_sensor.hpp"

#include <cmath>

namespace motionlab::plant {

using Eigen::Vector3d;

CameraConfig CameraConfig::without_errors() const {
  CameraConfig c = *this;
  c.marker_noise_rms_m = 0;
  c.correlated_rms_m = 0;
  c.angle_noise_rms_rad = 0;
  c.dropouts_per_minute = 0;
  return c;
}

Eigen::Matrix3d load_orientation(const Eigen::Vector2d& swing_rad) {
  return math::rot_x(swing_rad[1]) * math::rot_y(swing_rad[0]);
}

CameraSensor::CameraSensor(const CameraConfig& config, const math::RigidTransform& X_WQ, std::uint64_t seed)
    : config_(config),
      X_QW_(X_WQ.inverse()),
      random_(seed, "cameras"),
      load_(body(config.load_markers)),
      platform_(body(config.platform_markers)) {}

CameraSensor::Body CameraSensor::body(int markers) {
  const auto slow = [this] {
    return GaussMarkov(config_.correlated_rms_m, config_.correlation_s, config_.period_s, random_);
  };
  return {config_.marker_noise_rms_m / std::sqrt(static_cast<double>(markers)), {slow(), slow(), slow()}, 0};
}

CameraSensor::Frame CameraSensor::sample(const math::RigidTransform& X_WL, const math::RigidTransform& X_WB) {
  Frame frame;
  frame.load = see(load_, X_WL);
  const BodyReading platform = see(platform_, X_WB);
  if (config_.platform_tracked) frame.platform = platform;
  return frame;
}

BodyReading CameraSensor::see(Body& body, const math::RigidTransform& X_WB) {
  Vector3d error = body.white_rms_m * normal3(random_);
  for (int i = 0; i < 3; ++i) error[i] += body.slow[static_cast<std::size_t>(i)].step(random_);
  const Vector3d turn = config_.angle_noise_rms_rad * normal3(random_);
  const double chance = config_.dropouts_per_minute * config_.period_s / 60;
  const bool drops = random_.uniform() < chance;
  if (drops) body.hidden_frames = static_cast<int>(std::lround(config_.dropout_s / config_.period_s));
  if (body.hidden_frames > 0) {
    --body.hidden_frames;
    return {};
  }
  BodyReading reading;
  reading.tracked = true;
  reading.X_QB = X_QW_ * X_WB;
  reading.X_QB.p += error;
  reading.X_QB.R = reading.X_QB.R * math::from_euler(turn, math::EulerOrder::zyx);
  reading.residual_m = config_.marker_noise_rms_m;
  return reading;
}

}  // namespace motionlab::plant
