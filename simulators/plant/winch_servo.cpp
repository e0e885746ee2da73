#include "simulators/plant/winch_servo.hpp"

#include <cmath>
#include <numbers>

namespace motionlab::plant {

WinchServo::WinchServo(const WinchServoConfig& config, double start_length_m, double tick_s)
    : config_(config),
      servo_(config.omega_radps, config.zeta,
             ServoLimits{config.length_at_zero_travel_m, config.length_at_zero_travel_m + config.travel_m,
                         config.speed_max_mps, config.acceleration_max_mps2},
             start_length_m, tick_s),
      last_good_(start_length_m) {}

void WinchServo::step(double length_set_point_m) {
  if (std::isfinite(length_set_point_m)) last_good_ = length_set_point_m;
  servo_.step(last_good_);
}

double WinchServo::torque_nm(double tension_n) const {
  return tension_n * config_.wire_per_motor_rev_m / (2 * std::numbers::pi);
}

}  // namespace motionlab::plant
