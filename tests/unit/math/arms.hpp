/// @file  The arms of the thesis, as test data.
#pragma once

#include <numbers>

#include "gateway/math/crane_arm.hpp"
#include "gateway/math/serial_chain.hpp"
#include "tests/unit/math/complex_pose.hpp"

namespace motionlab::test {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kA1 = 0.350, kA2 = 1.160, kA3 = 0.250, kD1 = 0.830, kD4 = 1.4922, kD6 = 0.210,
                        kTool = 0.567;

/// Tab 3.2: joint 1 clockwise, joint 2 from the vertical, joint 3 against the vertical. Row 4 does not move.
inline math::SerialChain<3> three_axis_arm() {
  math::JointMap<3> joints;
  joints.S << -1, 0, 0, 0, -1, 0, 0, 1, 1;
  joints.offset_rad << 0, kPi / 2, kPi / 2;
  return {{{{kD1, kA1, kPi / 2}, {0, kA2, 0}, {0, kA3, kPi / 2}}},
          joints,
          {math::rot_z(kPi), {0, 0, kD4 + kD6 + kTool}}};
}

/// Tab A.4, Comau NJ 110-3.0.
inline math::SerialChain<6> six_axis_arm(double tool_m = 0.0) {
  math::JointMap<6> joints;
  joints.S = Eigen::Matrix<double, 6, 6>(Eigen::Matrix<double, 6, 1>{-1, -1, 1, -1, -1, -1}.asDiagonal());
  joints.S(2, 1) = 1;
  joints.offset_rad << 0, kPi / 2, kPi / 2, 0, 0, kPi;
  return {{{{kD1, kA1, kPi / 2},
            {0, kA2, 0},
            {0, kA3, kPi / 2},
            {kD4, 0, -kPi / 2},
            {0, 0, kPi / 2},
            {kD6, 0, 0}}},
          joints,
          {math::Matrix3d::Identity(), {0, 0, tool_m}}};
}

/// The frames 0 … 6 of Tab A.4, row by row as printed.
template <class S>
std::array<Matrix4<S>, 7> frames_of_table_a4(const Eigen::Matrix<S, 6, 1>& q) {
  std::array<Matrix4<S>, 7> T;
  T[0].setIdentity();
  T[1] = T[0] * dh<S>(-q[0], kD1, kA1, kPi / 2);
  T[2] = T[1] * dh<S>(kPi / 2 - q[1], 0, kA2, 0);
  T[3] = T[2] * dh<S>(q[2] + kPi / 2 + q[1], 0, kA3, kPi / 2);
  T[4] = T[3] * dh<S>(-q[3], kD4, 0, -kPi / 2);
  T[5] = T[4] * dh<S>(-q[4], 0, 0, kPi / 2);
  T[6] = T[5] * dh<S>(kPi - q[5], kD6, 0, 0);
  return T;
}

inline math::CraneArm crane_arm(double d4 = kD4) {
  return math::CraneArm({kA1, kA2, kA3, kD1, d4 + kD6 + kTool});
}

/// The strokes of the maker (thesis App A), rad.
inline math::JointLimits<3> strokes() {
  return {Eigen::Vector3d(-180, -75, -256) * kPi / 180, Eigen::Vector3d(180, 95, -10) * kPi / 180};
}

}  // namespace motionlab::test
