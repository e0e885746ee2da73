/// @file  Ship motion that somebody recorded, made smooth.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace motionlab::plant {

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Ship coordinates and their exact time derivatives: surge, sway, heave in m along the axes of N (z down),
/// then roll, pitch, yaw in rad with R_NB = Rz(yaw) Ry(pitch) Rx(roll).
struct ShipCoordinates {
  Vector6d eta = Vector6d::Zero();
  Vector6d eta_dot = Vector6d::Zero();
  Vector6d eta_ddot = Vector6d::Zero();
};

/// The natural cubic spline through samples at any increasing times: it and its first two derivatives are
/// continuous, and its second is zero at both ends.
class RecordedMotion {
 public:
  struct Sample {
    double t_s;
    Vector6d eta;  ///< m, rad
  };

  /// @pre at least two samples, times increasing. Time counts from the first.
  explicit RecordedMotion(std::vector<Sample> samples);

  /// Before the first and after the last sample it stands where that one says.
  [[nodiscard]] ShipCoordinates at(double t_s) const;
  [[nodiscard]] double duration_s() const { return samples_.back().t_s; }

 private:
  std::vector<Sample> samples_;
  std::vector<Vector6d> eta_ddot_;  ///< at every sample
};

}  // namespace motionlab::plant
