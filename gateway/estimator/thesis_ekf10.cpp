#include "gateway/estimator/thesis_ekf10.hpp"

#include "gateway/math/pendulum.hpp"

namespace motionlab::estimator {
namespace {

constexpr double square(double x) {
  return x * x;
}

}  // namespace

ThesisEkf10::ThesisEkf10(const ThesisEkf10Config& config, const math::KalmanState<10>& start)
    : config_(config), state_(start) {
  Q_.diagonal().segment<3>(0).setConstant(square(config.process_deviation_position_m));
  Q_.diagonal().segment<3>(3).setConstant(square(config.process_deviation_speed_mps));
  Q_.diagonal().segment<2>(6).setConstant(square(config.process_deviation_angle_rad));
  Q_.diagonal().segment<2>(8).setConstant(square(config.process_deviation_rate_radps));
  variances_.head<3>().setConstant(square(config.measurement_deviation_position_m));
  variances_.tail<2>().setConstant(square(config.measurement_deviation_angle_rad));
}

ThesisEkf10::ThesisEkf10(const ThesisEkf10Config& config, const Eigen::Vector3d& p_RT)
    : ThesisEkf10(config, math::KalmanState<10>{}) {
  state_.x.head<3>() = p_RT;
  state_.P = config.initial_variance * Matrix::Identity();
}

Eigen::Matrix<double, 5, 10> ThesisEkf10::measurement_matrix() {
  Eigen::Matrix<double, 5, 10> H = Eigen::Matrix<double, 5, 10>::Zero();
  H.block<3, 3>(0, 0).setIdentity();
  H.block<2, 2>(3, 6).setIdentity();
  return H;
}

void ThesisEkf10::update(const Measurement& measured) {
  const Eigen::Matrix<double, 5, 10> H = measurement_matrix();
  math::update_row_by_row<10, 5>(state_, H, measured - H * state_.x, variances_);
}

ThesisEkf10::Matrix ThesisEkf10::jacobian(const Input& u) const {
  const double dt = config_.period_s;
  Matrix F = Matrix::Identity();
  F.block<3, 3>(0, 3) = dt * Eigen::Matrix3d::Identity();
  F.block<2, 2>(6, 8) = dt * Eigen::Matrix2d::Identity();
  const math::SwingJacobian D = math::swing_jacobian(state_.x.segment<2>(6), state_.x.segment<2>(8), u,
                                                     config_.wire_length_m, 0.0, config_.gravity_mps2);
  F.block<2, 4>(8, 6) += dt * D.leftCols<4>();
  return F;
}

void ThesisEkf10::predict(const Input& u) {
  const Eigen::Vector2d angles = state_.x.segment<2>(6), rates = state_.x.segment<2>(8);
  State rate;
  rate << state_.x.segment<3>(3), u, rates,
      math::swing_acceleration<double>(angles, rates, u, config_.wire_length_m, 0.0, config_.gravity_mps2);
  math::predict_extended<10>(state_, State(state_.x + config_.period_s * rate), jacobian(u), Q_);
}

}  // namespace motionlab::estimator
