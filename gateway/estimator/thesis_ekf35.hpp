/// @file  The extended Kalman filter of the thesis for the whole motion system (Sec 4.6.2, C.6).
#pragma once

#include <Eigen/Core>
#include <array>

#include "gateway/math/rotation.hpp"
#include "gateway/math/sparse_kalman.hpp"

namespace motionlab::estimator {

/// Where the state of the arm's acceleration comes from.
enum class ThesisArmAcceleration {
  input,  ///< the commanded one, as in the thesis' code: x(25:27) then is dead weight
  state,  ///< a state of its own, as Eq 4.79 is printed
};

/// The rotation part of the thesis' H_b^r as printed, to four digits: orthonormal to 7e-5.
[[nodiscard]] inline math::Matrix3d thesis_R_BR_as_printed() {
  math::Matrix3d R;
  R << -0.4972, 0.8676, -0.0050, 0.8676, 0.4972, 0.0012, 0.0036, -0.0037, -1.0;
  return R;
}

/// What the filter believes; numbers of the thesis' code with its index slips corrected: Q(32:33) was set
/// twice (the second is meant for 34:35), R(30:31) and R(31:32) overlap (the second is meant for 32:33).
/// Tab 4.6 prints other values for some rows; the code's are those behind the published figures.
struct ThesisEkf35Config {
  double gravity_mps2 = 9.81;
  double period_s = 1e-3;
  /// Axes of the world, z up, in which the swing equations hold. N is z-down. Thesis Eq 3.81/3.82 leave this
  /// rotation out; identity gives the thesis' own frame.
  math::Matrix3d R_WN = math::Vector3d(1, -1, -1).asDiagonal();
  /// Robot base in the platform's body: the printed matrix, made a rotation. (Its inverse and its transpose
  /// are not the same; the thesis uses both.)
  math::Matrix3d R_BR = math::nearest_rotation(thesis_R_BR_as_printed());
  math::Vector3d p_BR_m{-1.0820, 1.5360, -1.0245};
  double winch_omega_radps = 8 * 3.14159265358979323846;
  double winch_damping = 0.7;
  ThesisArmAcceleration arm_acceleration = ThesisArmAcceleration::input;

  double process_deviation = 0.001;  ///< of every state that is not named below
  double process_deviation_platform_acceleration = 0.05;
  double process_deviation_arm_acceleration = 0.05;
  double process_deviation_wire_speed = 0.05;
  double process_deviation_swing_rate = 0.1;
  double process_deviation_swing_acceleration = 0.1;
  double measurement_deviation_platform = 0.01;  ///< eta and v
  double measurement_deviation_arm = 0.001;      ///< tool point and its velocity
  double measurement_deviation_wire = 0.001;
  double measurement_deviation_swing = 0.1;  ///< angles and rates
  double initial_deviation = 0.001;          ///< of every state
};

/// State: eta (6), v (6), v' (6) of the platform, tool point, velocity, acceleration in the robot base (3
/// each), wire length and speed, swing angles, rates, accelerations (2 each).
///
/// eta = (x, y, z, roll, pitch, yaw) with R_NB = Rz Ry Rx; v = (dP/dt in N, angular rate in B): mixed, as the
/// thesis uses it. Measured every period: eta, v, tool point and velocity, wire length, angles, rates, 23 in
/// all. Input: the arm's acceleration and the wire's set point.
///
/// Of the 35 states 30 are observable when the arm's acceleration is an input (its three states and the two
/// swing accelerations enter nothing), 33 when it is a state.
///
/// Call `update` with the measurements of t, then `predict` with the input that acts from t to t + period.
/// Nothing is allocated. Singular at a pitch of 90°.
class ThesisEkf35 {
 public:
  static constexpr int kStates = 35;
  static constexpr int kMeasured = 23;
  using State = Eigen::Matrix<double, kStates, 1>;
  using Matrix = Eigen::Matrix<double, kStates, kStates>;
  using Measurement = Eigen::Matrix<double, kMeasured, 1>;
  using Input = Eigen::Vector4d;  ///< arm's acceleration (3) [m/s²], wire length set point [m]

  /// Where each part of the state begins.
  enum Index {
    kEta = 0,
    kAngle = 3,
    kV = 6,
    kOmega = 9,
    kVdot = 12,
    kOmegaDot = 15,
    kP = 18,
    kPdot = 21,
    kPddot = 24,
    kL = 27,
    kLdot = 28,
    kPhi = 29,
    kPhiDot = 31,
    kPhiDdot = 33,
  };
  /// Which state each measurement is.
  static constexpr std::array<int, kMeasured> kRows{0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10, 11,
                                                    18, 19, 20, 21, 22, 23, 27, 29, 30, 31, 32};

  /// Begins with the platform at neutral and at rest and the load plumb below p_RT.
  ThesisEkf35(const ThesisEkf35Config& config, const math::Vector3d& p_RT, double wire_length_m);
  /// Begins with a state and covariance of the caller's.
  ThesisEkf35(const ThesisEkf35Config& config, const math::KalmanState<kStates>& start);

  void update(const Measurement& measured);
  void predict(const Input& input);
  [[nodiscard]] const math::KalmanState<kStates>& state() const { return state_; }
  [[nodiscard]] const Measurement& measurement_variances() const { return variances_; }

  /// d/dt of the state by the state (the transition's derivative is I + period times this).
  [[nodiscard]] Matrix rate_jacobian(const Input& input) const;
  /// dh/dx: rows of the identity.
  [[nodiscard]] static Eigen::Matrix<double, kMeasured, kStates> measurement_matrix();

 private:
  struct Model;
  [[nodiscard]] Model model(const Input& input) const;

  ThesisEkf35Config config_;
  State process_variances_;
  Measurement variances_;
  math::KalmanState<kStates> state_;
};

}  // namespace motionlab::estimator
