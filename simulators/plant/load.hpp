/// @file  The load: a rigid body on an elastic, damped wire from an arm that gives way, in Cartesian world
/// coordinates.
#pragma once

#include <Eigen/Core>

#include "simulators/plant/arm_mode.hpp"

namespace motionlab::plant {

struct LoadConfig {
  double mass_kg = 12.0;
  double gravity_mps2 = 9.81;
  double wire_ea_n = 2.0e5;  ///< stiffness times cross-section; the spring is this over the wire's length
  double wire_damping_ratio = 0.05;   ///< of the vertical mode
  double swing_damping_ratio = 0.03;  ///< of the small swing; acts across the wire only, while it is taut
  double radius_m = 0.15;
  double drag_coefficient = 0.47;
  double air_density_kgpm3 = 1.2;
  bool rigid_body = true;            ///< false: a point mass at the end of the wire
  double hook_to_centre_m = 0.30;    ///< from the end of the wire to the centre of mass
  double gyration_radius_m = 0.095;  ///< about the centre, across its axis; a solid sphere of `radius_m`
  double tilt_damping_ratio = 0.02;  ///< of the body's small tilting under the hook

  /// From the end of the wire to the centre of mass; nothing for a point mass.
  [[nodiscard]] double below_hook_m() const { return rigid_body ? hook_to_centre_m : 0.0; }
};

/// What the load hangs on at one moment, in world, z up.
struct Suspension {
  Eigen::Vector3d p_WT;    ///< tool point, where the servo posture puts it [m]
  Eigen::Vector3d v_WT;    ///< [m/s]
  double free_length_m;    ///< tool point to the load's centre, wire unstretched
  double length_rate_mps;  ///< paid out is positive
};

/// Everything that moves by itself. The load's point is its centre of mass, which is what the cameras track.
struct LoadState {
  Eigen::Vector3d p_WL;                                   ///< [m]
  Eigen::Vector3d v_WL;                                   ///< [m/s]
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();          ///< unit vector from the centre to the hook
  Eigen::Vector3d omega_radps = Eigen::Vector3d::Zero();  ///< of the body, across `up`: it does not spin
  Eigen::Vector3d tip_m = Eigen::Vector3d::Zero();        ///< how far the arm gives way at the tool point
  Eigen::Vector3d tip_mps = Eigen::Vector3d::Zero();
};

/// How a state changes, per second.
struct LoadRates {
  Eigen::Vector3d v_WL, a_WL;
  Eigen::Vector3d up, omega;
  Eigen::Vector3d tip, tip_mps;
};

/// m a = m g + wire + drag + push;   (m rho²) omega' = l up × wire − damping;   the arm as in ArmMode.
///
/// The wire runs from the tool point (posture plus deflection) to the hook, `hook_to_centre_m` from the
/// centre. It only pulls: T = max(0, k (d − L) + c (d' − L')) while d > L, with k = EA/L and c = 2 zeta
/// sqrt(k m). The swing damping is −2 zeta sqrt(g/length) m times the centre's velocity against the tool
/// point across the wire; it stands for sheave, rope and air at small speeds, acts at the centre and goes
/// with the tension (none while slack). The tilt damping is a moment against the body's turning.
///
/// `step` is a classical Runge–Kutta step over load and arm together; the posture's and the wire's motion
/// inside it are the cubic through positions and speeds at both ends, and the arm feels its mean
/// acceleration. Fourth order while the wire stays taut or slack: at 0.4 ms with the default wire the
/// vertical mode (14.5 Hz) loses less than 1e-10 of its energy a step. A step in which the wire goes slack or
/// taut is first order in the time of contact only (the force itself has no jump but for the damper).
class Load {
 public:
  explicit Load(const LoadConfig& config, const ArmMode& arm = ArmMode::rigid())
      : config_(config), arm_(arm) {}

  /// Hangs plumb and at rest under a tool point at rest.
  [[nodiscard]] LoadState at_rest(const Eigen::Vector3d& p_WT, double free_length_m) const;
  [[nodiscard]] double tension_n(const LoadState& load, const Suspension& at) const;
  [[nodiscard]] Eigen::Vector3d acceleration_mps2(const LoadState& load, const Suspension& at) const;
  /// @param a_WT  acceleration of the posture's tool point  @param push_n  what else pushes the centre
  [[nodiscard]] LoadRates rates(const LoadState& load, const Suspension& at, const Eigen::Vector3d& a_WT,
                                const Eigen::Vector3d& push_n) const;
  /// One step, the push held.
  [[nodiscard]] LoadState step(const LoadState& load, const Suspension& begin, const Suspension& end,
                               double step_s, const Eigen::Vector3d& push_n = Eigen::Vector3d::Zero()) const;
  [[nodiscard]] const LoadConfig& config() const { return config_; }

 private:
  LoadConfig config_;
  ArmMode arm_;
};

/// Angles (alpha, beta) with p_WL = p_WT + d (−sin a, cos a sin b, −cos a cos b): zero when plumb. Thesis
/// Eq 3.49.
[[nodiscard]] Eigen::Vector2d swing_angles_rad(const Eigen::Vector3d& p_WT, const Eigen::Vector3d& p_WL);

/// The same angles of the load's own axis: how far it is tilted. Equal to the swing of a point mass.
[[nodiscard]] Eigen::Vector2d tilt_angles_rad(const LoadState& load);

}  // namespace motionlab::plant
