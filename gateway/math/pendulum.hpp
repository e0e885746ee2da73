/// @file  A point load on a massless wire below a moving point: Lagrange's equations of the thesis
/// (Eq 3.46–3.57), in world axes with z **up**. Pure functions; gravity is given by the caller.
///
/// The wire hangs along lambda = (−sin a, cos a sin b, −cos a cos b) from the tool point T, so that the load
/// is at p_WL = p_WT + L lambda. a (alpha) and b (beta) are angles against gravity, not against the platform.
/// The thesis feeds these z-up equations with accelerations of its z-down frame (Eq 3.81/3.82 without R_n^g):
/// give them accelerations of the world. Singular at |a| = 90°.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "gateway/math/moving_base.hpp"

namespace motionlab::math {

template <class Scalar>
using Vector2 = Eigen::Matrix<Scalar, 2, 1>;
template <class Scalar>
using Vector3 = Eigen::Matrix<Scalar, 3, 1>;

/// lambda(a, b), the unit vector from the tool point to the load, expressed in W. Thesis Eq 3.46–3.48.
template <class Scalar>
[[nodiscard]] Vector3<Scalar> wire_direction(const Vector2<Scalar>& angles) {
  using std::cos;
  using std::sin;
  const Scalar a = angles[0], b = angles[1];
  return {-sin(a), cos(a) * sin(b), -cos(a) * cos(b)};
}

/// (a'', b'') of the swing. Thesis Eq 3.56 and 3.57; the sign of 2 L' b' cos a is that of Eq 3.57, which
/// holds (the MATLAB code of the thesis, C.2.1 and C.6.1, has it wrong).
/// @param angles       (a, b) [rad]
/// @param rates        (a', b') [rad/s]
/// @param a_WT         acceleration of the tool point in the world, z up [m/s²]
/// @param length_m     wire length, positive
/// @param length_rate  its derivative, positive when paying out [m/s]
/// @param gravity      [m/s²]
template <class Scalar>
[[nodiscard]] Vector2<Scalar> swing_acceleration(const Vector2<Scalar>& angles, const Vector2<Scalar>& rates,
                                                 const Vector3<Scalar>& a_WT, const Scalar& length_m,
                                                 const Scalar& length_rate, double gravity) {
  using std::cos;
  using std::sin;
  const Scalar sa = sin(angles[0]), ca = cos(angles[0]), sb = sin(angles[1]), cb = cos(angles[1]);
  const Scalar w = gravity + a_WT[2];
  const Scalar add =
      (a_WT[0] * ca + a_WT[1] * sa * sb - w * sa * cb - 2.0 * length_rate * rates[0]) / length_m -
      rates[1] * rates[1] * sa * ca;
  const Scalar bdd = (-a_WT[1] * cb - w * sb) / (length_m * ca) - 2.0 * length_rate * rates[1] / length_m +
                     2.0 * rates[0] * rates[1] * sa / ca;
  return {add, bdd};
}

/// p'' of the pendulum in a vertical plane, load at x + L sin p. Thesis Eq 3.38 and 3.45 with free height.
template <class Scalar>
[[nodiscard]] Scalar planar_swing_acceleration(const Scalar& angle, const Scalar& rate, const Scalar& a_x,
                                               const Scalar& a_z, const Scalar& length_m,
                                               const Scalar& length_rate, double gravity) {
  using std::cos;
  using std::sin;
  return (-a_x * cos(angle) - (gravity + a_z) * sin(angle) - 2.0 * length_rate * rate) / length_m;
}

/// The derivative of `swing_acceleration` with respect to (a, b, a', b', x'', y'', z'', L, L'). 2x9.
using SwingJacobian = Eigen::Matrix<double, 2, 9>;
[[nodiscard]] SwingJacobian swing_jacobian(const Eigen::Vector2d& angles, const Eigen::Vector2d& rates,
                                           const Eigen::Vector3d& a_WT, double length_m, double length_rate,
                                           double gravity);

/// Swing and wire at one moment.
struct Swing {
  Eigen::Vector2d angles = Eigen::Vector2d::Zero();         ///< (a, b) [rad]
  Eigen::Vector2d rates = Eigen::Vector2d::Zero();          ///< [rad/s]
  Eigen::Vector2d accelerations = Eigen::Vector2d::Zero();  ///< [rad/s²]
  double length_m = 1.0;
  double length_rate = 0.0;          ///< [m/s]
  double length_acceleration = 0.0;  ///< [m/s²]
};

/// Position, velocity and acceleration of the load in W, from those of the tool point.
[[nodiscard]] PointMotion load_motion(const PointMotion& tool, const Swing& swing);

/// The force in the wire per kilogram of load [N/kg]; negative would mean a slack wire, which these equations
/// do not know.
[[nodiscard]] double wire_force_per_mass(const PointMotion& load, const Eigen::Vector3d& lambda,
                                         double gravity);

/// (a, b) of a wire vector p_TL expressed in W, a in [−90°, 90°]. Thesis Eq 3.89/3.90, which hold only for a
/// vector that was turned into the world first. Both angles are zero for a vector of no length.
[[nodiscard]] Eigen::Vector2d swing_angles(const Eigen::Vector3d& p_TL_W);

/// (a', b') of a wire vector that changes at the rate v_TL, both expressed in W. @pre not horizontal along x
[[nodiscard]] Eigen::Vector2d swing_rates(const Eigen::Vector3d& p_TL_W, const Eigen::Vector3d& v_TL_W);

}  // namespace motionlab::math
