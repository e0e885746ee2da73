/// @file  A point that goes to its target with bounded speed, acceleration and jerk.
#pragma once

#include <Eigen/Core>

namespace motionlab::controller {

struct SmoothPointLimits {
  double omega_radps = 1.2;  ///< how briskly it goes; the last metres are critically damped
  double speed_mps = 0.30;
  double acceleration_mps2 = 0.30;
  double jerk_mps3 = 0.60;
};

/// Follows a target, each axis for itself, as a critically damped second-order system whose demands are
/// bounded. A target may jump; the point and its first two derivatives never do. A target that moves smoothly
/// within the bounds is followed with the lag of the system; give its velocity to follow it without.
class SmoothPoint {
 public:
  using Vector3d = Eigen::Vector3d;

  explicit SmoothPoint(const SmoothPointLimits& limits) : limits_(limits) {}

  /// Stands at p, at rest.
  void reset(const Vector3d& p);
  /// @pre dt > 0, all finite
  void step(double dt_s, const Vector3d& p_target, const Vector3d& v_target = Vector3d::Zero());

  [[nodiscard]] const Vector3d& p() const { return p_; }
  [[nodiscard]] const Vector3d& v() const { return v_; }
  [[nodiscard]] const Vector3d& a() const { return a_; }

 private:
  SmoothPointLimits limits_;
  Vector3d p_ = Vector3d::Zero();
  Vector3d v_ = Vector3d::Zero();
  Vector3d a_ = Vector3d::Zero();
};

}  // namespace motionlab::controller
