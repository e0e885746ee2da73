/// @file  Rotations and Denavit–Hartenberg products for any scalar, written from their definitions and from
/// nothing of ours: the second opinion of the tests, fit for complex steps.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <complex>

namespace motionlab::test {

using Complex = std::complex<double>;
inline constexpr double kStep = 1e-40;

template <class S>
using Matrix4 = Eigen::Matrix<S, 4, 4>;
template <class S>
using Mat3 = Eigen::Matrix<S, 3, 3>;

template <class S>
Mat3<S> turn_x(S a) {
  using std::cos, std::sin;
  Mat3<S> R = Mat3<S>::Identity();
  R(1, 1) = R(2, 2) = cos(a);
  R(2, 1) = sin(a);
  R(1, 2) = -sin(a);
  return R;
}
template <class S>
Mat3<S> turn_y(S a) {
  using std::cos, std::sin;
  Mat3<S> R = Mat3<S>::Identity();
  R(0, 0) = R(2, 2) = cos(a);
  R(0, 2) = sin(a);
  R(2, 0) = -sin(a);
  return R;
}
template <class S>
Mat3<S> turn_z(S a) {
  using std::cos, std::sin;
  Mat3<S> R = Mat3<S>::Identity();
  R(0, 0) = R(1, 1) = cos(a);
  R(1, 0) = sin(a);
  R(0, 1) = -sin(a);
  return R;
}

/// Thesis Eq 3.1 as the product of its four factors.
template <class S>
Matrix4<S> dh(S theta, double d, double a, double alpha) {
  Matrix4<S> Rz = Matrix4<S>::Identity(), Tz = Rz, Tx = Rz, Rx = Rz;
  Rz.template topLeftCorner<3, 3>() = turn_z<S>(theta);
  Tz(2, 3) = d;
  Tx(0, 3) = a;
  Rx.template topLeftCorner<3, 3>() = turn_x<S>(S(alpha));
  return Rz * Tz * Tx * Rx;
}

inline Eigen::Vector3d unhat(const Eigen::Matrix3d& W) {
  return 0.5 * Eigen::Vector3d(W(2, 1) - W(1, 2), W(0, 2) - W(2, 0), W(1, 0) - W(0, 1));
}

}  // namespace motionlab::test
