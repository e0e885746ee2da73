/// @file  The guard: the last stage before the wire. It trusts nobody and knows its own limits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "gateway/controller/wish.hpp"

namespace motionlab::controller {

/// What the arm and the winch may do. The guard's own copy, checked when the configuration is read.
struct GuardLimits {
  std::array<double, 6> q_min_rad{};
  std::array<double, 6> q_max_rad{};
  std::array<double, 6> qd_max_radps{};
  std::array<double, 6> qdd_max_radps2{};  ///< how fast a wish may change the velocity
  double stop_deceleration_radps2 =
      1.0;  ///< how it comes to rest, and what distance to the limits that needs
  double wire_min_m = 0;
  double wire_max_m = 0;
  double wire_speed_max_mps = 0.2;
  double wire_acceleration_max_mps2 = 0.5;
};

/// Which limit acted; bits of `guard_changed` on `motionlab/control`.
enum GuardBit : std::uint32_t {
  kGuardVelocity = 1u << 0,      // + joint
  kGuardAcceleration = 1u << 8,  // + joint
  kGuardPosition = 1u << 16,     // + joint
  kGuardWinch = 1u << 24,
  kGuardNotFinite = 1u << 25,
};

/// What may leave for the devices.
struct GuardedCommand {
  bool follow = false;  ///< the robot shall integrate the velocities
  std::array<double, 6> qd_radps{};
  double wire_speed_mps = 0;
  std::uint32_t changed = 0;  ///< GuardBits
};

/// Turns a wish into a command that never leaves the limits.
///
/// In this order: finite, position with stopping distance, velocity, acceleration. Without permission,
/// without a wish, or with one that is not finite, it brakes every joint at the stop deceleration and then
/// lets go of the robot. It keeps nothing but its own last command and what of its commands is still under
/// way in the servos, so whatever came before, the next command is within reach of a stop.
class Guard {
 public:
  explicit Guard(const GuardLimits& limits) : limits_(limits) {}

  struct Inputs {
    double dt_s = 0;         ///< since the last step, > 0
    bool may_move = false;   ///< the mode allows motion
    double authority = 1.0;  ///< share of velocity and acceleration limits, 0…1; braking has its own
    std::optional<Wish> wish;
    std::optional<std::array<double, 6>>
        q_rad;  ///< the newest measured posture; nothing: no motion but braking
    std::optional<double> wire_length_m;
  };

  GuardedCommand step(const Inputs& inputs);

  /// Whether the last command asks nothing to move.
  [[nodiscard]] bool at_rest() const;
  /// Steps in which the guard changed something that a permitted wish asked for.
  [[nodiscard]] std::uint64_t changed_count() const { return changed_count_; }
  [[nodiscard]] const GuardLimits& limits() const { return limits_; }

 private:
  double guard_joint(std::size_t joint, double wish, double q, double authority, double dt,
                     std::uint32_t& changed) const;
  double guard_winch(double wish, double length, double authority, double dt, std::uint32_t& changed) const;

  GuardLimits limits_;
  GuardedCommand last_;
  std::array<double, 7> under_way_{};  ///< asked and not yet travelled: six joints, wire
  std::uint64_t changed_count_ = 0;
};

}  // namespace motionlab::controller
