#include "gateway/controller/smooth_point.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::controller {

void SmoothPoint::reset(const Vector3d& p) {
  p_ = p;
  v_.setZero();
  a_.setZero();
}

void SmoothPoint::step(double dt, const Vector3d& p_target, const Vector3d& v_target) {
  const auto& l = limits_;
  for (Eigen::Index i = 0; i < 3; ++i) {
    // The speed towards the target from which it can still be braked softly: linear near it, by the square
    // root of the distance further out, with half of the acceleration kept for building the brake up within
    // the jerk.
    const double distance = p_target[i] - p_[i];
    const double linear = l.omega_radps * std::abs(distance) / 2;
    const double braking = std::sqrt(l.acceleration_mps2 * std::abs(distance));
    const double approach = std::copysign(std::min({linear, braking, l.speed_mps}), distance);
    // What the speed will be once the acceleration has been taken back within the jerk.
    const double coming = v_[i] + a_[i] * std::abs(a_[i]) / (2 * l.jerk_mps3);
    const double wanted = std::clamp(4 * l.omega_radps * (v_target[i] + approach - coming),
                                     -l.acceleration_mps2, l.acceleration_mps2);
    a_[i] += std::clamp(wanted - a_[i], -l.jerk_mps3 * dt, l.jerk_mps3 * dt);
    p_[i] += dt * v_[i] + 0.5 * dt * dt * a_[i];
    v_[i] += dt * a_[i];
  }
}

}  // namespace motionlab::controller
