/// @file  Places where tool and load must not come, as distances that a posture has to them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "gateway/math/crane_arm.hpp"
#include "gateway/math/rotation.hpp"

namespace motionlab::controller {

/// Where tool and load may be. The guard's own copy. The tool is the crane's with its wrist at zero, the load
/// hangs plumb: clearances have to leave room for the wrist's ten degrees and for swing.
struct FenceLimits {
  math::CraneArmGeometry arm;
  Eigen::Vector3d p_base_tool_min_m;  ///< box for the tool, axes of the robot's base
  Eigen::Vector3d p_base_tool_max_m;
  double load_height_min_m = 0;           ///< of the load above the world's z = 0, the floor
  Eigen::Vector3d p_world_second_m;       ///< the second platform at neutral …
  double distance_to_second_min_m = 0.0;  ///< … which tool and load stay away from by this
};

/// Bits of what is fenced, in the order of `fences`.
enum class FenceKind { workspace, floor, second_platform };

/// The distance to one fence, and how it changes with the joints and the wire.
struct Fence {
  FenceKind kind{};
  double distance_m = 0;               ///< negative: beyond it
  Eigen::Matrix<double, 7, 1> slope =  ///< d distance / d (q1 … q6 [rad], wire [m])
      Eigen::Matrix<double, 7, 1>::Zero();
};

inline constexpr std::size_t kFences = 9;

/// All fences from one posture: six sides of the box, the floor, the second platform from tool and from load.
/// @param X_WR  robot base in world
[[nodiscard]] std::array<Fence, kFences> fences(const FenceLimits& limits, const Eigen::Vector3d& q_rad,
                                                double wire_length_m, const math::RigidTransform& X_WR);

/// How much of a motion fits before a fence: at s times these speeds, every joint and the wire braking at its
/// own deceleration, it comes to rest where the fence is. 1 when all of it fits, 0 beyond the fence for a
/// motion that goes further beyond.
/// @param speeds  q̇ [rad/s] of six joints, wire [m/s];  @param decelerations  likewise, > 0
[[nodiscard]] double share_that_fits(const Fence& fence, const Eigen::Matrix<double, 7, 1>& speeds,
                                     const Eigen::Matrix<double, 7, 1>& decelerations);

}  // namespace motionlab::controller
