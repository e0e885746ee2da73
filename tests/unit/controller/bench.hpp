/// @file  What the controllers are tested on: servos, a robot computer and a pendulum, integrated finely and
/// written without the controllers' own code.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <deque>

namespace motionlab::test {

using Eigen::Vector3d;

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree = kPi / 180;

/// One joint behind the robot computer: it integrates the last velocity at 0.1 ms; the joint follows the set
/// point as it was `delay` ago with a second-order lag.
class Joint {
 public:
  static constexpr double kStep = 1e-4;

  explicit Joint(double q = 0, double omega = 25.1327, double zeta = 0.7, double delay_s = 0.0024)
      : omega_(omega), zeta_(zeta), q_(q), set_point_(q), line_(steps(delay_s) + 1, q) {}

  /// One step of 0.1 ms with a velocity in force. Without `follow` the robot holds: its set point jumps to
  /// the joint, as the laboratory's does.
  void step(bool follow, double qd_wanted) {
    if (follow) {
      set_point_ += kStep * qd_wanted;
    } else {
      set_point_ = q_;
    }
    line_.push_back(set_point_);
    const double delayed = line_.front();
    line_.pop_front();
    const double qdd = omega_ * omega_ * (delayed - q_) - 2 * zeta_ * omega_ * qd_;
    qd_ += kStep * qdd;
    q_ += kStep * qd_;
  }

  [[nodiscard]] double q() const { return q_; }
  [[nodiscard]] double qd() const { return qd_; }
  [[nodiscard]] double set_point() const { return set_point_; }

 private:
  static std::size_t steps(double delay_s) { return static_cast<std::size_t>(delay_s / kStep + 0.5); }

  double omega_, zeta_;
  double q_, qd_ = 0, set_point_;
  std::deque<double> line_;
};

/// A point mass on a wire of fixed length under a tool point with given acceleration, Cartesian, at 0.1 ms.
class Pendulum {
 public:
  static constexpr double kStep = 1e-4;

  Pendulum(const Vector3d& p_WT, const Vector3d& hanging) : p(p_WT + hanging), length_(hanging.norm()) {}

  void step(const Vector3d& p_WT, const Vector3d& v_WT, const Vector3d& a_WT) {
    const Vector3d r = p - p_WT, r_dot = v - v_WT;
    const Vector3d gravity(0, 0, -9.81);
    const double pull = (r.dot(gravity - a_WT) + r_dot.squaredNorm()) / r.squaredNorm();
    v += kStep * (gravity - pull * r);
    p += kStep * v;
    const Vector3d along = (p - p_WT).normalized();
    p = p_WT + length_ * along;
    v -= along * along.dot(v - v_WT);
  }

  [[nodiscard]] double swing(const Vector3d& p_WT) const {
    const Vector3d r = p - p_WT;
    return std::atan2(std::hypot(r.x(), r.y()), -r.z());
  }

  Vector3d p;
  Vector3d v = Vector3d::Zero();

 private:
  double length_;
};

}  // namespace motionlab::test
