/// @file  What is to be said to the robot computer so that the arm comes to rest, whatever was said before.
#pragma once

#include <optional>

#include "drivers/comau/comau_driver_velocity.hpp"
#include "drivers/comau/comau_wire.hpp"
#include "drivers/core/time.hpp"

namespace motionlab::deadman {

/// The last command that somebody sent, and how long ago.
struct Said {
  comau::Command command{};
  Nanoseconds age{};
};

/// Mode 1 with velocities that fall to zero at the stop deceleration, then mode 0 until the arm rests: the
/// driver's own way of braking (VelocityShaper), begun in the middle of a motion.
///
/// With the last command known it begins at that. A robot computer that has a watchdog has meanwhile begun to
/// brake by itself, so the ramp begins lower by what it braked: nothing is sped up again.
///
/// With nothing known (a gateway that was ended before we began), nobody can tell the speed but the answers,
/// and each answer wants a command. So it first asks with mode 1 and zero velocity: safe should nothing more
/// arrive, and on the way for as long as one answer takes, which the servos hardly see. Then it goes on from
/// the speed that was measured. Mode 0 would be a step in speed.
///
/// The caller sends what is `due` and passes on every answer. Times are of any clock that runs evenly.
class BrakeSequence {
 public:
  struct Config {
    comau::VelocityShaper::Config shaper{};
    /// After so long without a command the robot computer brakes by itself; nothing: it never does.
    std::optional<double> robot_brakes_after_s{};
    int holds = 20;                ///< mode 0 is said at least so often
    double at_rest_radps = 0.005;  ///< every joint slower than this: the arm rests
    Nanoseconds patience = 5s;     ///< after the ramp, for the arm to rest and to say so
  };

  enum class End {
    not_yet,
    at_rest,  ///< held, and measured at rest
    moving,   ///< patience has ended and the answers say that the arm moves
    silent,   ///< patience has ended and nobody answers
  };

  BrakeSequence(const Config& config, LabTime now, const std::optional<Said>& last) noexcept;

  /// The command to send now, if one is due: the first at once, then one each command period. Slots that were
  /// missed are skipped.
  [[nodiscard]] std::optional<comau::Command> due(LabTime now) noexcept;
  void heard(const comau::Answer& answer, LabTime t) noexcept;
  [[nodiscard]] End end(LabTime now) const noexcept;

 private:
  [[nodiscard]] bool slow(const comau::Joints& qd_radps) const noexcept;
  void begin(const comau::Command& from, LabTime now) noexcept;
  void keep_schedule(LabTime now) noexcept;

  Config config_;
  comau::VelocityShaper shaper_;
  bool asking_ = false;
  std::optional<comau::Command> first_;  ///< said before the ramp goes down from it
  LabTime next_;
  LabTime give_up_;
  int holds_ = 0;
  std::optional<LabTime> t_heard_;
  std::optional<LabTime> t_resting_;  ///< when the newest answer said so, after the first mode 0
};

}  // namespace motionlab::deadman
