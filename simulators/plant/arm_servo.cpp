#include "simulators/plant/arm_servo.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::plant {

ArmServo::ArmServo(const ArmServoConfig& config, const Joints& start_rad, double tick_s)
    : under_way_(static_cast<std::size_t>(std::lround(config.command_delay_s / tick_s)), start_rad),
      last_good_(start_rad),
      q_(start_rad) {
  axes_.reserve(q_.size());
  for (std::size_t j = 0; j < q_.size(); ++j) {
    axes_.emplace_back(config.omega_radps[j], config.zeta[j],
                       ServoLimits{config.stroke_min_rad[j], config.stroke_max_rad[j],
                                   config.speed_max_radps[j], config.acceleration_max_radps2[j]},
                       start_rad[j], tick_s);
  }
}

void ArmServo::step(const Joints& set_points_rad) {
  if (std::ranges::all_of(set_points_rad, [](double q) { return std::isfinite(q); })) {
    last_good_ = set_points_rad;
  }
  Joints arriving = last_good_;
  if (!under_way_.empty()) {
    std::swap(arriving, under_way_[oldest_]);
    oldest_ = (oldest_ + 1) % under_way_.size();
  }
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    axes_[j].step(arriving[j]);
    q_[j] = axes_[j].position();
    qd_[j] = axes_[j].speed();
  }
}

Joints ArmServo::qdd_radps2() const {
  Joints qdd{};
  for (std::size_t j = 0; j < axes_.size(); ++j) qdd[j] = axes_[j].acceleration();
  return qdd;
}

}  // namespace motionlab::plant
