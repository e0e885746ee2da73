/// @file  Where the robot computer's set point is. It integrates our velocities and never reports the sum.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "drivers/core/time.hpp"
#include "gateway/controller/servo_belief.hpp"
#include "gateway/controller/servo_identifier.hpp"

namespace motionlab::controller {

/// Observes the set point of the three crane joints from what was sent and from the encoders.
///
/// A model of the servo is run beside the real one on the same set point; the difference between its posture
/// and the measured one moves the set point slowly. A lost datagram, a clipped velocity and what is left of a
/// servo other than modelled all show up there, and the controller, which steers the observed set point,
/// cures them together. How fast the servos are is identified on the way.
class SetPointObserver {
 public:
  using Vector3d = Eigen::Vector3d;

  /// @param gain_per_s  how fast the difference between believed and measured posture moves the set point
  SetPointObserver(const ServoBelief& servo, double gain_per_s, const ServoIdentifierConfig& identifier = {});

  /// A velocity command left at time t; it holds until the next. In order of time.
  void sent(LabTime t, bool follow, const Vector3d& qd_radps);

  /// The joints were measured at time t. While the robot holds, its set point follows the measurement. One
  /// that is not newer than the last, or not finite, is ignored.
  void measured(LabTime t, const Vector3d& q_rad, const Vector3d& qd_radps);

  /// The set point at time t, not before the last measurement. The measured posture before anything was sent,
  /// zero before the first measurement.
  [[nodiscard]] Vector3d at(LabTime t) const;

  /// What the servos' ω are taken for.
  [[nodiscard]] const Vector3d& omega_radps() const { return identifier_.omega_radps(); }

 private:
  struct Sent {
    LabTime t{};
    bool follow = false;
    Vector3d qd = Vector3d::Zero();
  };
  static constexpr std::size_t kCapacity = 64;

  /// ∫ of the sent velocities over [from, to].
  [[nodiscard]] Vector3d integral(LabTime from, LabTime to) const;
  /// Whether a command to follow was in force during all of [from, to].
  [[nodiscard]] bool following(LabTime from, LabTime to) const;
  void step_servo(const Vector3d& set_point, double dt_s);

  ServoBelief servo_;
  double gain_per_s_;
  ServoIdentifier identifier_;
  std::array<Sent, kCapacity> ring_{};  ///< newest last, in a circle
  std::size_t next_ = 0;
  bool heard_ = false;
  LabTime t_{};            ///< time of the last measurement
  LabTime t_set_point_{};  ///< time for which set_point_ holds: one servo delay earlier
  Vector3d set_point_ = Vector3d::Zero();
  Vector3d q_ = Vector3d::Zero();  ///< believed posture at t_
  Vector3d qd_ = Vector3d::Zero();
};

}  // namespace motionlab::controller
