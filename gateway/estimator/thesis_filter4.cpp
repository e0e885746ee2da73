#include "gateway/estimator/thesis_filter4.hpp"

#include <cmath>

#include "gateway/math/integrate.hpp"
#include "gateway/math/pendulum.hpp"

namespace motionlab::estimator {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector4d;

void take_in(math::KalmanState<4>& state, const Eigen::Vector2d& measured,
             const ThesisFilter4Config& config) {
  const Eigen::Matrix<double, 2, 4> C = ThesisKf4::measurement_matrix();
  math::update_row_by_row<4, 2>(state, C, measured - C * state.x, config.measurement_variance);
}

}  // namespace

Matrix4d ThesisKf4::system_matrix(const ThesisFilter4Config& config) {
  Matrix4d A = Matrix4d::Zero();
  A(0, 1) = A(2, 3) = 1;
  A(3, 2) = -config.gravity_mps2 / config.wire_length_m;
  return A;
}

Eigen::Matrix<double, 2, 4> ThesisKf4::measurement_matrix() {
  Eigen::Matrix<double, 2, 4> C = Eigen::Matrix<double, 2, 4>::Zero();
  C(0, 0) = C(1, 2) = 1;
  return C;
}

ThesisKf4::ThesisKf4(const ThesisFilter4Config& config, const State& start, ThesisKf4Form form)
    : config_(config), form_(form), A_(system_matrix(config)), B_(0, 1, 0, -1 / config.wire_length_m) {
  F_ = Matrix4d::Identity() + config.period_s * A_;
  Q_ = config.process_variance.asDiagonal();
  state_.x = start;
  state_.P = config.initial_variance * Matrix4d::Identity();
}

void ThesisKf4::update(const Measurement& measured) {
  if (form_ == ThesisKf4Form::continuous) {
    measured_ = measured;  // acts through the whole period
  } else {
    take_in(state_, measured, config_);
  }
}

void ThesisKf4::predict(double acceleration) {
  if (form_ == ThesisKf4Form::discrete) {
    return math::predict<4>(state_, F_, config_.period_s * acceleration * B_, Q_);
  }
  // x' = A x + B u + K (y − C x) and P' = A P + P Aᵀ + Q − K R Kᵀ with K = P Cᵀ R⁻¹, side by side.
  using Both = Eigen::Matrix<double, 4, 5>;
  const Eigen::Matrix<double, 2, 4> C = measurement_matrix();
  const Eigen::Matrix<double, 4, 2> by_R =
      C.transpose() * config_.measurement_variance.cwiseInverse().asDiagonal();
  const auto rate = [&](double, const Both& both) {
    const Matrix4d P = both.rightCols<4>();
    const Vector4d x = both.col(0);
    const Eigen::Matrix<double, 4, 2> K = P * by_R;
    Both d;
    d.col(0) = A_ * x + B_ * acceleration + K * (measured_ - C * x);
    d.rightCols<4>() = A_ * P + P * A_.transpose() + Q_ - K * C * P;
    return d;
  };
  Both both;
  both << state_.x, state_.P;
  both = math::rk4_step(rate, 0.0, both, config_.period_s);
  state_.x = both.col(0);
  state_.P = both.rightCols<4>();
}

ThesisEkf4::ThesisEkf4(const ThesisFilter4Config& config, const State& start) : config_(config) {
  state_.x = start;
  state_.P = config.initial_variance * Matrix4d::Identity();
}

void ThesisEkf4::update(const Measurement& measured) {
  take_in(state_, measured, config_);
}

Matrix4d ThesisEkf4::jacobian(double u) const {
  const double dt = config_.period_s, theta = state_.x[2];
  Matrix4d F = Matrix4d::Identity();
  F(0, 1) = F(2, 3) = dt;
  F(3, 2) = dt * (u * std::sin(theta) - config_.gravity_mps2 * std::cos(theta)) / config_.wire_length_m;
  return F;
}

void ThesisEkf4::predict(double u) {
  const Vector4d& x = state_.x;
  const double angle_acceleration =
      math::planar_swing_acceleration(x[2], x[3], u, 0.0, config_.wire_length_m, 0.0, config_.gravity_mps2);
  const Vector4d next = x + config_.period_s * Vector4d(x[1], u, x[3], angle_acceleration);
  const Matrix4d Q = config_.process_variance.asDiagonal();
  math::predict_extended<4>(state_, next, jacobian(u), Q);
}

}  // namespace motionlab::estimator
