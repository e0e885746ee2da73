#include "gateway/estimator/ship_axis.hpp"

#include <cmath>

#include "gateway/math/riccati.hpp"

namespace motionlab::estimator {

ShipAxis::ShipAxis(double period_s, double damping) {
  const double w = 2 * std::acos(-1.0) / period_s, z = damping;
  Eigen::Matrix4d F = Eigen::Matrix4d::Zero();
  F(0, 1) = F(1, 2) = F(2, 3) = 1;
  F.row(3) << -w * w * w * w, -4 * z * w * w * w, -(2 + 4 * z * z) * w * w, -4 * z * w;
  Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();
  Q(3, 3) = 1;
  stationary_ = math::solve_lyapunov(F, Q);
  taylor_[0].setIdentity();
  for (std::size_t k = 1; k < taylor_.size(); ++k) taylor_[k] = taylor_[k - 1] * F / static_cast<double>(k);
}

Eigen::Matrix4d ShipAxis::transition(double dt) const {
  Eigen::Matrix4d A = taylor_.back();
  for (std::size_t k = taylor_.size() - 1; k-- > 0;) A = A * dt + taylor_[k];
  return A;
}

Eigen::Matrix4d ShipAxis::noise(double dt) {
  // Noise on the jerk, integrated upwards; the equation's own coefficients matter only at order dt higher.
  const Eigen::Vector4d g(dt * dt * dt / 6, dt * dt / 2, dt, 1);
  Eigen::Matrix4d Q;
  for (Eigen::Index i = 0; i < 4; ++i) {
    for (Eigen::Index j = 0; j < 4; ++j) Q(i, j) = dt * g[i] * g[j] / static_cast<double>(7 - i - j);
  }
  return Q;
}

}  // namespace motionlab::estimator
