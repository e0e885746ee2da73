#include "simulators/plant/limited_servo.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::plant {

LimitedServo::LimitedServo(double omega, double zeta, const ServoLimits& limits, double start, double tick_s)
    : omega_(omega),
      zeta_(zeta),
      limits_(limits),
      tick_s_(tick_s),
      loop_(omega, zeta, omega * omega, tick_s),
      state_{start, 0},
      set_point_(start) {}

void LimitedServo::step(double set_point) {
  set_point_ = set_point;
  SecondOrder::State next = loop_.step(state_, set_point, set_point);
  bool limited = false;
  const double a_max = limits_.acceleration_max;
  if (const double a = (next.v - state_.v) / tick_s_; std::abs(a) > a_max) {
    const double clipped = std::copysign(a_max, a);
    next = {state_.x + tick_s_ * (state_.v + 0.5 * tick_s_ * clipped), state_.v + tick_s_ * clipped};
    limited = true;
  }
  if (std::abs(next.v) > limits_.speed_max) {
    next.v = std::copysign(limits_.speed_max, next.v);
    next.x = state_.x + 0.5 * tick_s_ * (state_.v + next.v);
    limited = true;
  }
  if (next.x < limits_.position_min || next.x > limits_.position_max) {
    next = {std::clamp(next.x, limits_.position_min, limits_.position_max), 0};
    limited = true;
  }
  state_ = next;
  limited_ticks_ += limited ? 1 : 0;
}

double LimitedServo::acceleration() const {
  const double a = omega_ * omega_ * (set_point_ - state_.x) - 2 * zeta_ * omega_ * state_.v;
  return std::clamp(a, -limits_.acceleration_max, limits_.acceleration_max);
}

}  // namespace motionlab::plant
