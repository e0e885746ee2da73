#include "simulators/comau/comau_device_set_point.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::comau {
namespace {

/// The greatest speed towards an edge at this distance.
double speed_bound(double distance, double qd_max, double deceleration, double cycle_s) noexcept {
  return std::min({qd_max, std::sqrt(2.0 * deceleration * std::max(0.0, distance)), distance / cycle_s});
}

}  // namespace

void SetPoint::synchronise(const Joints& q_measured_rad) noexcept {
  q_rad_ = q_measured_rad;
  qd_radps_.fill(0.0);
}

void SetPoint::integrate(const Joints& qd_wanted_radps) noexcept {
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double a = config_.deceleration_radps2;
    const double upper =
        speed_bound(config_.q_max_rad[i] - q_rad_[i], config_.qd_max_radps[i], a, config_.cycle_s);
    const double lower =
        -speed_bound(q_rad_[i] - config_.q_min_rad[i], config_.qd_max_radps[i], a, config_.cycle_s);
    qd_radps_[i] = std::fmin(upper, std::fmax(lower, qd_wanted_radps[i]));
    q_rad_[i] =
        std::clamp(q_rad_[i] + qd_radps_[i] * config_.cycle_s, config_.q_min_rad[i], config_.q_max_rad[i]);
  }
}

Joints SetPoint::approached(const Joints& qd_wanted_radps, const Joints& acceleration_radps2) const noexcept {
  Joints nearer = qd_radps_;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double step = acceleration_radps2[i] * config_.cycle_s;
    nearer[i] += std::clamp(qd_wanted_radps[i] - nearer[i], -step, step);
  }
  return nearer;
}

}  // namespace motionlab::comau
