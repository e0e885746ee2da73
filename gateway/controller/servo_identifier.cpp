#include "gateway/controller/servo_identifier.hpp"

#include <algorithm>

namespace motionlab::controller {

ServoIdentifier::ServoIdentifier(const ServoBelief& servo, const ServoIdentifierConfig& config)
    : belief_(servo.omega_radps),
      zeta_(servo.zeta),
      config_(config),
      omega_(Vector3d::Constant(servo.omega_radps)),
      information_(Vector3d::Constant(config.caution)) {}

void ServoIdentifier::restart(const Vector3d& q, const Vector3d& qd) {
  q_ = q;
  qd_ = qd;
  lag_ = 2 * zeta_ * qd.cwiseQuotient(omega_);  // as if it had moved like this for long
  lag_by_ = qd_by_ = slow_error_ = slow_by_ = Vector3d::Zero();
}

void ServoIdentifier::advance(const Vector3d& moved, double dt) {
  for (int j = 0; j < 3; ++j) {
    const double w = omega_[j];
    const double qdd = w * w * (lag_[j] + 0.5 * moved[j]) - 2 * zeta_ * w * qd_[j];
    const double qdd_by = 2 * w * lag_[j] + w * w * lag_by_[j] - 2 * zeta_ * (qd_[j] + w * qd_by_[j]);
    const double turned = dt * qd_[j] + 0.5 * dt * dt * qdd;
    q_[j] += turned;
    lag_[j] += moved[j] - turned;
    lag_by_[j] -= dt * qd_by_[j] + 0.5 * dt * dt * qdd_by;
    qd_[j] += dt * qdd;
    qd_by_[j] += dt * qdd_by;
  }
}

void ServoIdentifier::measured(const Vector3d& q, double span) {
  if (config_.memory_s <= 0 || span <= 0) return;
  const double least = belief_ / config_.most_factor, most = belief_ * config_.most_factor;
  for (int j = 0; j < 3; ++j) {
    const double error = q[j] - q_[j], by = -lag_by_[j];
    slow_error_[j] += span / config_.washout_s * (error - slow_error_[j]);
    slow_by_[j] += span / config_.washout_s * (by - slow_by_[j]);
    const double y = error - slow_error_[j], psi = by - slow_by_[j];
    information_[j] += span * (psi * psi - information_[j] / config_.memory_s);
    information_[j] = std::max(information_[j], config_.caution);
    omega_[j] = std::clamp(omega_[j] + span * psi * y / information_[j], least, most);
  }
}

}  // namespace motionlab::controller
