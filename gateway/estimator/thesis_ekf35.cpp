#include "gateway/estimator/thesis_ekf35.hpp"

#include <Eigen/LU>
#include <limits>

#include "gateway/math/pendulum.hpp"

namespace motionlab::estimator {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// The equations of motion at one state, and what of their derivative is not a plain shift.
struct ThesisEkf35::Model {
  State rate;
  Matrix3d angle_by_angle;                       ///< of the Euler rates by the Euler angles
  Matrix3d angle_by_omega;                       ///< by the angular rate in B
  Eigen::Matrix<double, 2, kStates> phi_dot_by;  ///< of the swing's acceleration by everything
};

ThesisEkf35::ThesisEkf35(const ThesisEkf35Config& config, const math::KalmanState<kStates>& start)
    : config_(config), state_(start) {
  const auto variance = [](double deviation) { return deviation * deviation; };
  process_variances_.setConstant(variance(config.process_deviation));
  process_variances_.segment<6>(kVdot).setConstant(variance(config.process_deviation_platform_acceleration));
  process_variances_.segment<3>(kPddot).setConstant(variance(config.process_deviation_arm_acceleration));
  process_variances_[kLdot] = variance(config.process_deviation_wire_speed);
  process_variances_.segment<2>(kPhiDot).setConstant(variance(config.process_deviation_swing_rate));
  process_variances_.segment<2>(kPhiDdot).setConstant(variance(config.process_deviation_swing_acceleration));
  variances_.head<12>().setConstant(variance(config.measurement_deviation_platform));
  variances_.segment<6>(12).setConstant(variance(config.measurement_deviation_arm));
  variances_[18] = variance(config.measurement_deviation_wire);
  variances_.tail<4>().setConstant(variance(config.measurement_deviation_swing));
}

ThesisEkf35::ThesisEkf35(const ThesisEkf35Config& config, const Vector3d& p_RT, double wire_length_m)
    : ThesisEkf35(config, math::KalmanState<kStates>{}) {
  state_.x.segment<3>(kP) = p_RT;
  state_.x[kL] = wire_length_m;
  state_.P = config.initial_deviation * config.initial_deviation * Matrix::Identity();
}

Eigen::Matrix<double, ThesisEkf35::kMeasured, ThesisEkf35::kStates> ThesisEkf35::measurement_matrix() {
  Eigen::Matrix<double, kMeasured, kStates> H = Eigen::Matrix<double, kMeasured, kStates>::Zero();
  for (int i = 0; i < kMeasured; ++i) H(i, kRows[static_cast<std::size_t>(i)]) = 1;
  return H;
}

void ThesisEkf35::update(const Measurement& measured) {
  const State before = state_.x;
  math::SparseUpdates<kStates, kMeasured> updates(state_);
  for (int i = 0; i < kMeasured; ++i) {
    const int state = kRows[static_cast<std::size_t>(i)];
    math::SparseRow row;
    row.add(state, 1.0);
    updates.update(row, measured[i] - before[state], variances_[i], std::numeric_limits<double>::infinity());
  }
}

ThesisEkf35::Model ThesisEkf35::model(const Input& input) const {
  const State& x = state_.x;
  const Vector3d rpy = x.segment<3>(kAngle), omega = x.segment<3>(kOmega), alpha = x.segment<3>(kOmegaDot);
  const bool commanded = config_.arm_acceleration == ThesisArmAcceleration::input;
  const Vector3d arm = commanded ? Vector3d(input.head<3>()) : Vector3d(x.segment<3>(kPddot));

  Model m;
  // eta' = J(eta) v (Eq 3.69): the angular part is the inverse of omega = T rpy'.
  const Matrix3d T = math::euler_zyx_rates_to_body(rpy);
  m.angle_by_omega = T.inverse();
  const Vector3d rpy_dot = m.angle_by_omega * omega;
  for (int i = 0; i < 3; ++i) {
    m.angle_by_angle.col(i) =
        -(m.angle_by_omega * (math::euler_zyx_rates_to_body_dot(rpy, Vector3d::Unit(i)) * rpy_dot));
  }

  // The tool's acceleration in the world, Eq 3.82 turned by R_WN (Eq 3.81/3.82 of the thesis forget that).
  const Matrix3d R_WB = config_.R_WN * math::from_euler(rpy, math::EulerOrder::zyx);
  const Vector3d s = config_.p_BR_m + config_.R_BR * x.segment<3>(kP);
  const Vector3d w = config_.R_BR * x.segment<3>(kPdot);
  const Vector3d turning = omega.cross(s);
  const Vector3d in_B = alpha.cross(s) + omega.cross(turning) + 2 * omega.cross(w) + config_.R_BR * arm;
  const Vector3d a_WT = config_.R_WN * x.segment<3>(kVdot) + R_WB * in_B;

  const Vector2d phi = x.segment<2>(kPhi), phi_dot = x.segment<2>(kPhiDot);
  m.rate.setZero();
  m.rate.segment<3>(kEta) = x.segment<3>(kV);
  m.rate.segment<3>(kAngle) = rpy_dot;
  m.rate.segment<6>(kV) = x.segment<6>(kVdot);
  m.rate.segment<3>(kP) = x.segment<3>(kPdot);
  m.rate.segment<3>(kPdot) = arm;
  m.rate[kL] = x[kLdot];
  m.rate[kLdot] = config_.winch_omega_radps *
                  (config_.winch_omega_radps * (input[3] - x[kL]) - 2 * config_.winch_damping * x[kLdot]);
  m.rate.segment<2>(kPhi) = phi_dot;
  m.rate.segment<2>(kPhiDot) =
      math::swing_acceleration<double>(phi, phi_dot, a_WT, x[kL], x[kLdot], config_.gravity_mps2);

  const math::SwingJacobian D =
      math::swing_jacobian(phi, phi_dot, a_WT, x[kL], x[kLdot], config_.gravity_mps2);
  const Eigen::Matrix<double, 2, 3> by_a = D.middleCols<3>(4);
  const Eigen::Matrix<double, 2, 3> by_a_B = by_a * R_WB;
  const Matrix3d Omega = math::hat(omega);
  m.phi_dot_by.setZero();
  // dR/d(angle i) = R hat(T's column i), because T's columns are the axes about which the angles turn, in B.
  for (int i = 0; i < 3; ++i) m.phi_dot_by.col(kAngle + i) = by_a_B * Vector3d(T.col(i)).cross(in_B);
  m.phi_dot_by.middleCols<3>(kOmega) =
      -by_a_B * (math::hat(turning) + Omega * math::hat(s) + 2 * math::hat(w));
  m.phi_dot_by.middleCols<3>(kVdot) = by_a * config_.R_WN;
  m.phi_dot_by.middleCols<3>(kOmegaDot) = -by_a_B * math::hat(s);
  m.phi_dot_by.middleCols<3>(kP) = by_a_B * (math::hat(alpha) + Omega * Omega) * config_.R_BR;
  m.phi_dot_by.middleCols<3>(kPdot) = 2 * by_a_B * Omega * config_.R_BR;
  if (!commanded) m.phi_dot_by.middleCols<3>(kPddot) = by_a_B * config_.R_BR;
  m.phi_dot_by.middleCols<2>(kL) = D.rightCols<2>();
  m.phi_dot_by.middleCols<4>(kPhi) = D.leftCols<4>();
  return m;
}

ThesisEkf35::Matrix ThesisEkf35::rate_jacobian(const Input& input) const {
  const Model m = model(input);
  Matrix A = Matrix::Zero();
  A.block<3, 3>(kEta, kV).setIdentity();
  A.block<3, 3>(kAngle, kAngle) = m.angle_by_angle;
  A.block<3, 3>(kAngle, kOmega) = m.angle_by_omega;
  A.block<6, 6>(kV, kVdot).setIdentity();
  A.block<3, 3>(kP, kPdot).setIdentity();
  if (config_.arm_acceleration == ThesisArmAcceleration::state) A.block<3, 3>(kPdot, kPddot).setIdentity();
  A(kL, kLdot) = 1;
  A(kLdot, kL) = -config_.winch_omega_radps * config_.winch_omega_radps;
  A(kLdot, kLdot) = -2 * config_.winch_damping * config_.winch_omega_radps;
  A.block<2, 2>(kPhi, kPhiDot).setIdentity();
  A.block<2, kStates>(kPhiDot, 0) = m.phi_dot_by;
  return A;
}

void ThesisEkf35::predict(const Input& input) {
  const Model m = model(input);
  const double dt = config_.period_s;
  state_.x += dt * m.rate;

  // P ← F P Fᵀ + Q with F = I + dt A. A has few entries outside the swing's two rows, so P Fᵀ is P with
  // multiples of some columns added to others; done twice, transposed between, it is all.
  for (int pass = 0; pass < 2; ++pass) {
    const Matrix P = state_.P;
    Matrix& G = state_.P;
    G.middleCols<3>(kEta) += dt * P.middleCols<3>(kV);
    G.middleCols<3>(kAngle) += dt * (P.middleCols<3>(kAngle) * m.angle_by_angle.transpose() +
                                     P.middleCols<3>(kOmega) * m.angle_by_omega.transpose());
    G.middleCols<6>(kV) += dt * P.middleCols<6>(kVdot);
    G.middleCols<3>(kP) += dt * P.middleCols<3>(kPdot);
    if (config_.arm_acceleration == ThesisArmAcceleration::state) {
      G.middleCols<3>(kPdot) += dt * P.middleCols<3>(kPddot);
    }
    G.col(kL) += dt * P.col(kLdot);
    const double w = config_.winch_omega_radps;
    G.col(kLdot) -= dt * w * (w * P.col(kL) + 2 * config_.winch_damping * P.col(kLdot));
    G.middleCols<2>(kPhi) += dt * P.middleCols<2>(kPhiDot);
    G.middleCols<2>(kPhiDot).noalias() += dt * P * m.phi_dot_by.transpose();
    G.transposeInPlace();
  }
  state_.P.diagonal() += process_variances_;
  state_.P = (0.5 * (state_.P + state_.P.transpose())).eval();
}

}  // namespace motionlab::estimator
