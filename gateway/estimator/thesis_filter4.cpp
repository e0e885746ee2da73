#include "gateway/estimator/thesis_filter4.hpp"

#include <cmath>

#include "gateway/math/pendulum.hpp"
#include "gateway/math/riccati.hpp"

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
  if (form == ThesisKf4Form::continuous) {
    const Eigen::Matrix<double, 2, 4> C = measurement_matrix();
    // The filter's Riccati equation is the regulator's of the transposed system. Q gives x no noise of its
    // own, but x' has some, so a stabilising solution exists.
    const Eigen::MatrixXd R = config.measurement_variance.asDiagonal();
    state_.P = math::solve_care(A_.transpose(), C.transpose(), Q_, R);
    stationary_gain_ = state_.P * C.transpose() * config.measurement_variance.cwiseInverse().asDiagonal();
  }
}

void ThesisKf4::update(const Measurement& measured) {
  if (form_ == ThesisKf4Form::continuous) {
    measured_ = measured;  // acts through the whole period
  } else {
    take_in(state_, measured, config_);
  }
}

void ThesisKf4::predict(double acceleration) {
  if (form_ == ThesisKf4Form::continuous) {
    const Vector4d correction = stationary_gain_ * (measured_ - measurement_matrix() * state_.x);
    state_.x += config_.period_s * (A_ * state_.x + B_ * acceleration + correction);
  } else {
    math::predict<4>(state_, F_, config_.period_s * acceleration * B_, Q_);
  }
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
