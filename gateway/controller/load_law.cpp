#include "gateway/controller/load_law.hpp"

#include <algorithm>
#include <cmath>

#include "gateway/math/riccati.hpp"

namespace motionlab::controller {
namespace {

/// Time constant of the filter that differentiates the reference's acceleration.
constexpr double kJerkFilter = 0.1;
/// How fast the law's own speed dies out when its share is taken back.
constexpr double kLetGo = 1.0;

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

void LoadLaw::start(const Vector3d& p_WT, const Vector3d& v_WT, double tool_height_m) {
  p_ = p_WT;
  v_ = v_WT;
  a_.setZero();
  v_riding_.setZero();
  integral_.setZero();
  a_reference_.reset();
  tool_height_m_ = tool_height_m;
}

void LoadLaw::step(double dt, const Inputs& in) {
  const Gain K = gain(in.wire_length_m);
  const math::PointMotion& r = in.reference;
  const Vector3d error = in.p_WL - r.p;
  // How far and how fast the tool goes ahead of the load.
  if (!a_reference_) a_reference_ = r.a;
  const Vector3d jerk = (r.a - *a_reference_) / kJerkFilter;
  *a_reference_ += dt * jerk;
  const double lead = in.wire_length_m / config_.gravity_mps2;
  const Vector3d ahead = lead * *a_reference_, ahead_rate = lead * jerk;
  Vector3d a;
  for (int k = 0; k < 2; ++k) {
    Eigen::Matrix<double, 5, 1> x;
    x << p_[k] - r.p[k] - ahead[k], v_[k] - r.v[k] - ahead_rate[k], in.p_WL[k] - p_[k] + ahead[k],
        in.v_WL[k] - v_[k] + ahead_rate[k], integral_[k];
    a[k] = in.share * (r.a[k] - K.dot(x.transpose())) - (1 - in.share) * v_[k] / kLetGo;
  }
  const double w = config_.vertical_omega_radps;
  a.z() = -w * w * (p_.z() - tool_height_m_) - 2 * w * v_.z();
  a_ = bounded(a, config_.acceleration_max_mps2);
  v_riding_ = (1 - in.share) * Vector3d(in.v_ship.x(), in.v_ship.y(), 0.0);
  if (in.share >= 1 && error.head<2>().norm() < config_.integral_zone_m) integral_ += dt * error.head<2>();

  p_ += dt * (v_ + v_riding_) + 0.5 * dt * dt * a_;
  const Vector3d v = v_ + dt * a_;
  // A tool that begins faster than the bound is slowed by the law, never cut.
  v_ = bounded(v, std::max(config_.speed_max_mps, v_.norm()));
}

}  // namespace motionlab::controller
