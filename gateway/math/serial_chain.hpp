/// @file  Serial chains of revolute joints by Denavit and Hartenberg (classic convention, thesis Eq 3.1):
/// A_i = Rz(theta_i) Tz(d_i) Tx(a_i) Rx(alpha_i). The numbers of a certain arm are given by the caller;
/// nothing is allocated.
///
/// Frames: R the base (frame 0), 1 … N the links, F = N the flange, T the tool. Joint values are those of the
/// arm's own plates; `JointMap` says how they make Denavit–Hartenberg angles.
#pragma once

#include <Eigen/Core>
#include <array>

#include "gateway/math/rotation.hpp"

namespace motionlab::math {

/// What does not move in one joint-and-link.
struct DhLink {
  double d_m = 0;        ///< offset along the joint axis
  double a_m = 0;        ///< length of the link
  double alpha_rad = 0;  ///< twist of the link
};

/// theta = S q + offset, from plate values q to Denavit–Hartenberg angles theta. S carries the signs (−1
/// where the plate counts clockwise) and the couplings (a joint that is measured against the vertical and not
/// against the link before it). @pre S invertible
template <int N>
struct JointMap {
  Eigen::Matrix<double, N, N> S = Eigen::Matrix<double, N, N>::Identity();
  Eigen::Matrix<double, N, 1> offset_rad = Eigen::Matrix<double, N, 1>::Zero();
};

/// When `SerialChain::inverse` may stop, and how far it may go in one step.
struct InverseOptions {
  double position_tolerance_m = 1e-9;
  double rotation_tolerance_rad = 1e-9;
  double length_m = 1.0;          ///< a turn of 1 rad weighs as much as this distance
  double largest_step_rad = 0.5;  ///< of any joint
  int most_iterations = 100;
};

/// Where `SerialChain::inverse` came to.
template <int N>
struct InverseResult {
  Eigen::Matrix<double, N, 1> q;  ///< the best posture found, plate values
  bool reached = false;           ///< both tolerances hold
  int iterations = 0;
  double position_error_m = 0;
  double rotation_error_rad = 0;
};

/// An arm of N joints, 1 to 6.
template <int N>
class SerialChain {
 public:
  static_assert(N >= 1 && N <= 6);
  using Joints = Eigen::Matrix<double, N, 1>;
  using Jacobian = Eigen::Matrix<double, 6, N>;
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  /// Poses in the base of the base itself, of each link and, last, of the tool.
  using Frames = std::array<RigidTransform, N + 2>;

  SerialChain(const std::array<DhLink, N>& links, const JointMap<N>& joints,
              const RigidTransform& X_flange_tool = {});

  /// X_RT(q).
  [[nodiscard]] RigidTransform tool(const Joints& q) const;
  [[nodiscard]] Frames frames(const Joints& q) const;

  /// The geometric Jacobian: [v_RT; omega_RT] = J q', both expressed in the base, v of the tool point. 6xN.
  [[nodiscard]] Jacobian jacobian(const Joints& q) const;
  /// dJ/dt along q'. 6xN.
  [[nodiscard]] Jacobian jacobian_dot(const Joints& q, const Joints& qd) const;
  /// Linear and angular acceleration of the tool, J q'' + J' q', expressed in the base.
  [[nodiscard]] Vector6 acceleration(const Joints& q, const Joints& qd, const Joints& qdd) const;

  /// Plate values that bring the tool to X_RT, by damped least squares (Levenberg–Marquardt) from `start`. A
  /// local search: it finds the posture near the start, and says when it did not get there. Where the pose
  /// cannot be reached it ends as near as it can come.
  [[nodiscard]] InverseResult<N> inverse(const RigidTransform& X_RT, const Joints& start,
                                         const InverseOptions& options = {}) const;

 private:
  struct Link {
    double d, a, cos_alpha, sin_alpha;
  };
  struct Posture;
  [[nodiscard]] Posture posture(const Joints& q) const;
  [[nodiscard]] Jacobian jacobian(const Posture& at) const;

  std::array<Link, N> links_;
  JointMap<N> joints_;
  RigidTransform X_FT_;
};

extern template class SerialChain<1>;
extern template class SerialChain<3>;
extern template class SerialChain<6>;

}  // namespace motionlab::math
