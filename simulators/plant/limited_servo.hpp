/// @file  A position loop with limits: what a drive makes of its set point.
#pragma once

#include "simulators/plant/second_order.hpp"

namespace motionlab::plant {

/// Numbers of one servo axis; its unit of position is rad or m.
struct ServoLimits {
  double position_min = 0;
  double position_max = 0;
  double speed_max = 0;
  double acceleration_max = 0;
};

/// Second-order position loop x'' = w² (u − x) − 2 zeta w x', exact over the tick while no limit acts.
///
/// A limited acceleration is held for the tick; speed and position are then clipped. At a position limit the
/// axis stands (an end stop without bounce).
class LimitedServo {
 public:
  LimitedServo(double omega_radps, double zeta, const ServoLimits& limits, double start, double tick_s);

  /// Moves on by one tick with the set point held.
  void step(double set_point);

  [[nodiscard]] double position() const { return state_.x; }
  [[nodiscard]] double speed() const { return state_.v; }
  /// What the loop asks for now with the set point of the last tick, within the limit.
  [[nodiscard]] double acceleration() const;
  /// Ticks in which a limit changed the motion.
  [[nodiscard]] unsigned long limited_ticks() const { return limited_ticks_; }

 private:
  double omega_, zeta_;
  ServoLimits limits_;
  double tick_s_;
  SecondOrder loop_;
  SecondOrder::State state_;
  double set_point_;
  unsigned long limited_ticks_ = 0;
};

}  // namespace motionlab::plant
