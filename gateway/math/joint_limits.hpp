/// @file  A box of joint values.
#pragma once

#include <Eigen/Core>

namespace motionlab::math {

/// The strokes of N joints, in the plate values of the arm.
template <int N>
struct JointLimits {
  Eigen::Matrix<double, N, 1> min_rad;
  Eigen::Matrix<double, N, 1> max_rad;

  [[nodiscard]] bool contain(const Eigen::Matrix<double, N, 1>& q) const {
    return (q.array() >= min_rad.array()).all() && (q.array() <= max_rad.array()).all();
  }
};

}  // namespace motionlab::math
