/// @file  The states of a ship that carries a motion reference unit, and how its readings bear on them.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "gateway/estimator/belief.hpp"
#include "gateway/estimator/innovations.hpp"
#include "gateway/estimator/ship_axis.hpp"
#include "gateway/math/moving_base.hpp"
#include "gateway/math/sparse_kalman.hpp"
#include "idl/mru.hpp"

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

/// The smallest angle that is equal to a up to whole turns.
[[nodiscard]] inline double wrapped(double a) {
  return std::remainder(a, 2 * std::acos(-1.0));
}

/// The nine measurements of a sample - angles, rates, unfiltered accelerations - one after the other, each as
/// `update(kind, row, innovation, standard deviation)`. The high-passed positions and velocities are not
/// used: they hold nothing that the accelerations do not. `ship` is looked at anew after every update.
template <class Update>
void take_mru(const topic::Mru& mru, const ShipView& ship, const MruMount& mount, const MruBelief& belief,
              double gravity_mps2, Update&& update) {
  using Eigen::Vector3d;
  using math::Matrix3d;
  using math::SparseRow;
  constexpr auto axis = ShipStates::axis;
  const auto& X_BM = mount.X_BM;
  const auto vector = [](const std::array<double, 3>& a) { return Vector3d(a[0], a[1], a[2]); };

  // Angles. The unit's attitude in D is that of B times the mounting.
  {
    const Vector3d rpy_B = ship.triple(0, 3);
    const Matrix3d R_DM = math::from_euler(rpy_B, math::EulerOrder::zyx) * X_BM.R;
    const Vector3d rpy_M = math::to_euler(R_DM, mount.order);
    const Vector3d rpy_zyx = math::to_euler(R_DM, math::EulerOrder::zyx);
    // The readings' small changes follow the zyx angles of the unit in either order, near enough for a gain.
    const Matrix3d H = math::euler_zyx_rates_to_body(rpy_zyx).inverse() * X_BM.R.transpose() *
                       math::euler_zyx_rates_to_body(rpy_B);
    const Vector3d reading = vector(mru.euler_heading_mru_rad);
    for (int i = 0; i < 3; ++i) {
      const int error_index = i < 2 ? ShipStates::kTiltError + i : ShipStates::kYawError;
      SparseRow row;
      double predicted = rpy_M[i] + ship[error_index];
      for (int j = 0; j < 3; ++j) {
        row.add(axis(3 + j, 0), H(i, j));
        predicted += H(i, j) * (ship[axis(3 + j, 0)] - rpy_B[j]);
      }
      row.add(error_index, 1.0);
      update(Reading::mru_angle, row, wrapped(reading[i] - predicted), belief.angle_noise_rad);
    }
  }
  // Rates, in the unit's body frame.
  {
    const Vector3d rpy = ship.triple(0, 3), rpy_dot = ship.triple(1, 3);
    const Matrix3d R_MB = X_BM.R.transpose();
    const Matrix3d on_rate = R_MB * math::euler_zyx_rates_to_body(rpy);
    Matrix3d on_angle;
    for (int j = 0; j < 3; ++j) {
      on_angle.col(j) = R_MB * math::euler_zyx_rates_to_body_dot(rpy, Vector3d::Unit(j)) * rpy_dot;
    }
    const Vector3d reading = vector(mru.omega_mru_radps);
    for (int i = 0; i < 3; ++i) {
      SparseRow row;
      double predicted = on_rate.row(i).dot(ship.triple(1, 3)) + ship[ShipStates::kRateBias + i];
      for (int j = 0; j < 3; ++j) {
        row.add(axis(3 + j, 1), on_rate(i, j));
        row.add(axis(3 + j, 0), on_angle(i, j));
        predicted += on_angle(i, j) * (ship[axis(3 + j, 0)] - rpy[j]);
      }
      row.add(ShipStates::kRateBias + i, 1.0);
      update(Reading::mru_rate, row, reading[i] - predicted, belief.rate_noise_radps);
    }
  }
  // Accelerations in the unit's heading frame, of the point O that the unit takes for B's origin: its lever
  // arm knows nothing of the misalignment. A tilt error turns gravity into acceleration.
  {
    const Vector3d p_BO = X_BM * mount.p_MO;
    const math::BodyMotion now = ship.motion();
    const Matrix3d on_turn = -now.X_WB.R * math::hat(p_BO) * math::euler_zyx_rates_to_body(ship.triple(0, 3));
    const Matrix3d R_DM = math::from_euler(ship.triple(0, 3), math::EulerOrder::zyx) * X_BM.R;
    const double heading = math::to_euler(R_DM, math::EulerOrder::zyx).z();
    const Matrix3d R_HW = math::rot_z(-heading) * ship.R_WD().transpose();
    // What does not depend on the second derivatives of the angles.
    const Vector3d turning = math::carried(now, {p_BO, Vector3d::Zero(), Vector3d::Zero()}).a - now.a_WB -
                             on_turn * ship.triple(2, 3);
    const Vector3d reading = vector(mru.a_heading_origin_mps2);
    for (int i = 0; i < 3; ++i) {
      SparseRow row;
      const Eigen::RowVector3d on_turn_H = R_HW.row(i) * on_turn;
      double predicted = R_HW.row(i).dot(turning + ship.triple(2, 0)) + on_turn_H.dot(ship.triple(2, 3)) +
                         ship[ShipStates::kAccelerationBias + i];
      for (int j = 0; j < 3; ++j) {
        row.add(axis(j, 2), R_HW(i, j));
        row.add(axis(3 + j, 2), on_turn_H[j]);
      }
      row.add(ShipStates::kAccelerationBias + i, 1.0);
      if (i == 0) {
        row.add(ShipStates::kTiltError + 1, -gravity_mps2);
        predicted -= gravity_mps2 * ship[ShipStates::kTiltError + 1];
      } else if (i == 1) {
        row.add(ShipStates::kTiltError, gravity_mps2);
        predicted += gravity_mps2 * ship[ShipStates::kTiltError];
      }
      update(Reading::mru_acceleration, row, reading[i] - predicted, belief.acceleration_noise_mps2);
    }
  }
}

}  // namespace motionlab::estimator
