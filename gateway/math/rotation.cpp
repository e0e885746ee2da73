#include "gateway/math/rotation.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace motionlab::math {

Matrix3d hat(const Vector3d& a) {
  Matrix3d A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

Matrix3d rot_x(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  Matrix3d R;
  R << 1, 0, 0, 0, c, -s, 0, s, c;
  return R;
}

Matrix3d rot_y(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  Matrix3d R;
  R << c, 0, s, 0, 1, 0, -s, 0, c;
  return R;
}

Matrix3d rot_z(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  Matrix3d R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return R;
}

Matrix3d from_euler(const Vector3d& rpy, EulerOrder order) {
  if (order == EulerOrder::zyx) return rot_z(rpy.z()) * rot_y(rpy.y()) * rot_x(rpy.x());
  return rot_x(rpy.x()) * rot_y(rpy.y()) * rot_z(rpy.z());
}

Vector3d to_euler(const Matrix3d& R, EulerOrder order) {
  if (order == EulerOrder::xyz) {
    // The inverse of an xyz rotation is a zyx rotation of the negative angles.
    return -to_euler(Matrix3d(R.transpose()), EulerOrder::zyx);
  }
  const double sin_pitch = std::clamp(-R(2, 0), -1.0, 1.0);
  const double pitch = std::asin(sin_pitch);
  if (std::hypot(R(0, 0), R(1, 0)) < 1e-12) return {0.0, pitch, std::atan2(-R(0, 1), R(1, 1))};
  return {std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0))};
}

Matrix3d euler_zyx_rates_to_body(const Vector3d& rpy) {
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  Matrix3d T;
  T << 1, 0, -sp, 0, cr, sr * cp, 0, -sr, cr * cp;
  return T;
}

Matrix3d euler_zyx_rates_to_body_dot(const Vector3d& rpy, const Vector3d& rpy_dot) {
  const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  const double r = rpy_dot.x(), p = rpy_dot.y();
  Matrix3d T;
  T << 0, 0, -cp * p, 0, -sr * r, cr * cp * r - sr * sp * p, 0, -cr * r, -sr * cp * r - cr * sp * p;
  return T;
}

Matrix3d nearest_rotation(const Matrix3d& M) {
  const Eigen::JacobiSVD<Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

RigidTransform RigidTransform::from_quaternion(const Eigen::Vector4d& q_wxyz, const Vector3d& p) {
  const Eigen::Quaterniond q(q_wxyz[0], q_wxyz[1], q_wxyz[2], q_wxyz[3]);
  return {q.normalized().toRotationMatrix(), p};
}

Eigen::Vector4d RigidTransform::quaternion_wxyz() const {
  const Eigen::Quaterniond q(R);
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  return sign * Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
}

}  // namespace motionlab::math
