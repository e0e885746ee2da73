/// @file  What the gateway believes of the laboratory: where things stand, how they move, how far to trust
/// them. Beliefs, not truths: the simulated world has numbers of its own and neither can see the other's.
#pragma once

#include "gateway/math/crane_arm.hpp"
#include "gateway/math/rotation.hpp"

namespace motionlab::estimator {

/// Where a motion reference unit is mounted on its ship, and how it was set up.
struct MruMount {
  math::RigidTransform X_WN;                       ///< platform neutral in world
  math::RigidTransform X_BM;                       ///< the unit in platform body, misalignment included
  Eigen::Vector3d p_MO = Eigen::Vector3d::Zero();  ///< lever arm the unit was told, to B's origin in its own
                                                   ///< axes; as wrong as its mounting
  math::EulerOrder order = math::EulerOrder::zyx;
};

/// Where the frames stand. `A_TO_B` of the configuration is X_AB here.
struct Calibration {
  math::RigidTransform X_WN;  ///< platform neutral in world
  math::RigidTransform X_BR;  ///< robot base in platform body
  math::RigidTransform X_BM;  ///< motion reference unit in platform body, misalignment included
  Eigen::Vector3d
      p_MO;  ///< lever arm the unit was told, to B's origin in its own axes; as wrong as its mounting
  math::RigidTransform X_WQ;  ///< camera system in world
  math::RigidTransform X_BP;  ///< the tracked camera body in platform body
  math::CraneArmGeometry arm;
  math::EulerOrder mru_order = math::EulerOrder::zyx;
  MruMount second;  ///< of the second ship's unit

  [[nodiscard]] MruMount mount() const { return {X_WN, X_BM, p_MO, mru_order}; }
};

/// How the ship moves when nothing is known: two equal resonators in cascade per coordinate, driven by white
/// noise.
struct ShipBelief {
  double period_s = 8.0;
  double damping = 0.3;
  double translation_sd_m = 0.25;  ///< stationary standard deviation of surge, sway, heave
  double rotation_sd_rad = 0.08;   ///< likewise of roll, pitch, yaw
};

/// Noise and drift of the motion reference unit.
struct MruBelief {
  double tilt_error_sd_rad = 3.5e-4;  ///< slow error of roll and pitch; it also leaks gravity
  double tilt_error_correlation_s = 20.0;
  double angle_noise_rad = 1.0e-4;   ///< white, per sample
  double rate_noise_radps = 5.0e-4;  ///< white, per sample
  double rate_bias_sd_radps = 2.0e-4;
  double acceleration_noise_mps2 = 0.03;  ///< white, per sample; wide, because the ship model bends
  double acceleration_bias_sd_mps2 = 0.05;
  double yaw_start_sd_rad = 0.06;
  double yaw_drift_rad_sqrt_s = 1.2e-3;  ///< random walk
};

/// Noise of the cameras. White variances are inflated for the slow part: n samples that err together count as
/// one.
struct CameraBelief {
  double load_sd_m = 0.005;  ///< equivalent white noise per sample, horizontal
  double load_height_sd_m =
      0.020;  ///< likewise vertical; wide, because the wire bounces below what is modelled
  double platform_sd_m = 0.006;
  double platform_sd_rad = 0.002;
};

/// The load on its wire.
struct LoadBelief {
  double gravity_mps2 = 9.81;
  double acceleration_noise = 2.0e-3;        ///< density of unmodelled horizontal acceleration [m/s²/√Hz]
  double swing_damping_doubt = 0.03;         ///< damping ratio that the swing may have; the model has none
  double swing_damping_correlation_s = 1.0;  ///< how long what that makes of one swing errs one way
  double tool_offset_sd_m = 0.003;           ///< slow error of the tool point (calibration, wire length)
  double tool_offset_correlation_s = 60.0;
};

/// How far to doubt what no measurement can correct: where the frames are bolted and how old the samples
/// truly are. Added to the deviations that are reported; the filter, which weighs readings against each
/// other, does not hear of it. Of each axis.
struct SystematicDoubt {
  double frame_sd_m = 0.0007;    ///< place of a mounting
  double frame_sd_rad = 5.0e-4;  ///< angle of a mounting
  double wire_length_sd_m = 0.002;
  double age_sd_s = 0.003;  ///< of a sample when it arrives, against what is configured
  /// Of yaw while only the load is seen: a turn about the tool and a shift of the ship look alike, and a
  /// millimetre of slow error in the arm's motion on the ship passes for the difference.
  double yaw_from_load_sd_rad = 0.0125;
};

struct Belief {
  Calibration calibration;
  ShipBelief ship;
  ShipBelief second_ship{.translation_sd_m = 0.1};  ///< the smaller platform
  MruBelief mru;
  CameraBelief camera;
  LoadBelief load;
  SystematicDoubt doubt;
  double fusion_delay_s = 0.012;  ///< how long a sample may be under way before its turn comes
  double gate_sigma = 8.0;        ///< innovations beyond this are refused
  bool use_platform_body = true;  ///< use the tracked body on the platform when it is seen
};

}  // namespace motionlab::estimator
