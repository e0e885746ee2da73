#include "gateway/estimator/ship_axis.hpp"

#include <array>
#include <cmath>

#include "gateway/math/riccati.hpp"

namespace motionlab::estimator {

ShipAxis::ShipAxis(double period_s, double damping) {
  const double w = 2 * std::acos(-1.0) / period_s, z = damping;
  c_ << w * w * w * w, 4 * z * w * w * w, (2 + 4 * z * z) * w * w, 4 * z * w;
  Eigen::Matrix4d F = Eigen::Matrix4d::Zero();
  F(0, 1) = F(1, 2) = F(2, 3) = 1;
  F.row(3) = -c_.transpose();
  Eigen::Matrix4d Q = Eigen::Matrix4d::Zero();
  Q(3, 3) = 1;
  stationary_ = math::solve_lyapunov(F, Q);
}

ShipAxis::State ShipAxis::propagate(const State& x, double dt) const {
  // Derivatives 0…9 of x; the equation of motion gives the fourth and all higher ones.
  std::array<double, 10> d{};
  for (std::size_t i = 0; i < 4; ++i) d[i] = x[static_cast<Eigen::Index>(i)];
  for (std::size_t k = 4; k < d.size(); ++k) {
    d[k] = -(c_[0] * d[k - 4] + c_[1] * d[k - 3] + c_[2] * d[k - 2] + c_[3] * d[k - 1]);
  }
  State next;
  for (std::size_t i = 0; i < 4; ++i) {
    double sum = 0;
    for (std::size_t k = d.size() - 1; k > i; --k) sum = (sum + d[k]) * dt / static_cast<double>(k - i);
    next[static_cast<Eigen::Index>(i)] = d[i] + sum;
  }
  return next;
}

Eigen::Matrix4d ShipAxis::transition(double dt) const {
  Eigen::Matrix4d A;
  for (Eigen::Index i = 0; i < 4; ++i) A.col(i) = propagate(Eigen::Vector4d::Unit(i), dt);
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
