/// @file  The pendulum in a plane of the thesis (Sec 4.4.1): a cart that can be accelerated at will.
#pragma once

#include <Eigen/Core>

namespace motionlab::plant {

/// State (x, x', theta, theta'), theta from plumb; rigid wire of constant length, no friction. Eq 4.10.
class ThesisPendulum {
 public:
  using State = Eigen::Vector4d;

  explicit ThesisPendulum(double wire_length_m, double gravity_mps2 = 9.81)
      : length_m_(wire_length_m), gravity_(gravity_mps2) {}

  /// d/dt of the state under the cart's acceleration.
  [[nodiscard]] State rate(const State& state, double acceleration_mps2) const;
  [[nodiscard]] double length_m() const { return length_m_; }

 private:
  double length_m_;
  double gravity_;
};

}  // namespace motionlab::plant
