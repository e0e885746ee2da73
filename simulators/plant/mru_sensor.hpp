/// @file  What a motion reference unit makes of the platform's true motion.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string_view>

#include "gateway/math/rotation.hpp"
#include "simulators/plant/noise.hpp"
#include "simulators/plant/platform.hpp"
#include "simulators/plant/second_order.hpp"

namespace motionlab::plant {

struct MruConfig {
  double period_s = 0.005;
  double output_latency_s = 0.005;  ///< of the unit, from motion to datagram; applied by whoever sends
  /// True turn (roll, pitch, yaw; zyx) of the unit against its nominal mounting.
  Eigen::Vector3d misalignment_rad{0.13 * kDegree, 0.38 * kDegree, 1.5 * kDegree};
  /// What the unit was told: vector from itself to the platform's origin, in its own axes.
  Eigen::Vector3d lever_to_origin_m{1.289, -0.576, 0.966};
  bool high_pass = true;  ///< false: positions and velocities are absolute, about the neutral pose
  double surge_sway_period_s = 2.5, surge_sway_damping = 0.60;
  double heave_period_s = 10.0, heave_damping = 0.70;
  double roll_pitch_rms_rad = 3.5e-4, roll_pitch_correlation_s = 20.0;  ///< slow; leaks gravity
  double roll_pitch_white_rms_rad = 0.0;
  double yaw_walk_rad_per_sqrt_s = 0.5 * kDegree / 7.745966692414834;  ///< 0.5° rms after a minute
  double rate_noise_rms_radps = 3.0e-4;
  double acceleration_noise_rms_mps2 = 0.01;
  Eigen::Vector3d acceleration_bias_mps2{0, 0, -0.038};
  double gravity_mps2 = 9.81;
  double temperature_degc = 31.0;

  /// The unit on the second ship, mounted true.
  static MruConfig second_ship();
  [[nodiscard]] MruConfig with_white_noise_only() const;
  /// Every random error `factor` times as large; bias and mounting stay.
  [[nodiscard]] MruConfig with_noise_times(double factor) const;
  /// No noise, bias or drift; filters, rate and latency stay.
  [[nodiscard]] MruConfig without_errors() const;

  static constexpr double kDegree = 0.017453292519943295;
};

/// One measurement, in the unit's own conventions. M: unit's body axes (forward, starboard, down). H: level,
/// x along the unit's own heading reading, z down.
struct MruReading {
  Eigen::Vector3d
      euler_rad;  ///< roll, pitch against gravity; yaw against the unit's own zero, drifting. In (−pi, pi]
  Eigen::Vector3d omega_M_radps;    ///< rate of turn in M
  double omega_down_radps;          ///< rate of turn about down
  Eigen::Vector3d v_unit_M_mps;     ///< high-passed velocity of the unit itself, in M
  Eigen::Vector3d a_unit_M_mps2;    ///< acceleration of the unit itself, gravity removed, in M
  Eigen::Vector3d p_origin_H_m;     ///< high-passed position of the platform's origin
  Eigen::Vector3d v_origin_H_mps;   ///< high-passed velocity of the platform's origin
  Eigen::Vector3d a_origin_H_mps2;  ///< acceleration of the platform's origin, not filtered
};

/// The physics of one unit at its sample rate.
///
/// Roll and pitch carry a slow error (first-order Gauss–Markov); the same wrong vertical is used to take
/// gravity out of the accelerations, so that the error leaks into them. Yaw is free: zero where the unit
/// points along the neutral platform, plus a random walk. Accelerations of unit and origin (lever arm as
/// configured in the unit, so a wrong mounting is not corrected) are turned to a level frame that follows the
/// yaw drift only and pass s²/(s² + 2 zeta w s + w²); position and velocity of that filter are turned to the
/// heading (H) on output. The accelerometer bias is on the accelerations put out but not in the filters: the
/// real unit's heave returns to zero at rest, so it must take it out there. The filters start settled.
class MruSensor {
 public:
  /// @param X_WN  neutral pose of the platform: its heading is the yaw zero
  /// @param X_BM  where the unit truly is, without the configured misalignment
  MruSensor(const MruConfig& config, const math::RigidTransform& X_WN, const math::RigidTransform& X_BM,
            std::uint64_t seed, std::string_view name);

  /// Measures; to be called once a period.
  [[nodiscard]] MruReading sample(const PlatformState& platform);

  [[nodiscard]] const MruConfig& config() const { return config_; }

 private:
  /// Position and velocity of one point after the high-pass, in the level frame.
  struct HighPassed {
    SecondOrder::State x, y, z;
    Eigen::Vector3d last_a;
    [[nodiscard]] Eigen::Vector3d p() const { return {x.x, y.x, z.x}; }
    [[nodiscard]] Eigen::Vector3d v() const { return {x.v, y.v, z.v}; }
  };

  void settle(HighPassed& point, const Eigen::Vector3d& a) const;
  void filter(HighPassed& point, const Eigen::Vector3d& a) const;

  MruConfig config_;
  Eigen::Matrix3d R_WD_;  ///< D: level, z down, x along the neutral platform
  Eigen::Vector3d p_WN_;
  math::RigidTransform X_BM_;
  Random random_;
  GaussMarkov roll_error_, pitch_error_;
  double yaw_error_rad_ = 0;
  SecondOrder surge_sway_, heave_;
  HighPassed unit_, origin_;
  bool settled_ = false;
};

}  // namespace motionlab::plant
