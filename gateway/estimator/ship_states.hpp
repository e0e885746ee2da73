/// @file  The states of a ship that carries a motion reference unit.
#pragma once

#include <Eigen/Core>

#include "gateway/estimator/ship_axis.hpp"
#include "gateway/math/moving_base.hpp"

namespace motionlab::estimator {

/// Where the states of a ship and its unit stand, from 0: six axes × (x, ẋ, ẍ, x‴) - offset of B's origin
/// from its neutral place in W axes, then roll, pitch, yaw of B against the level frame D - and the unit's
/// errors.
struct ShipStates {
  static constexpr int kAxes = 6;
  static constexpr int kAccelerationBias = ShipAxis::kSize * kAxes;  // F, S, D
  static constexpr int kRateBias = kAccelerationBias + 3;
  static constexpr int kTiltError = kRateBias + 3;  // roll, pitch
  static constexpr int kYawError = kTiltError + 2;
  static constexpr int kSize = kYawError + 1;

  /// Index of a derivative of an axis: axes 0–2 are x, y, z in W, 3–5 roll, pitch, yaw.
  static constexpr int axis(int i, int derivative = 0) { return ShipAxis::kSize * i + derivative; }
};

/// The level frame D in W: origin and heading of N, but its z exactly down. Angles against gravity are angles
/// in D.
[[nodiscard]] math::Matrix3d level_frame(const math::Matrix3d& R_WN);

/// The states of a ship as a motion, looking at the first entries of a filter's state.
class ShipView {
 public:
  using Vector3d = Eigen::Vector3d;

  /// @param x  `ShipStates::kSize` numbers that outlive the view
  ShipView(const double* x, const Vector3d& p_WN, const math::Matrix3d& R_WD)
      : x_(x), p_WN_(p_WN), R_WD_(R_WD) {}

  [[nodiscard]] double operator[](int i) const { return x_[i]; }
  /// One derivative of three neighbouring axes.
  [[nodiscard]] Vector3d triple(int derivative, int first_axis) const {
    return {x_[ShipStates::axis(first_axis, derivative)], x_[ShipStates::axis(first_axis + 1, derivative)],
            x_[ShipStates::axis(first_axis + 2, derivative)]};
  }
  [[nodiscard]] const math::Matrix3d& R_WD() const { return R_WD_; }
  [[nodiscard]] math::BodyMotion motion() const;

 private:
  const double* x_;
  const Vector3d& p_WN_;
  const math::Matrix3d& R_WD_;
};

}  // namespace motionlab::estimator
