/// @file  The six joints of the crane arm: servo loops behind a command delay.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "simulators/plant/limited_servo.hpp"

namespace motionlab::plant {

using Joints = std::array<double, 6>;

struct ArmServoConfig {
  Joints omega_radps{25.1327, 25.1327, 25.1327, 25.1327, 25.1327, 25.1327};
  Joints zeta{0.7, 0.7, 0.7, 0.7, 0.7, 0.7};
  double command_delay_s = 0.0024;  ///< rounded to whole ticks
  Joints stroke_min_rad{-3.14159265, -1.30899694, -4.46804289, -4.88692191, -2.0943951, -47.1238898};
  Joints stroke_max_rad{3.14159265, 1.65806279, -0.174532925, 4.88692191, 2.0943951, 47.1238898};
  Joints speed_max_radps{1.91986218, 1.91986218, 1.91986218, 3.31612558, 3.31612558, 4.01425728};
  Joints acceleration_max_radps2{10, 10, 10, 10, 10, 10};
};

/// Joint values are Comau values (joint 3 against the vertical). One `step` is one tick.
class ArmServo {
 public:
  ArmServo(const ArmServoConfig& config, const Joints& start_rad, double tick_s);

  /// Takes the set points that leave the robot PC at this tick and moves the joints on by one tick with those
  /// that left it `command_delay_s` ago. Values that are not finite are ignored: the last good ones stay.
  void step(const Joints& set_points_rad);

  [[nodiscard]] const Joints& q_rad() const { return q_; }
  [[nodiscard]] const Joints& qd_radps() const { return qd_; }
  [[nodiscard]] Joints qdd_radps2() const;
  [[nodiscard]] unsigned long limited_ticks(std::size_t joint) const { return axes_[joint].limited_ticks(); }

 private:
  std::vector<LimitedServo> axes_;
  std::vector<Joints> under_way_;  ///< ring of set points not yet arrived; empty without a delay
  std::size_t oldest_ = 0;
  Joints last_good_;
  Joints q_;
  Joints qd_{};
};

}  // namespace motionlab::plant
