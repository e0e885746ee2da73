#include "gateway/controller/load_law.hpp"

#include <algorithm>
#include <cmath>

#include "gateway/math/riccati.hpp"

namespace motionlab::controller {
namespace {

/// Shortens a vector to at most `longest`, keeping its direction.
template <class Vector>
Vector bounded(const Vector& v, double longest) {
  const double length = v.norm();
  return length > longest ? Vector(v * (longest / length)) : v;
}

}  // namespace

LoadLaw::LoadLaw(const LoadLawConfig& config) : config_(config) {
  for (int i = 0; i < kGains; ++i) {
    const double L = kShortest + (kLongest - kShortest) * i / (kGains - 1);
    // States P, V, d = w − P, ḋ, ∫(w − reference); input: acceleration of the tool point.
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(5, 5), B(5, 1), Q = Eigen::MatrixXd::Zero(5, 5);
    A(0, 1) = A(2, 3) = 1;
    A(3, 2) = -config_.gravity_mps2 / L;
    A(4, 0) = A(4, 2) = 1;
    B << 0, 1, 0, -1, 0;
    const Eigen::VectorXd error = (Eigen::VectorXd(5) << 1, 0, 1, 0, 0).finished();
    Q += config_.weight_load_error * error * error.transpose();
    Q(1, 1) += config_.weight_tool_speed;
    Q(3, 3) += config_.weight_swing_rate;
    Q(4, 4) += config_.weight_load_error_integral;
    gains_[static_cast<std::size_t>(i)] = math::lqr(A, B, Q, Eigen::MatrixXd::Identity(1, 1));
  }
}

LoadLaw::Gain LoadLaw::gain(double L) const {
  const double place = std::clamp((L - kShortest) / (kLongest - kShortest), 0.0, 1.0) * (kGains - 1);
  const auto i = static_cast<std::size_t>(std::min(place, static_cast<double>(kGains - 2)));
  const double f = place - static_cast<double>(i);
  return (1 - f) * gains_[i] + f * gains_[i + 1];
}

void LoadLaw::start(const Vector3d& p_WT, const Vector3d& v_WT, double wire_length_m) {
  p_ = p_WT;
  v_ = v_WT;
  a_.setZero();
  integral_.setZero();
  height_above_reference_m_ = wire_length_m;
}

void LoadLaw::step(double dt, const Vector3d& reference, const Vector3d& p_WL, const Vector3d& v_WL,
                   double L) {
  const Gain K = gain(L);
  Vector3d a;
  for (int k = 0; k < 2; ++k) {
    Eigen::Matrix<double, 5, 1> x;
    x << p_[k] - reference[k], v_[k], p_WL[k] - p_[k], v_WL[k] - v_[k], integral_[k];
    a[k] = -K.dot(x.transpose());
  }
  const double w = config_.vertical_omega_radps;
  a.z() = -w * w * (p_.z() - reference.z() - height_above_reference_m_) - 2 * w * v_.z();
  a_ = bounded(a, config_.acceleration_max_mps2);

  const Vector3d error = p_WL - reference;
  if (error.head<2>().norm() < config_.integral_zone_m) integral_ += dt * error.head<2>();

  p_ += dt * v_ + 0.5 * dt * dt * a_;
  const Vector3d v = v_ + dt * a_;
  // A tool that begins faster than the bound is slowed by the law, never cut.
  v_ = bounded(v, std::max(config_.speed_max_mps, v_.norm()));
}

}  // namespace motionlab::controller
