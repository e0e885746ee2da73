#include "gateway/math/pendulum.hpp"

namespace motionlab::math {

using Eigen::Vector2d;

SwingJacobian swing_jacobian(const Vector2d& angles, const Vector2d& rates, const Vector3d& a_WT, double L,
                             double Ld, double gravity) {
  const double sa = std::sin(angles[0]), ca = std::cos(angles[0]);
  const double sb = std::sin(angles[1]), cb = std::cos(angles[1]);
  const double ad = rates[0], bd = rates[1];
  const double x = a_WT.x(), y = a_WT.y(), w = gravity + a_WT.z();
  const double pull_b = -y * cb - w * sb;
  SwingJacobian D;
  D(0, 0) = (-x * sa + y * ca * sb - w * ca * cb) / L - bd * bd * (ca * ca - sa * sa);
  D(0, 1) = (y * sa * cb + w * sa * sb) / L;
  D(0, 2) = -2 * Ld / L;
  D(0, 3) = -2 * bd * sa * ca;
  D(0, 4) = ca / L;
  D(0, 5) = sa * sb / L;
  D(0, 6) = -sa * cb / L;
  D(0, 7) = -(x * ca + y * sa * sb - w * sa * cb - 2 * Ld * ad) / (L * L);
  D(0, 8) = -2 * ad / L;
  D(1, 0) = (pull_b * sa / L + 2 * ad * bd) / (ca * ca);
  D(1, 1) = (y * sb - w * cb) / (L * ca);
  D(1, 2) = 2 * bd * sa / ca;
  D(1, 3) = -2 * Ld / L + 2 * ad * sa / ca;
  D(1, 4) = 0;
  D(1, 5) = -cb / (L * ca);
  D(1, 6) = -sb / (L * ca);
  D(1, 7) = (-pull_b / ca + 2 * Ld * bd) / (L * L);
  D(1, 8) = -2 * bd / L;
  return D;
}

PointMotion load_motion(const PointMotion& tool, const Swing& swing) {
  const double sa = std::sin(swing.angles[0]), ca = std::cos(swing.angles[0]);
  const double sb = std::sin(swing.angles[1]), cb = std::cos(swing.angles[1]);
  const double ad = swing.rates[0], bd = swing.rates[1];
  const Vector3d lambda(-sa, ca * sb, -ca * cb);
  const Vector3d by_a(-ca, -sa * sb, sa * cb), by_b(0, ca * cb, ca * sb);
  const Vector3d by_ab(0, -sa * cb, -sa * sb), by_bb(0, -ca * sb, ca * cb);
  const Vector3d rate = by_a * ad + by_b * bd;
  const Vector3d acceleration = by_a * swing.accelerations[0] + by_b * swing.accelerations[1] -
                                lambda * ad * ad + 2 * by_ab * ad * bd + by_bb * bd * bd;
  const double L = swing.length_m, Ld = swing.length_rate, Ldd = swing.length_acceleration;
  return {tool.p + L * lambda, tool.v + L * rate + Ld * lambda,
          tool.a + L * acceleration + 2 * Ld * rate + Ldd * lambda};
}

double wire_force_per_mass(const PointMotion& load, const Vector3d& lambda, double gravity) {
  return -lambda.dot(load.a + gravity * Vector3d::UnitZ());
}

Vector2d swing_angles(const Vector3d& d) {
  // atan2 on both: keeps its digits where asin(−x/L) loses them, and cannot leave its domain by rounding.
  const double across = std::hypot(d.y(), d.z());
  if (across == 0 && d.x() == 0) return Vector2d::Zero();
  return {std::atan2(-d.x(), across), across == 0 ? 0.0 : std::atan2(d.y(), -d.z())};
}

Vector2d swing_rates(const Vector3d& d, const Vector3d& v) {
  const double across2 = d.y() * d.y() + d.z() * d.z();
  const double across = std::sqrt(across2);
  const double across_rate = (d.y() * v.y() + d.z() * v.z()) / across;
  return {(d.x() * across_rate - v.x() * across) / d.squaredNorm(),
          (d.y() * v.z() - d.z() * v.y()) / across2};
}

}  // namespace motionlab::math
