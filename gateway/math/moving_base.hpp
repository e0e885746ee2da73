/// @file  Motion of a point that moves on a moving body: position, velocity and acceleration in the world.
#pragma once

#include "gateway/math/rotation.hpp"

namespace motionlab::math {

/// How a body moves: the pose of B in W, with its derivatives.
struct BodyMotion {
  RigidTransform X_WB;
  Vector3d v_WB = Vector3d::Zero();     ///< velocity of B's origin, expressed in W [m/s]
  Vector3d a_WB = Vector3d::Zero();     ///< acceleration of B's origin, expressed in W [m/s²]
  Vector3d omega_B = Vector3d::Zero();  ///< rate of turn, expressed in B [rad/s]
  Vector3d alpha_B = Vector3d::Zero();  ///< its time derivative, expressed in B [rad/s²]

  /// The motion a short time later, with constant linear and angular acceleration.
  [[nodiscard]] BodyMotion after(double dt_s) const;
};

/// Position, velocity and acceleration of a point.
struct PointMotion {
  Vector3d p = Vector3d::Zero();
  Vector3d v = Vector3d::Zero();
  Vector3d a = Vector3d::Zero();
};

/// The motion in W of a point whose motion relative to B, expressed in B, is given (transport theorem).
[[nodiscard]] PointMotion carried(const BodyMotion& body, const PointMotion& in_B);

/// The rotation exp(hat(phi)) by the vector phi. 3x3.
[[nodiscard]] Matrix3d rotation_of(const Vector3d& phi);

}  // namespace motionlab::math
