/// @file  The last joint readings, so that the arm's posture can be asked for at the time of another
/// measurement.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "drivers/core/time.hpp"

namespace motionlab::estimator {

/// The three crane joints at one time. Comau values.
struct JointMotion {
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
  Eigen::Vector3d qd = Eigen::Vector3d::Zero();
  Eigen::Vector3d qdd = Eigen::Vector3d::Zero();
};

/// A ring of joint readings in order of time.
class ArmHistory {
 public:
  /// Adds a reading. One that is not newer than the last is ignored.
  void add(LabTime t, const Eigen::Vector3d& q_rad, const Eigen::Vector3d& qd_radps);

  /// The joints at time t: interpolated between readings, extrapolated with the last velocity beyond them (at
  /// most 50 ms), the oldest reading before them. Accelerations are the slope of the measured velocities.
  /// @pre !empty()
  [[nodiscard]] JointMotion at(LabTime t) const;

  [[nodiscard]] bool empty() const { return count_ == 0; }

 private:
  struct Reading {
    LabTime t{};
    Eigen::Vector3d q;
    Eigen::Vector3d qd;
  };
  static constexpr std::size_t kCapacity = 64;

  /// The reading that is `back` places before the newest.
  [[nodiscard]] const Reading& newest(std::size_t back) const {
    return ring_[(next_ + kCapacity - 1 - back) % kCapacity];
  }

  std::array<Reading, kCapacity> ring_;
  std::size_t next_ = 0;
  std::size_t count_ = 0;
};

}  // namespace motionlab::estimator
