#include "simulators/plant/mru_sensor.hpp"

#include <cmath>
#include <numbers>

namespace motionlab::plant {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// The level frame, z down, whose x axis points where N's does.
Matrix3d levelled(const Matrix3d& R_WN) {
  const Vector3d down(0, 0, -1);
  const Vector3d x = (R_WN.col(0) - R_WN.col(0).dot(down) * down).normalized();
  Matrix3d R;
  R << x, down.cross(x), down;
  return R;
}

double wrapped(double angle_rad) {
  return angle_rad - kTwoPi * std::round(angle_rad / kTwoPi);
}

}  // namespace

MruConfig MruConfig::second_ship() {
  MruConfig c;
  c.misalignment_rad.setZero();
  c.lever_to_origin_m = {-0.513, 0.0, 0.169};
  return c;
}

MruConfig MruConfig::with_white_noise_only() const {
  MruConfig c = *this;
  c.roll_pitch_rms_rad = 0;
  c.roll_pitch_white_rms_rad = 0.005 * kDegree;
  c.yaw_walk_rad_per_sqrt_s = 0;
  c.acceleration_bias_mps2.setZero();
  return c;
}

MruConfig MruConfig::with_noise_times(double factor) const {
  MruConfig c = *this;
  c.roll_pitch_rms_rad *= factor;
  c.roll_pitch_white_rms_rad *= factor;
  c.yaw_walk_rad_per_sqrt_s *= factor;
  c.rate_noise_rms_radps *= factor;
  c.acceleration_noise_rms_mps2 *= factor;
  return c;
}

MruConfig MruConfig::without_errors() const {
  MruConfig c = with_white_noise_only();
  c.roll_pitch_white_rms_rad = 0;
  c.rate_noise_rms_radps = 0;
  c.acceleration_noise_rms_mps2 = 0;
  return c;
}

MruSensor::MruSensor(const MruConfig& config, const math::RigidTransform& X_WN,
                     const math::RigidTransform& X_BM, std::uint64_t seed, std::string_view name)
    : config_(config),
      R_WD_(levelled(X_WN.R)),
      p_WN_(X_WN.p),
      X_BM_{X_BM.R * math::from_euler(config.misalignment_rad, math::EulerOrder::zyx), X_BM.p},
      random_(seed, name),
      roll_error_(config.roll_pitch_rms_rad, config.roll_pitch_correlation_s, config.period_s, random_),
      pitch_error_(config.roll_pitch_rms_rad, config.roll_pitch_correlation_s, config.period_s, random_),
      surge_sway_(kTwoPi / config.surge_sway_period_s, config.surge_sway_damping, 1.0, config.period_s),
      heave_(kTwoPi / config.heave_period_s, config.heave_damping, 1.0, config.period_s) {}

void MruSensor::settle(HighPassed& point, const Vector3d& a) const {
  const double ws = kTwoPi / config_.surge_sway_period_s, wh = kTwoPi / config_.heave_period_s;
  point.x = {a.x() / (ws * ws), 0};
  point.y = {a.y() / (ws * ws), 0};
  point.z = {a.z() / (wh * wh), 0};
  point.last_a = a;
}

void MruSensor::filter(HighPassed& point, const Vector3d& a) const {
  point.x = surge_sway_.step(point.x, point.last_a.x(), a.x());
  point.y = surge_sway_.step(point.y, point.last_a.y(), a.y());
  point.z = heave_.step(point.z, point.last_a.z(), a.z());
  point.last_a = a;
}

MruReading MruSensor::sample(const PlatformState& platform) {
  // What is so, at the unit and in its axes.
  const PointMotion here = point_of(platform, X_BM_.p);
  const Matrix3d R_DM = R_WD_.transpose() * platform.X_WB.R * X_BM_.R;
  const Vector3d omega_M = X_BM_.R.transpose() * platform.omega_WB_B;
  const Vector3d alpha_M = X_BM_.R.transpose() * platform.alpha_WB_B;
  const Vector3d gravity_D(0, 0, config_.gravity_mps2);
  const Vector3d force_M = R_DM.transpose() * (R_WD_.transpose() * here.a_W - gravity_D);

  // What the gyros and the vertical say.
  MruReading r;
  const Vector3d roll_pitch_error(
      roll_error_.step(random_) + config_.roll_pitch_white_rms_rad * random_.normal(),
      pitch_error_.step(random_) + config_.roll_pitch_white_rms_rad * random_.normal(), 0);
  yaw_error_rad_ += config_.yaw_walk_rad_per_sqrt_s * std::sqrt(config_.period_s) * random_.normal();
  const Vector3d true_euler = math::to_euler(R_DM, math::EulerOrder::zyx);
  r.euler_rad = true_euler + roll_pitch_error;
  r.euler_rad.z() = wrapped(r.euler_rad.z() + yaw_error_rad_);
  r.omega_M_radps = omega_M + config_.rate_noise_rms_radps * normal3(random_);
  const Matrix3d R_HM = math::rot_y(r.euler_rad.y()) * math::rot_x(r.euler_rad.x());
  const Matrix3d R_LH = math::rot_z(r.euler_rad.z());  // L: level, follows the drift of yaw only
  r.omega_down_radps = (R_HM * r.omega_M_radps).z();

  // What the accelerometers say, and how the unit carries it over to the platform's origin.
  const Vector3d noise = config_.acceleration_noise_rms_mps2 * normal3(random_);
  const Vector3d& lever = config_.lever_to_origin_m;
  const Vector3d over_M = alpha_M.cross(lever) + r.omega_M_radps.cross(r.omega_M_radps.cross(lever));
  const Vector3d a_unit_H = R_HM * (force_M + noise) + gravity_D;
  const Vector3d a_origin_H = a_unit_H + R_HM * over_M;
  const Vector3d bias_H = R_HM * config_.acceleration_bias_mps2;
  r.a_unit_M_mps2 = R_HM.transpose() * (a_unit_H + bias_H);
  r.a_origin_H_mps2 = a_origin_H + bias_H;

  if (!config_.high_pass) {
    r.v_unit_M_mps = R_DM.transpose() * (R_WD_.transpose() * here.v_W);
    r.p_origin_H_m = R_LH.transpose() * (R_WD_.transpose() * (platform.X_WB.p - p_WN_));
    r.v_origin_H_mps = R_LH.transpose() * (R_WD_.transpose() * platform.v_WB);
    return r;
  }
  if (!settled_) {
    // It has stood still until now: the only acceleration it ever felt is gravity on a wrong vertical.
    const Vector3d leak = R_LH * (R_HM * (R_DM.transpose() * -gravity_D) + gravity_D);
    settle(unit_, leak);
    settle(origin_, leak);
    settled_ = true;
  } else {
    filter(unit_, R_LH * a_unit_H);
    filter(origin_, R_LH * a_origin_H);
  }
  r.v_unit_M_mps = R_HM.transpose() * (R_LH.transpose() * unit_.v());
  r.p_origin_H_m = R_LH.transpose() * origin_.p();
  r.v_origin_H_mps = R_LH.transpose() * origin_.v();
  return r;
}

}  // namespace motionlab::plant
