#include "gateway/estimator/ship_states.hpp"

namespace motionlab::estimator {

math::Matrix3d level_frame(const math::Matrix3d& R_WN) {
  math::Matrix3d R_WD;
  R_WD.col(2) = -Eigen::Vector3d::UnitZ();
  R_WD.col(0) = (R_WN.col(0) - R_WN.col(0).z() * Eigen::Vector3d::UnitZ()).normalized();
  R_WD.col(1) = R_WD.col(2).cross(R_WD.col(0));
  return R_WD;
}

math::BodyMotion ShipView::motion() const {
  const Vector3d rpy = triple(0, 3), rpy_dot = triple(1, 3), rpy_ddot = triple(2, 3);
  const math::Matrix3d T = math::euler_zyx_rates_to_body(rpy);
  return {{R_WD_ * math::from_euler(rpy, math::EulerOrder::zyx), p_WN_ + triple(0, 0)},
          triple(1, 0),
          triple(2, 0),
          T * rpy_dot,
          T * rpy_ddot + math::euler_zyx_rates_to_body_dot(rpy, rpy_dot) * rpy_dot};
}

}  // namespace motionlab::estimator
