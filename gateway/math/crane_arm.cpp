#include "gateway/math/crane_arm.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace motionlab::math {

using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {
constexpr double kPi = std::numbers::pi;
}

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

Vector3d CraneArm::acceleration(const Vector3d& q, const Vector3d& qd, const Vector3d& qdd) const {
  return jacobian(q) * qdd + jacobian_dot(q, qd) * qd;
}

Vector3d CraneArm::posture(const Vector3d& p_RT, double elbow) const {
  // In the vertical plane of the arm, with x along the reach and z up from the shoulder, the upper arm ends
  // at a2 (s2, c2) and the forearm adds C (cos(q3 + pi - gamma), sin(q3 + pi - gamma)) with C e^{i gamma} =
  // a3 + i reach: its angle above the horizontal is fixed by joint 3 alone, because joint 3 is measured
  // against the vertical.
  const double x = std::hypot(p_RT.x(), p_RT.y()) - g_.a1_m;
  const double z = p_RT.z() - g_.d1_m;
  const double C = std::hypot(g_.a3_m, g_.reach_m);
  const double gamma = std::atan2(g_.reach_m, g_.a3_m);
  const double D2 = x * x + z * z;
  const double cos_shoulder = (D2 + g_.a2_m * g_.a2_m - C * C) / (2 * g_.a2_m * std::sqrt(D2));
  const double upper = std::atan2(z, x) + elbow * std::acos(std::clamp(cos_shoulder, -1.0, 1.0));
  const double fx = x - g_.a2_m * std::cos(upper), fz = z - g_.a2_m * std::sin(upper);
  const double forearm = std::atan2(fz, fx);
  // (fx, fz) = (-a3 c3 - reach s3, -a3 s3 + reach c3) = C (-cos(q3 - gamma), -sin(q3 - gamma))
  double q3 = forearm - kPi + gamma;
  q3 -= 2 * kPi * std::round(q3 / (2 * kPi));
  return {std::atan2(-p_RT.y(), p_RT.x()), kPi / 2 - upper, q3};
}

CraneInverse CraneArm::inverse(const Vector3d& p_RT, const JointLimits<3>& limits) const {
  const double C = std::hypot(g_.a3_m, g_.reach_m);
  const double rho = std::hypot(p_RT.x(), p_RT.y());
  CraneInverse all;
  all.shoulder_distance_m = std::hypot(rho - g_.a1_m, p_RT.z() - g_.d1_m);
  all.nearest_m = std::abs(C - g_.a2_m);
  all.farthest_m = C + g_.a2_m;
  if (!(all.shoulder_distance_m <= all.farthest_m)) return all;
  all.reach = Reach::too_near;
  if (!(all.shoulder_distance_m >= all.nearest_m) || !(rho > 0)) return all;
  all.reach = Reach::reached;
  const auto within = [&limits](Vector3d q) {
    for (int i = 0; i < 3; ++i) {
      const double middle = 0.5 * (limits.min_rad[i] + limits.max_rad[i]);
      q[i] -= 2 * kPi * std::round((q[i] - middle) / (2 * kPi));
    }
    return CranePosture{q, limits.contain(q)};
  };
  all.elbow_up = within(posture(p_RT, +1));
  all.elbow_down = within(posture(p_RT, -1));
  return all;
}

std::optional<Vector3d> CraneInverse::best() const {
  if (elbow_up && elbow_up->within_limits) return elbow_up->q;
  if (elbow_down && elbow_down->within_limits) return elbow_down->q;
  return std::nullopt;
}

std::optional<Vector3d> CraneArm::inverse(const Vector3d& p_RT) const {
  const double x = std::hypot(p_RT.x(), p_RT.y()) - g_.a1_m;
  const double distance = std::hypot(x, p_RT.z() - g_.d1_m);
  const double C = std::hypot(g_.a3_m, g_.reach_m);
  if (!(distance <= C + g_.a2_m && distance >= std::abs(C - g_.a2_m))) return std::nullopt;
  return posture(p_RT, +1);
}

}  // namespace motionlab::math
