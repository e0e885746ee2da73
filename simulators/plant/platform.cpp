#include "simulators/plant/platform.hpp"

namespace motionlab::plant {

using Eigen::Vector3d;

PlatformState platform_state(const math::RigidTransform& X_WN, const ShipCoordinates& ship) {
  const Vector3d rpy = ship.eta.tail<3>(), rate = ship.eta_dot.tail<3>();
  const Eigen::Matrix3d T = math::euler_zyx_rates_to_body(rpy);
  PlatformState s;
  s.X_WB.R = X_WN.R * math::from_euler(rpy, math::EulerOrder::zyx);
  s.X_WB.p = X_WN.R * ship.eta.head<3>() + X_WN.p;
  s.v_WB = X_WN.R * ship.eta_dot.head<3>();
  s.a_WB = X_WN.R * ship.eta_ddot.head<3>();
  s.omega_WB_B = T * rate;
  s.alpha_WB_B = T * ship.eta_ddot.tail<3>() + math::euler_zyx_rates_to_body_dot(rpy, rate) * rate;
  return s;
}

PointMotion point_of(const PlatformState& s, const Vector3d& p_B, const Vector3d& v_B, const Vector3d& a_B) {
  const Vector3d& w = s.omega_WB_B;
  const Vector3d wxp = w.cross(p_B);
  return {s.X_WB * p_B, s.v_WB + s.X_WB.R * (wxp + v_B),
          s.a_WB + s.X_WB.R * (s.alpha_WB_B.cross(p_B) + w.cross(wxp) + 2 * w.cross(v_B) + a_B)};
}

}  // namespace motionlab::plant
