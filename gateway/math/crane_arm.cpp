#include "gateway/math/crane_arm.hpp"

#include <cmath>

namespace motionlab::math {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d CraneArm::position(const Vector3d& q) const {
  const double s2 = std::sin(q[1]), c2 = std::cos(q[1]), s3 = std::sin(q[2]), c3 = std::cos(q[2]);
  const double rho = g_.a1_m + g_.a2_m * s2 - g_.a3_m * c3 - g_.reach_m * s3;
  const double z = g_.d1_m + g_.a2_m * c2 - g_.a3_m * s3 + g_.reach_m * c3;
  return {std::cos(q[0]) * rho, -std::sin(q[0]) * rho, z};
}

Matrix3d CraneArm::jacobian(const Vector3d& q) const {
  const double s1 = std::sin(q[0]), c1 = std::cos(q[0]);
  const double s2 = std::sin(q[1]), c2 = std::cos(q[1]), s3 = std::sin(q[2]), c3 = std::cos(q[2]);
  const double rho = g_.a1_m + g_.a2_m * s2 - g_.a3_m * c3 - g_.reach_m * s3;
  const double rho2 = g_.a2_m * c2, rho3 = g_.a3_m * s3 - g_.reach_m * c3;
  const double z2 = -g_.a2_m * s2, z3 = -g_.a3_m * c3 - g_.reach_m * s3;
  Matrix3d J;
  J << -s1 * rho, c1 * rho2, c1 * rho3, -c1 * rho, -s1 * rho2, -s1 * rho3, 0, z2, z3;
  return J;
}

Matrix3d CraneArm::jacobian_dot(const Vector3d& q, const Vector3d& qd) const {
  const double s1 = std::sin(q[0]), c1 = std::cos(q[0]);
  const double s2 = std::sin(q[1]), c2 = std::cos(q[1]), s3 = std::sin(q[2]), c3 = std::cos(q[2]);
  const double rho = g_.a1_m + g_.a2_m * s2 - g_.a3_m * c3 - g_.reach_m * s3;
  const double rho2 = g_.a2_m * c2, rho3 = g_.a3_m * s3 - g_.reach_m * c3;
  const double rho_dot = rho2 * qd[1] + rho3 * qd[2];
  const double rho2_dot = -g_.a2_m * s2 * qd[1], rho3_dot = (g_.a3_m * c3 + g_.reach_m * s3) * qd[2];
  const double z2_dot = -g_.a2_m * c2 * qd[1], z3_dot = (g_.a3_m * s3 - g_.reach_m * c3) * qd[2];
  Matrix3d Jd;
  Jd << -c1 * qd[0] * rho - s1 * rho_dot, -s1 * qd[0] * rho2 + c1 * rho2_dot,
      -s1 * qd[0] * rho3 + c1 * rho3_dot, s1 * qd[0] * rho - c1 * rho_dot, -c1 * qd[0] * rho2 - s1 * rho2_dot,
      -c1 * qd[0] * rho3 - s1 * rho3_dot, 0, z2_dot, z3_dot;
  return Jd;
}

std::optional<Vector3d> CraneArm::inverse(const Vector3d& p_RT) const {
  // In the vertical plane of the arm, with x along the reach and z up from the shoulder, the upper arm ends
  // at a2 (s2, c2) and the forearm adds C (cos(q3 + pi - gamma), sin(q3 + pi - gamma)) with C e^{i gamma} =
  // a3 + i reach: its angle above the horizontal is fixed by joint 3 alone, because joint 3 is measured
  // against the vertical.
  const double x = std::hypot(p_RT.x(), p_RT.y()) - g_.a1_m;
  const double z = p_RT.z() - g_.d1_m;
  const double C = std::hypot(g_.a3_m, g_.reach_m);
  const double gamma = std::atan2(g_.reach_m, g_.a3_m);
  const double D2 = x * x + z * z;
  const double D = std::sqrt(D2);
  const double cos_shoulder = (D2 + g_.a2_m * g_.a2_m - C * C) / (2 * g_.a2_m * D);
  if (!(std::abs(cos_shoulder) <= 1.0)) return std::nullopt;
  // The upper arm stands above the line from shoulder to tool: elbow up.
  const double upper = std::atan2(z, x) + std::acos(cos_shoulder);
  const double fx = x - g_.a2_m * std::cos(upper), fz = z - g_.a2_m * std::sin(upper);
  const double forearm = std::atan2(fz, fx);
  // (fx, fz) = (-a3 c3 - reach s3, -a3 s3 + reach c3) = C (-cos(q3 - gamma), -sin(q3 - gamma))
  const double pi = std::acos(-1.0);
  double q3 = forearm - pi + gamma;
  q3 -= 2 * pi * std::round(q3 / (2 * pi));
  return Vector3d{std::atan2(-p_RT.y(), p_RT.x()), pi / 2 - upper, q3};
}

}  // namespace motionlab::math
