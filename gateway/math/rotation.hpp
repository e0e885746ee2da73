/// @file  Rotations: elementary turns, Euler sequences and their rates. Theorems; no number of any
/// laboratory.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace motionlab::math {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// The skew matrix with hat(a) b = a × b.
[[nodiscard]] Matrix3d hat(const Vector3d& a);

[[nodiscard]] Matrix3d rot_x(double angle_rad);
[[nodiscard]] Matrix3d rot_y(double angle_rad);
[[nodiscard]] Matrix3d rot_z(double angle_rad);

/// In which order roll, pitch and yaw build a rotation.
enum class EulerOrder {
  zyx,  ///< R = Rz(yaw) Ry(pitch) Rx(roll), the sea-going convention
  xyz,  ///< R = Rx(roll) Ry(pitch) Rz(yaw), the platform's own
};

/// The rotation of (roll, pitch, yaw) in rad.
[[nodiscard]] Matrix3d from_euler(const Vector3d& rpy_rad, EulerOrder order);

/// (roll, pitch, yaw) of a rotation, pitch in [-pi/2, pi/2]. At the singular pitch, roll is set to zero.
[[nodiscard]] Vector3d to_euler(const Matrix3d& R, EulerOrder order);

/// T with omega_body = T d(rpy)/dt for the sequence `zyx` (the inverse of thesis Eq 3.68). 3x3.
[[nodiscard]] Matrix3d euler_zyx_rates_to_body(const Vector3d& rpy_rad);

/// d/dt of `euler_zyx_rates_to_body` along the given Euler rates. 3x3.
[[nodiscard]] Matrix3d euler_zyx_rates_to_body_dot(const Vector3d& rpy_rad, const Vector3d& rpy_dot_radps);

/// The rotation nearest to M in the Frobenius norm. @pre det M > 0
[[nodiscard]] Matrix3d nearest_rotation(const Matrix3d& M);

/// A pose: p_A = R_AB p_B + p_AB.
struct RigidTransform {
  Matrix3d R = Matrix3d::Identity();
  Vector3d p = Vector3d::Zero();

  [[nodiscard]] Vector3d operator*(const Vector3d& p_B) const { return R * p_B + p; }
  [[nodiscard]] RigidTransform operator*(const RigidTransform& X_BC) const {
    return {R * X_BC.R, R * X_BC.p + p};
  }
  [[nodiscard]] RigidTransform inverse() const { return {R.transpose(), -(R.transpose() * p)}; }

  /// From a quaternion w, x, y, z (normalised here) and a position.
  static RigidTransform from_quaternion(const Eigen::Vector4d& q_wxyz, const Vector3d& p);
  /// The unit quaternion w, x, y, z with w >= 0.
  [[nodiscard]] Eigen::Vector4d quaternion_wxyz() const;
};

}  // namespace motionlab::math
