#include "simulators/plant/second_order.hpp"

#include <Eigen/Core>

namespace motionlab::plant {

SecondOrder::SecondOrder(double w, double zeta, double gain, double h) {
  // Matrix exponential of the system together with its input (u, rise of u per step), by its Taylor series:
  // the step is short against the system, so it converges in a few terms.
  Eigen::Matrix4d M = Eigen::Matrix4d::Zero();
  M(0, 1) = h;
  M(1, 0) = -w * w * h;
  M(1, 1) = -2 * zeta * w * h;
  M(1, 2) = gain * h;
  M(2, 3) = 1;
  Eigen::Matrix4d term = Eigen::Matrix4d::Identity(), E = term;
  for (int i = 1; i <= 30; ++i) {
    term = term * M / i;
    E += term;
  }
  a11_ = E(0, 0), a12_ = E(0, 1), a21_ = E(1, 0), a22_ = E(1, 1);
  b1_ = E(0, 2), b2_ = E(1, 2), c1_ = E(0, 3), c2_ = E(1, 3);
}

}  // namespace motionlab::plant
