#include "gateway/math/moving_base.hpp"

#include <cmath>

namespace motionlab::math {

Matrix3d rotation_of(const Vector3d& phi) {
  const double angle = phi.norm();
  const Matrix3d K = hat(phi);
  // sin(x)/x and (1 - cos x)/x², with their series where the quotients lose digits.
  const double s = angle > 1e-4 ? std::sin(angle) / angle : 1.0 - angle * angle / 6;
  const double c = angle > 1e-4 ? (1 - std::cos(angle)) / (angle * angle) : 0.5 - angle * angle / 24;
  return Matrix3d::Identity() + s * K + c * K * K;
}

BodyMotion BodyMotion::after(double dt) const {
  BodyMotion next = *this;
  next.X_WB.p += dt * v_WB + 0.5 * dt * dt * a_WB;
  next.X_WB.R = X_WB.R * rotation_of(dt * omega_B + 0.5 * dt * dt * alpha_B);
  next.v_WB += dt * a_WB;
  next.omega_B += dt * alpha_B;
  return next;
}

PointMotion carried(const BodyMotion& body, const PointMotion& in_B) {
  const Matrix3d& R = body.X_WB.R;
  const Vector3d& w = body.omega_B;
  return {
      body.X_WB * in_B.p, body.v_WB + R * (in_B.v + w.cross(in_B.p)),
      body.a_WB + R * (in_B.a + 2 * w.cross(in_B.v) + body.alpha_B.cross(in_B.p) + w.cross(w.cross(in_B.p)))};
}

}  // namespace motionlab::math
