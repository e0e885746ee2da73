/// @file  A ship platform as a rigid body in the world.
#pragma once

#include "gateway/math/rotation.hpp"
#include "simulators/plant/sea.hpp"

namespace motionlab::plant {

/// Pose and motion of a platform's body frame B.
struct PlatformState {
  math::RigidTransform X_WB;
  Eigen::Vector3d v_WB = Eigen::Vector3d::Zero();        ///< of B's origin, in W [m/s]
  Eigen::Vector3d a_WB = Eigen::Vector3d::Zero();        ///< of B's origin, in W [m/s²]
  Eigen::Vector3d omega_WB_B = Eigen::Vector3d::Zero();  ///< in B [rad/s]
  Eigen::Vector3d alpha_WB_B = Eigen::Vector3d::Zero();  ///< in B [rad/s²]
};

/// The platform at the given coordinates, its neutral frame N standing at X_WN.
[[nodiscard]] PlatformState platform_state(const math::RigidTransform& X_WN, const ShipCoordinates& ship);

/// Motion of a point of the platform in world; it may itself move in B.
struct PointMotion {
  Eigen::Vector3d p_W;
  Eigen::Vector3d v_W;
  Eigen::Vector3d a_W;
};
[[nodiscard]] PointMotion point_of(const PlatformState& platform, const Eigen::Vector3d& p_B,
                                   const Eigen::Vector3d& v_B = Eigen::Vector3d::Zero(),
                                   const Eigen::Vector3d& a_B = Eigen::Vector3d::Zero());

}  // namespace motionlab::plant
