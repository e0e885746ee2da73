/// @file  x'' + 2 zeta w x' + w² x = gain u, stepped exactly.
#pragma once

namespace motionlab::plant {

/// The exact step of a linear second-order system over a fixed time, for an input that is a straight line
/// inside the step (constant: give the same value twice).
class SecondOrder {
 public:
  struct State {
    double x = 0;
    double v = 0;
  };

  SecondOrder(double omega_radps, double zeta, double gain, double step_s);

  [[nodiscard]] State step(State s, double u_begin, double u_end) const {
    const double du = u_end - u_begin;
    return {a11_ * s.x + a12_ * s.v + b1_ * u_begin + c1_ * du,
            a21_ * s.x + a22_ * s.v + b2_ * u_begin + c2_ * du};
  }

 private:
  double a11_, a12_, a21_, a22_;
  double b1_, b2_;  ///< answer to a constant input
  double c1_, c2_;  ///< answer to an input that rises by one over the step
};

}  // namespace motionlab::plant
