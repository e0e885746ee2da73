/// @file  Where everything in the laboratory is bolted: as published, and as it truly is in one world.
#pragma once

#include <cstdint>

#include "gateway/math/rotation.hpp"

namespace motionlab::plant {

/// `A_TO_B` is the pose of B in A: p_A = R p_B + p. Defaults: the laboratory's published calibration.
struct Calibration {
  math::RigidTransform world_to_em8000 = math::RigidTransform::from_quaternion(
      {6.0198987883e-05, 0.705931944115, 0.708279565403954, 0.000379322138596},
      {-2.969661622702265, 1.976311036084776, 2.662845015592614});
  math::RigidTransform world_to_em1500 = math::RigidTransform::from_quaternion(
      {0.000269356973877, -0.708291543794578, -0.705919386042796, -0.000914792257884},
      {0.391038069269004, -1.780959676838664, 1.689612471594921});
  math::RigidTransform em8000_to_comau = math::RigidTransform::from_quaternion(
      {0.002461288106714, -0.501408337431486, -0.865206982556575, 0.000706081011787},
      {-1.082024099747949, 1.536041691521612, -1.024461448780775});
  math::RigidTransform world_to_qtm =
      math::RigidTransform::from_quaternion({0.0, 0.7077, 0.7065, 0.0004}, {0.6925, -0.7793, 1.4229});
  math::RigidTransform em8000_to_mru1{Eigen::Matrix3d::Identity(), {-1.289, 0.576, -0.966}};
  math::RigidTransform em1500_to_mru2{Eigen::Matrix3d::Identity(), {0.513, 0.0, -0.169}};
};

/// A copy whose robot base, MRU mounts and camera system are displaced by `offset_m` and turned by
/// `angle_rad`, each in a direction of its own drawn from the seed.
[[nodiscard]] Calibration disturbed(const Calibration& published, double offset_m, double angle_rad,
                                    std::uint64_t seed);

}  // namespace motionlab::plant
