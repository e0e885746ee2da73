/// @file  Kinematics of a three-axis crane arm with a parallel-link elbow (joint 3 is measured against the
/// vertical). Closed forms of thesis Eq 3.2–3.31; the numbers of a certain arm are given by the caller.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "gateway/math/joint_limits.hpp"

namespace motionlab::math {

/// Lengths of the arm, in m. `reach` is all that lies in line with the forearm: forearm, wrist and tool.
struct CraneArmGeometry {
  double a1_m = 0;
  double a2_m = 0;
  double a3_m = 0;
  double d1_m = 0;
  double reach_m = 0;  ///< d4 + d6 + d_tool
};

/// Whether a point lies within the arm's reach, and if not, why.
enum class Reach {
  reached,
  too_far,
  too_near,  ///< nearer to the shoulder than the folded arm, or on the axis of joint 1, which has no
             ///< direction
};

/// One way to stand at a point.
struct CranePosture {
  Eigen::Vector3d q;  ///< plate values [rad], turned by whole turns into the limits where that is possible
  bool within_limits = false;
};

/// All ways to stand at a point, reaching forward.
struct CraneInverse {
  Reach reach = Reach::too_far;
  double shoulder_distance_m = 0;  ///< from the axis of joint 2 to the point
  double nearest_m = 0;            ///< the distances the arm can span, joints free
  double farthest_m = 0;
  std::optional<CranePosture> elbow_up;    ///< minus root, the home branch (the thesis' text below Eq 3.24
                                           ///< has the two exchanged)
  std::optional<CranePosture> elbow_down;  ///< plus root

  /// The posture within limits, elbow up if there is a choice.
  [[nodiscard]] std::optional<Eigen::Vector3d> best() const;
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

  /// Both branches (thesis Eq 3.15–3.31), the reach and the limits, reported.
  [[nodiscard]] CraneInverse inverse(const Eigen::Vector3d& p_RT, const JointLimits<3>& limits) const;
  /// J q'' + J' q', expressed in the base [m/s²]. (The thesis' C.1.1 writes J' q'' where J q'' belongs.)
  [[nodiscard]] Eigen::Vector3d acceleration(const Eigen::Vector3d& q, const Eigen::Vector3d& qd,
                                             const Eigen::Vector3d& qdd) const;

  [[nodiscard]] const CraneArmGeometry& geometry() const { return g_; }

 private:
  [[nodiscard]] Eigen::Vector3d posture(const Eigen::Vector3d& p_RT, double elbow) const;

  CraneArmGeometry g_;
};

}  // namespace motionlab::math
