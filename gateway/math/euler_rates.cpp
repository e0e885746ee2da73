#include "gateway/math/euler_rates.hpp"

#include <cmath>

namespace motionlab::math {

Matrix3d euler_rates_to_body(const Vector3d& rpy, EulerOrder order) {
  if (order == EulerOrder::zyx) return euler_zyx_rates_to_body(rpy);
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  const double cy = std::cos(rpy.z()), sy = std::sin(rpy.z());
  Matrix3d E;
  E << cp * cy, sy, 0, -cp * sy, cy, 0, sp, 0, 1;
  return E;
}

Matrix3d euler_rates_to_body_dot(const Vector3d& rpy, const Vector3d& rpy_dot, EulerOrder order) {
  if (order == EulerOrder::zyx) return euler_zyx_rates_to_body_dot(rpy, rpy_dot);
  const double cp = std::cos(rpy.y()), sp = std::sin(rpy.y());
  const double cy = std::cos(rpy.z()), sy = std::sin(rpy.z());
  const double p = rpy_dot.y(), y = rpy_dot.z();
  Matrix3d E;
  E << -sp * cy * p - cp * sy * y, cy * y, 0, sp * sy * p - cp * cy * y, -sy * y, 0, cp * p, 0, 0;
  return E;
}

std::optional<Matrix3d> body_to_euler_rates(const Vector3d& rpy, EulerOrder order,
                                            double smallest_cos_pitch) {
  const double cp = std::cos(rpy.y()), tp = std::tan(rpy.y());
  if (!(std::abs(cp) >= smallest_cos_pitch)) return std::nullopt;
  Matrix3d T;
  if (order == EulerOrder::zyx) {
    const double cr = std::cos(rpy.x()), sr = std::sin(rpy.x());
    T << 1, sr * tp, cr * tp, 0, cr, -sr, 0, sr / cp, cr / cp;
  } else {
    const double cy = std::cos(rpy.z()), sy = std::sin(rpy.z());
    T << cy / cp, -sy / cp, 0, sy, cy, 0, -cy * tp, sy * tp, 1;
  }
  return T;
}

std::optional<Matrix3d> body_to_euler_rates_dot(const Vector3d& rpy, const Vector3d& rpy_dot,
                                                EulerOrder order, double smallest_cos_pitch) {
  const auto T = body_to_euler_rates(rpy, order, smallest_cos_pitch);
  if (!T) return std::nullopt;
  return -*T * euler_rates_to_body_dot(rpy, rpy_dot, order) * *T;
}

BodyTurn body_turn(const EulerMotion& motion, EulerOrder order) {
  const Matrix3d E = euler_rates_to_body(motion.rpy_rad, order);
  const Matrix3d Ed = euler_rates_to_body_dot(motion.rpy_rad, motion.rate_radps, order);
  return {E * motion.rate_radps, E * motion.acceleration_radps2 + Ed * motion.rate_radps};
}

std::optional<EulerMotion> euler_motion(const Vector3d& rpy, const BodyTurn& turn, EulerOrder order,
                                        double smallest_cos_pitch) {
  const auto T = body_to_euler_rates(rpy, order, smallest_cos_pitch);
  if (!T) return std::nullopt;
  const Vector3d rate = *T * turn.omega_radps;
  return EulerMotion{rpy, rate, *T * (turn.alpha_radps2 - euler_rates_to_body_dot(rpy, rate, order) * rate)};
}

}  // namespace motionlab::math
