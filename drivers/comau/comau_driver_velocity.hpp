/// @file  From wanted velocities to the command on the wire: limited, ramped, able to stop before the edge.
#pragma once

#include "drivers/comau/comau_wire.hpp"

namespace motionlab::comau {

/// Makes one command per command period. Knows no time and no reasons; starts at rest in mode 0.
///
/// Whatever is wanted and whatever is measured, every command keeps, for each joint,
///   - the speed limit, rounding to the wire's float included;
///   - the acceleration limit: away from rest `qdd_max`, towards rest the greater of that and the stop
///     deceleration;
///   - the stop: from where the set point is, braking with the stop deceleration ends inside the box. In
///     steps of one period T a stop from v at deceleration a covers at most (v + aT/2)² / (2a), hence
///     v <= sqrt(2 a d) - aT/2 towards an edge at distance d, or one step of braking where that is more: what
///     was stoppable before is stoppable after it.
/// The set point runs ahead of the measured position by what was sent and has not arrived; that lead is
/// bounded from both sides with `reaction_s`. Outside the box only the way back is open.
///
/// Mode 1 begins and ends at rest: with zero speed for `rest_before_motion_s`, so that a lost datagram cannot
/// make the first one a step, and for `rest_before_hold_s`, for the arm to catch up.
class VelocityShaper {
 public:
  struct Config {
    double period_s = 0.005;
    double rest_before_motion_s = 0.02;
    double rest_before_hold_s = 0.1;
    double reaction_s = 0.08;  ///< from a velocity that is sent to the position that shows it: wire and servo
    Joints q_min_rad{};
    Joints q_max_rad{};
    Joints qd_max_radps{};
    Joints qdd_max_radps2{};
    Joints stop_deceleration_radps2{};
  };

  explicit VelocityShaper(const Config& config) noexcept : config_(config) {}
  /// Goes on from what the robot computer was told last, to brake it.
  VelocityShaper(const Config& config, const Command& said) noexcept : config_(config), current_(said) {}

  /// Towards rest: speeds fall by at most deceleration x period, then rest in mode 1, then mode 0.
  Command brake() noexcept;

  /// Towards the wanted velocities. Brakes if one of them, or a position, is not finite.
  /// @param q_measured_rad  the newest known posture
  Command follow(const Joints& qd_wanted_radps, const Joints& q_measured_rad) noexcept;

  /// Nothing moves and mode 0 is what is said.
  [[nodiscard]] bool holding() const noexcept {
    return current_.mode == static_cast<std::int32_t>(Mode::hold);
  }

 private:
  [[nodiscard]] double limited(std::size_t joint, double qd_wanted, double q_measured) const noexcept;
  void note_under_way() noexcept;

  Config config_;
  Command current_{};
  Joints under_way_rad_{};  ///< sent and not yet measured, as a first-order lag of `reaction_s`
  int periods_at_rest_ = 0;
  int periods_of_following_ = 0;
};

}  // namespace motionlab::comau
