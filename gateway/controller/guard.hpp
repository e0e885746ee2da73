/// @file  The guard: the last stage before the wire. It trusts nobody and knows its own limits.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/controller/fences.hpp"
#include "gateway/controller/lease.hpp"
#include "gateway/controller/wish.hpp"

namespace motionlab::controller {

/// What the arm and the winch may do. The guard's own copy, checked when the configuration is read.
struct GuardLimits {
  std::array<double, 6> q_min_rad{};
  std::array<double, 6> q_max_rad{};
  std::array<double, 6> qd_max_radps{};
  std::array<double, 6> qdd_max_radps2{};  ///< how fast a wish may change the velocity
  double jerk_max_radps3 = 2000;           ///< how fast a wish may change the acceleration
  double stop_deceleration_radps2 =
      1.0;  ///< how it comes to rest, and what distance to the limits that needs
  double wire_min_m = 0;
  double wire_max_m = 0;
  double wire_speed_max_mps = 0.2;
  double wire_acceleration_max_mps2 = 0.5;
  double motor_torque_min_nm = -1e9;  ///< of the winch; below it the wire is slack: nothing is paid out
  double motor_torque_max_nm = 1e9;   ///< above it the wire is held fast: nothing is hauled in
  double posture_age_max_s = 0.1;     ///< an older posture is none
  std::optional<FenceLimits> fences;
};

/// Which limit acted; bits of `guard_changed` on `motionlab/control`.
enum GuardBit : std::uint32_t {
  kGuardVelocity = 1u << 0,      // + joint
  kGuardAcceleration = 1u << 8,  // + joint
  kGuardPosition = 1u << 16,     // + joint
  kGuardWinch = 1u << 24,
  kGuardNotFinite = 1u << 25,
  kGuardJerk = 1u << 26,
  kGuardTension = 1u << 27,
  kGuardWorkspace = 1u << 28,
  kGuardFloor = 1u << 29,
  kGuardSecondPlatform = 1u << 30,
  kGuardNotFresh = 1u << 31,
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
/// In this order: lease, fresh, finite; tension; fences (workspace, floor, second platform) with stopping
/// distance; jerk; position with stopping distance, velocity, acceleration. Without a lease, without
/// permission, without a wish, or with one that is not finite, it brakes every joint at the stop deceleration
/// and then lets go of the robot. It keeps nothing but its own last command and what of its commands is still
/// under way in the servos, so whatever came before, the next command is within reach of a stop: braking is
/// always possible, and is never held back by the jerk limit.
class Guard {
 public:
  explicit Guard(const GuardLimits& limits) : limits_(limits) {}

  struct Inputs {
    LabTime t{};
    double dt_s = 0;               ///< since the last step, > 0
    bool may_move = false;         ///< the mode allows motion
    const Lease* lease = nullptr;  ///< who commands; nobody: no motion but braking
    double authority = 1.0;        ///< share of velocity and acceleration limits, 0…1; braking has its own
    std::optional<Wish> wish;
    std::optional<std::array<double, 6>>
        q_rad;           ///< the newest measured posture; nothing: no motion but braking
    double q_age_s = 0;  ///< since it was measured
    std::optional<double> wire_length_m;
    double wire_age_s = 0;
    std::optional<double> motor_torque_nm;     ///< of the winch, where it is wired
    std::optional<math::RigidTransform> X_WR;  ///< robot base in world; needed where there are fences
  };

  GuardedCommand step(const Inputs& inputs);

  /// Nothing of the last command is in force any more: others have braked arm and winch meanwhile. The next
  /// step begins at rest; what was counted stays.
  void forget_command();

  /// Whether the last command asks nothing to move.
  [[nodiscard]] bool at_rest() const;
  /// Steps in which the guard changed something that a permitted wish asked for.
  [[nodiscard]] std::uint64_t changed_count() const { return changed_count_; }
  [[nodiscard]] const GuardLimits& limits() const { return limits_; }

 private:
  double guard_joint(std::size_t joint, double wish, double q, double authority, double dt,
                     std::uint32_t& changed) const;
  double guard_winch(double wish, double length, double authority, double dt, std::uint32_t& changed) const;
  /// What is wrong with the inputs, as bits; nothing: they may be followed.
  [[nodiscard]] std::uint32_t reasons_to_brake(const Inputs& in) const;
  void follow(const Inputs& in, double authority, double dt, GuardedCommand& out) const;
  [[nodiscard]] GuardedCommand brake(bool keep, double dt) const;
  /// The wish, scaled down to what fits before every fence, and the fences as they will be.
  [[nodiscard]] Wish within_fences(const std::array<Fence, kFences>& all, const Wish& wish,
                                   std::uint32_t& changed) const;
  [[nodiscard]] Eigen::Matrix<double, 7, 1> decelerations() const;

  GuardLimits limits_;
  GuardedCommand last_;
  std::array<double, 6> last_qdd_radps2_{};
  std::array<double, 7> under_way_{};  ///< asked and not yet travelled: six joints, wire
  std::uint64_t changed_count_ = 0;
};

}  // namespace motionlab::controller
