/// @file  The six-axis arm of thesis Tab A.4 as a chain of Orocos KDL, whose joint values are the angles of
/// the table; and the ways between KDL's types and ours. Needs liborocos-kdl-dev.
#pragma once

#include <kdl/chain.hpp>
#include <kdl/frames.hpp>
#include <kdl/jntarray.hpp>

#include "tests/unit/math/arms.hpp"

namespace motionlab::test {

using Vector6 = Eigen::Matrix<double, 6, 1>;

inline KDL::Chain kdl_six_axis_arm(double tool_m) {
  KDL::Chain chain;
  const auto add = [&chain](double d, double a, double alpha) {
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ), KDL::Frame::DH(a, alpha, d, 0)));
  };
  add(kD1, kA1, kPi / 2);
  add(0, kA2, 0);
  add(0, kA3, kPi / 2);
  add(kD4, 0, -kPi / 2);
  add(0, 0, kPi / 2);
  add(kD6, 0, 0);
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(KDL::Vector(0, 0, tool_m))));
  return chain;
}

/// Plate values of the arm at home, wrist straight.
inline Vector6 six_axis_home() {
  return {0, 0, -kPi / 2, 0, 0, 0};
}

/// The theta column of Tab A.4.
inline KDL::JntArray table_angles(const Vector6& q) {
  KDL::JntArray theta(6);
  theta.data << -q[0], kPi / 2 - q[1], q[2] + kPi / 2 + q[1], -q[3], -q[4], kPi - q[5];
  return theta;
}

inline Eigen::Vector3d position(const KDL::Frame& X) {
  return {X.p.x(), X.p.y(), X.p.z()};
}

inline Eigen::Matrix3d rotation(const KDL::Frame& X) {
  Eigen::Matrix3d R;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R(i, j) = X.M(i, j);
  }
  return R;
}

inline KDL::Frame frame(const math::RigidTransform& X) {
  const auto& R = X.R;
  return {KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
          KDL::Vector(X.p.x(), X.p.y(), X.p.z())};
}

}  // namespace motionlab::test
