/// @file  The world: a ship that moves, the arm on it, the winch, the wire and the load; and beside it the
/// uncontrolled twin on the same ship.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "drivers/core/time.hpp"
#include "gateway/math/crane_arm.hpp"
#include "simulators/plant/arm_servo.hpp"
#include "simulators/plant/load.hpp"
#include "simulators/plant/platform.hpp"
#include "simulators/plant/sea.hpp"
#include "simulators/plant/winch_servo.hpp"
#include "simulators/plant/world_config.hpp"

namespace motionlab::plant {

/// The load and what it hangs on.
struct HangingState {
  PointMotion tool;      ///< tool point in world, the arm's giving way included: p [m], v [m/s], a [m/s²]
  Eigen::Vector3d p_WL;  ///< load's centre in world, where the cameras see it [m]
  Eigen::Vector3d v_WL;  ///< [m/s]
  Eigen::Vector2d swing_rad;  ///< of the load's centre: (alpha, beta), thesis Eq 3.49; zero when plumb
  Eigen::Vector2d tilt_rad;   ///< of the load's own axis, likewise; equal to the swing of a point mass
  double free_length_m;       ///< true length from tool point to load, wire unstretched
  double length_rate_mps;
  double tension_n;
};

/// What is really so at one moment.
struct WorldState {
  LabTime t;
  PlatformState platform;  ///< EM8000, with arm and MRU 1
  PlatformState second;    ///< EM1500, with MRU 2
  Joints q_rad, qd_radps, qdd_radps2;
  double winch_length_m;  ///< by the winch's own encoder
  double winch_speed_mps;
  double winch_torque_nm;
  HangingState crane;
  HangingState twin;  ///< arm held at home, winch at its start
};

/// Integrates the world with a fixed tick of 0.4 ms, the robot PC's cycle.
///
/// It starts plumb and at rest, arm at home, platform at neutral. Set points are held until changed and act
/// from the next tick on. The same configuration, scenario, seed and commands give the same bytes.
class World {
 public:
  static constexpr Nanoseconds kTick{400'000};

  World(const WorldConfig& config, const Scenario& scenario, std::uint64_t seed, LabTime start = {});

  /// Runs all ticks that end at or before `t`. A time in the past changes nothing.
  void advance(LabTime t);

  /// Joint set points that leave the robot PC, Comau values in rad.
  void set_joint_set_points(const Joints& q_rad) { joint_set_points_ = q_rad; }
  /// Length set point of the winch, in m by its own encoder.
  void set_wire_set_point(double length_m) { wire_set_point_ = length_m; }
  /// A force on the load's centre in world, in N, until changed; the twin feels it too.
  void set_push(const Eigen::Vector3d& force_n) { push_n_ = force_n; }

  /// End of the last tick.
  [[nodiscard]] LabTime time() const { return end_.t; }
  /// Joints at `time()`: cheaper than the whole state.
  [[nodiscard]] const Joints& q_rad() const { return end_.q; }
  [[nodiscard]] const Joints& qd_radps() const { return end_.qd; }
  /// The world at `time()`.
  [[nodiscard]] WorldState state() { return sample(end_.t); }
  /// The world at a moment of the last tick: platform exact, the rest by the cubic through both ends of the
  /// tick. Times outside the last tick are moved to its nearer end.
  [[nodiscard]] WorldState sample(LabTime t);

  /// Where things truly are bolted in this world: the published calibration with this seed's errors.
  [[nodiscard]] const Calibration& calibration() const { return calibration_; }
  [[nodiscard]] const WorldConfig& config() const { return config_; }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }
  [[nodiscard]] unsigned long limited_ticks(std::size_t joint) const { return arm_.limited_ticks(joint); }

 private:
  /// One end of a tick.
  struct Knot {
    LabTime t;
    Joints q, qd;
    double length, length_rate;  ///< by the winch's encoder
    Suspension crane, twin;
    LoadState load, twin_load;
  };

  void tick();
  void hang(Knot& knot, const PlatformState& platform) const;
  [[nodiscard]] PointMotion posture_point(const PlatformState& platform, const Eigen::Vector3d& p_RT,
                                          const Eigen::Vector3d& v_BT, const Eigen::Vector3d& a_BT) const;
  [[nodiscard]] PlatformState platform_at(LabTime t);
  [[nodiscard]] HangingState hanging(const PointMotion& posture, double free_length, double rate,
                                     const LoadState& load) const;

  WorldConfig config_;
  std::uint64_t seed_;
  LabTime ship_starts_;
  Calibration calibration_;
  CachedShipMotion ship_;
  CachedShipMotion second_ship_;
  math::CraneArm geometry_;
  Load load_;
  ArmServo arm_;
  WinchServo winch_;
  Joints joint_set_points_;
  double wire_set_point_;
  double extra_wire_m_;
  Eigen::Vector3d p_RT_home_;
  Eigen::Vector3d sag_R_;  ///< of the arm's own weight at home, which the calibration has taken out
  Eigen::Vector3d push_n_ = Eigen::Vector3d::Zero();
  Knot begin_, end_;
};

}  // namespace motionlab::plant
