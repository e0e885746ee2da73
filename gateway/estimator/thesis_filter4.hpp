/// @file  The two estimators of the thesis' pendulum in a plane: a linear Kalman filter and its extended
/// form.
#pragma once

#include <Eigen/Core>

#include "gateway/math/kalman.hpp"

namespace motionlab::estimator {

/// What both filters believe of the pendulum; defaults are the thesis' numbers (Eq 4.18–4.20, C.4).
struct ThesisFilter4Config {
  double gravity_mps2 = 9.81;
  double wire_length_m = 2.0;  ///< the model's, whatever hangs there
  double period_s = 1e-3;
  Eigen::Vector4d process_variance{0, 1e-6, 1e-4, 1e-4};  ///< added each period (Eq 4.18)
  Eigen::Vector2d measurement_variance{1e-6, 1e-4};       ///< of x [m²] and theta [rad²] (Eq 4.19)
  double initial_variance = 1e-3;                         ///< of every state (Eq 4.20)
};

/// How the linear filter reads the printed covariances.
///
/// The thesis gives one set of numbers to a discrete extended filter and to a continuous linear one, where
/// they are spectral densities: a Q/R that is a million times smaller. That alone makes Fig 4.20/4.21; with
/// the same discrete numbers both filters estimate the angle alike.
enum class ThesisKf4Form {
  discrete,    ///< per period, like the extended filter: the fair comparison, and the default
  continuous,  ///< spectral densities (Kalman–Bucy), as in the thesis' figures
};

/// State (x, x', theta, theta') of a pendulum of which x [m] and theta [rad] are measured every period; the
/// input is x'' [m/s²]. Linear about hanging still (Eq 4.14–4.16).
///
/// Call `update` with the measurements of t, then `predict` with the input that acts from t to t + period.
/// Before the first update the state is the start value. Nothing is allocated after construction.
class ThesisKf4 {
 public:
  using State = Eigen::Vector4d;
  using Measurement = Eigen::Vector2d;

  explicit ThesisKf4(const ThesisFilter4Config& config = {}, const State& start = State::Zero(),
                     ThesisKf4Form form = ThesisKf4Form::discrete);

  void update(const Measurement& measured);
  void predict(double acceleration_mps2);
  [[nodiscard]] const math::KalmanState<4>& state() const { return state_; }

  /// d/dt of the state by the state (Eq 4.14).
  [[nodiscard]] static Eigen::Matrix4d system_matrix(const ThesisFilter4Config& config);
  /// The measurement matrix (Eq 4.16).
  [[nodiscard]] static Eigen::Matrix<double, 2, 4> measurement_matrix();

 private:
  ThesisFilter4Config config_;
  ThesisKf4Form form_;
  Eigen::Matrix4d A_, F_, Q_;
  Eigen::Vector4d B_;
  Measurement measured_ = Measurement::Zero();
  math::KalmanState<4> state_;
};

/// The same with the pendulum's own equation (Eq 4.10, C.4.1) in the prediction.
class ThesisEkf4 {
 public:
  using State = Eigen::Vector4d;
  using Measurement = Eigen::Vector2d;

  explicit ThesisEkf4(const ThesisFilter4Config& config = {}, const State& start = State::Zero());
  /// Begins with a state and covariance of the caller's.
  ThesisEkf4(const ThesisFilter4Config& config, const math::KalmanState<4>& start)
      : config_(config), state_(start) {}

  void update(const Measurement& measured);
  void predict(double acceleration_mps2);
  [[nodiscard]] const math::KalmanState<4>& state() const { return state_; }
  /// The derivative of the transition by the state (Eq 3.166).
  [[nodiscard]] Eigen::Matrix4d jacobian(double acceleration_mps2) const;

 private:
  ThesisFilter4Config config_;
  math::KalmanState<4> state_;
};

}  // namespace motionlab::estimator
