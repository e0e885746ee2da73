/// @file  The winch: drive and drum between the length set point and the wire.
#pragma once

#include "simulators/plant/limited_servo.hpp"

namespace motionlab::plant {

struct WinchServoConfig {
  double omega_radps = 25.1327;
  double zeta = 0.7;
  double speed_max_mps = 2.378;
  double acceleration_max_mps2 = 3.567;
  double length_at_zero_travel_m = 1.20;
  double travel_m = 1.5;
  double wire_per_motor_rev_m = 0.0218304;
};

/// Length means what the winch's own encoder says: `length_at_zero_travel_m` plus the travel used.
class WinchServo {
 public:
  WinchServo(const WinchServoConfig& config, double start_length_m, double tick_s);

  /// Moves on by one tick. A set point that is not finite is ignored.
  void step(double length_set_point_m);

  [[nodiscard]] double length_m() const { return servo_.position(); }
  [[nodiscard]] double speed_mps() const { return servo_.speed(); }
  [[nodiscard]] double acceleration_mps2() const { return servo_.acceleration(); }
  /// Motor torque that holds a wire tension (no friction, no inertia).
  [[nodiscard]] double torque_nm(double tension_n) const;
  [[nodiscard]] unsigned long limited_ticks() const { return servo_.limited_ticks(); }

 private:
  WinchServoConfig config_;
  LimitedServo servo_;
  double last_good_;
};

}  // namespace motionlab::plant
