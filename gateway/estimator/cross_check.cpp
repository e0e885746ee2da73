#include "gateway/estimator/cross_check.hpp"

#include "gateway/estimator/ship_from_mru.hpp"

namespace motionlab::estimator {

void CrossCheck::step(const Inputs& in) {
  if (!in.mru || !(in.dt_s > 0)) return;
  const math::RigidTransform X_WB = ship_from_mru(mount_, *in.mru);
  if (in.platform && in.platform->tracked) {
    const auto X_QP = math::RigidTransform::from_quaternion(
        Eigen::Map<const Eigen::Vector4d>(in.platform->q_camera_body.data()),
        Eigen::Map<const Eigen::Vector3d>(in.platform->p_camera_body_m.data()));
    const math::RigidTransform X_WB_seen = calibration_.X_WQ * X_QP * calibration_.X_BP.inverse();
    const auto tilt = [&](const math::Matrix3d& R_WB) -> Eigen::Vector2d {
      return math::to_euler(mount_.X_WN.R.transpose() * R_WB, math::EulerOrder::zyx).head<2>();
    };
    tilt_.add(tilt(X_WB_seen.R) - tilt(X_WB.R), in.dt_s, kTiltMemory_s);
  }
  if (in.load && in.load->tracked && in.arm && in.winch) {
    const Eigen::Map<const Eigen::Vector3d> q(in.arm->q_rad.data());
    const Eigen::Vector3d p_WT = X_WB * (calibration_.X_BR * arm_.position(q));
    const Eigen::Vector3d expected = p_WT - Eigen::Vector3d(0, 0, in.winch->wire_length_m);
    const Eigen::Vector3d seen =
        calibration_.X_WQ * Eigen::Map<const Eigen::Vector3d>(in.load->p_camera_body_m.data());
    load_.add(seen - expected, in.dt_s, kLoadMemory_s);
  }
}

}  // namespace motionlab::estimator
