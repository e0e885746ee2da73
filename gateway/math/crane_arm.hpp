/// @file  Kinematics of a three-axis crane arm with a parallel-link elbow (joint 3 is measured against the
/// vertical). Closed forms of thesis Eq 3.2–3.31; the numbers of a certain arm are given by the caller.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace motionlab::math {

/// Lengths of the arm, in m. `reach` is all that lies in line with the forearm: forearm, wrist and tool.
struct CraneArmGeometry {
  double a1_m = 0;
  double a2_m = 0;
  double a3_m = 0;
  double d1_m = 0;
  double reach_m = 0;  ///< d4 + d6 + d_tool
};

/// The tool point of the arm, wrist held at zero. Joint values in rad as on the arm's own plates: joint 1
/// clockwise seen from above, joint 3 against the vertical.
class CraneArm {
 public:
  explicit CraneArm(const CraneArmGeometry& geometry) : g_(geometry) {}

  /// p_RT(q): tool point from the robot base, expressed in the base (z up), in m.
  [[nodiscard]] Eigen::Vector3d position(const Eigen::Vector3d& q) const;
  /// J(q) with v_RT = J q̇. 3x3.
  [[nodiscard]] Eigen::Matrix3d jacobian(const Eigen::Vector3d& q) const;
  /// dJ/dt along q̇. 3x3.
  [[nodiscard]] Eigen::Matrix3d jacobian_dot(const Eigen::Vector3d& q, const Eigen::Vector3d& qd) const;
  /// The joint values with the elbow up (the home branch) that bring the tool to p_RT, reaching forward.
  /// Nothing when the point is out of reach.
  [[nodiscard]] std::optional<Eigen::Vector3d> inverse(const Eigen::Vector3d& p_RT) const;

  [[nodiscard]] const CraneArmGeometry& geometry() const { return g_; }

 private:
  CraneArmGeometry g_;
};

}  // namespace motionlab::math
