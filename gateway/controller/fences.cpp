#include "gateway/controller/fences.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::controller {
namespace {

/// Distance of a point from a sphere, `slope` along which the point moves.
Fence around(const Eigen::Vector3d& p, const Eigen::Vector3d& centre, double radius,
             const Eigen::Matrix<double, 3, 7>& slope) {
  const Eigen::Vector3d away = p - centre;
  const double distance = away.norm();
  Fence fence{FenceKind::second_platform, distance - radius, {}};
  // At the very centre every direction leads out.
  fence.slope = distance > 0 ? (away.transpose() / distance * slope).transpose() : Fence{}.slope;
  return fence;
}

}  // namespace

std::array<Fence, kFences> fences(const FenceLimits& limits, const Eigen::Vector3d& q, double wire_length_m,
                                  const math::RigidTransform& X_WR) {
  const math::CraneArm arm(limits.arm);
  const Eigen::Vector3d p_RT = arm.position(q);
  Eigen::Matrix<double, 3, 7> slope_RT = Eigen::Matrix<double, 3, 7>::Zero();
  slope_RT.leftCols<3>() = arm.jacobian(q);
  const Eigen::Matrix<double, 3, 7> slope_WT = X_WR.R * slope_RT;
  Eigen::Matrix<double, 3, 7> slope_WL = slope_WT;
  slope_WL(2, 6) = -1.0;
  const Eigen::Vector3d p_WT = X_WR * p_RT;
  const Eigen::Vector3d p_WL = p_WT - Eigen::Vector3d(0, 0, wire_length_m);

  std::array<Fence, kFences> all;
  for (Eigen::Index i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(2 * i);
    all[k] = {FenceKind::workspace, p_RT[i] - limits.p_base_tool_min_m[i], slope_RT.row(i).transpose()};
    all[k + 1] = {FenceKind::workspace, limits.p_base_tool_max_m[i] - p_RT[i], -slope_RT.row(i).transpose()};
  }
  all[6] = {FenceKind::floor, p_WL.z() - limits.load_height_min_m, slope_WL.row(2).transpose()};
  all[7] = around(p_WT, limits.p_world_second_m, limits.distance_to_second_min_m, slope_WT);
  all[8] = around(p_WL, limits.p_world_second_m, limits.distance_to_second_min_m, slope_WL);
  return all;
}

double share_that_fits(const Fence& fence, const Eigen::Matrix<double, 7, 1>& speeds,
                       const Eigen::Matrix<double, 7, 1>& decelerations) {
  // What goes away from the fence is not counted: it may come to rest first.
  const Eigen::Array<double, 7, 1> nearer = (-fence.slope.array() * speeds.array()).max(0.0);
  const double way = (nearer * speeds.array().abs() / (2.0 * decelerations.array())).sum();
  if (way <= std::max(0.0, fence.distance_m)) return 1.0;
  return std::sqrt(std::max(0.0, fence.distance_m) / way);
}

}  // namespace motionlab::controller
