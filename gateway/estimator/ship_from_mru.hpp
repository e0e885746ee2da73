/// @file  Where a ship is by its motion reference unit alone: no filter, no cameras.
#pragma once

#include "gateway/estimator/belief.hpp"
#include "gateway/math/rotation.hpp"
#include "idl/mru.hpp"

namespace motionlab::estimator {

/// X_WB of one sample: roll and pitch as measured, yaw as at neutral (the unit's drifts), the position the
/// unit's own high-passed one about neutral. Good for a decimetre and a degree; for checks that shall not
/// depend on the estimate.
[[nodiscard]] inline math::RigidTransform ship_from_mru(const MruMount& mount, const topic::Mru& mru) {
  const Eigen::Map<const Eigen::Vector3d> rpy(mru.euler_heading_mru_rad.data());
  const math::Matrix3d R_NB = math::from_euler(rpy, mount.order) * mount.X_BM.R.transpose();
  Eigen::Vector3d rpy_NB = math::to_euler(R_NB, math::EulerOrder::zyx);
  rpy_NB.z() = 0;
  const Eigen::Map<const Eigen::Vector3d> p_NB(mru.p_heading_origin_m.data());
  return mount.X_WN * math::RigidTransform{math::from_euler(rpy_NB, math::EulerOrder::zyx), p_NB};
}

}  // namespace motionlab::estimator
