/// @file  The extended Kalman filter of the thesis for the load below the arm (Sec 4.5.2, C.5.1).
#pragma once

#include <Eigen/Core>

#include "gateway/math/kalman.hpp"

namespace motionlab::estimator {

/// Defaults are the thesis' numbers (Eq 4.45–4.49). Its code puts the angles' R on rows that hold other
/// things (R(4:5) instead of R(7:8)), so that they weigh 1 rad²; the text's 0.01² is meant and used here.
struct ThesisEkf10Config {
  double gravity_mps2 = 9.81;
  double wire_length_m = 2.0;  ///< the model's, whatever hangs there (scenario 4 hangs on 6 m)
  double period_s = 1e-3;
  double process_deviation_position_m = 1e-5;
  double process_deviation_speed_mps = 1e-3;
  double process_deviation_angle_rad = 1e-3;
  double process_deviation_rate_radps = 1e-2;
  double measurement_deviation_position_m = 1e-3;
  double measurement_deviation_angle_rad = 1e-2;
  double initial_variance = 1e-3;  ///< of every state
};

/// State: tool point (3) and its velocity (3) in the robot base, which stands still and upright; swing angles
/// (2) and rates (2). Measured every period: tool point and angles; the input is the tool's acceleration.
///
/// Call `update` with the measurements of t, then `predict` with the input that acts from t to t + period.
/// Nothing is allocated. C.5.1 derives its measurement matrix by the input (a zero matrix); here it is dh/dx.
class ThesisEkf10 {
 public:
  using State = Eigen::Matrix<double, 10, 1>;
  using Matrix = Eigen::Matrix<double, 10, 10>;
  using Measurement = Eigen::Matrix<double, 5, 1>;  ///< tool point, alpha, beta
  using Input = Eigen::Vector3d;

  /// Begins with the load plumb and at rest below p_RT.
  ThesisEkf10(const ThesisEkf10Config& config, const Eigen::Vector3d& p_RT);
  /// Begins with a state and covariance of the caller's.
  ThesisEkf10(const ThesisEkf10Config& config, const math::KalmanState<10>& start);

  void update(const Measurement& measured);
  void predict(const Input& tool_acceleration_mps2);
  [[nodiscard]] const math::KalmanState<10>& state() const { return state_; }

  /// The derivative of the transition by the state.
  [[nodiscard]] Matrix jacobian(const Input& tool_acceleration_mps2) const;
  /// dh/dx.
  [[nodiscard]] static Eigen::Matrix<double, 5, 10> measurement_matrix();

 private:
  ThesisEkf10Config config_;
  Matrix Q_ = Matrix::Zero();
  Measurement variances_;
  math::KalmanState<10> state_;
};

}  // namespace motionlab::estimator
