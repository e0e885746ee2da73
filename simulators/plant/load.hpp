/// @file  The load: a point mass on an elastic, damped wire, in Cartesian world coordinates.
#pragma once

#include <Eigen/Core>

namespace motionlab::plant {

struct LoadConfig {
  double mass_kg = 12.0;
  double gravity_mps2 = 9.81;
  double wire_ea_n = 2.0e5;  ///< stiffness times cross-section; the spring is this over the free length
  double wire_damping_ratio = 0.05;   ///< of the vertical mode
  double swing_damping_ratio = 0.03;  ///< of the small swing; acts across the wire only, while it is taut
  double radius_m = 0.15;
  double drag_coefficient = 0.47;
  double air_density_kgpm3 = 1.2;
};

/// What the load hangs on at one moment, in world, z up.
struct Suspension {
  Eigen::Vector3d p_WT;    ///< tool point [m]
  Eigen::Vector3d v_WT;    ///< [m/s]
  double free_length_m;    ///< unstretched wire between tool point and load
  double length_rate_mps;  ///< paid out is positive
};

struct LoadState {
  Eigen::Vector3d p_WL;  ///< [m]
  Eigen::Vector3d v_WL;  ///< [m/s]
};

/// m a = m g + wire + drag.
///
/// The wire only pulls: T = max(0, k (d − L) + c (d' − L')) while d > L, with k = EA/L and c = 2 zeta sqrt(k
/// m). The swing damping is −2 zeta sqrt(g/L) m times the velocity against the tool point across the wire; it
/// stands for sheave, rope and air at small speeds and goes with the tension (none while slack).
///
/// `step` is a classical Runge–Kutta step; the tool point's and the wire's motion inside it are the cubic
/// through positions and speeds at both ends. Fourth order while the wire stays taut or slack: at 0.4 ms with
/// the default wire the vertical mode (14.5 Hz) loses less than 1e-10 of its energy a step. A step in which
/// the wire goes slack or taut is first order in the time of contact only (the force itself has no jump but
/// for the damper).
class Load {
 public:
  explicit Load(const LoadConfig& config) : config_(config) {}

  /// Hangs plumb and at rest under a tool point at rest.
  [[nodiscard]] LoadState at_rest(const Eigen::Vector3d& p_WT, double free_length_m) const;
  [[nodiscard]] double tension_n(const LoadState& load, const Suspension& at) const;
  [[nodiscard]] Eigen::Vector3d acceleration_mps2(const LoadState& load, const Suspension& at) const;
  [[nodiscard]] LoadState step(const LoadState& load, const Suspension& begin, const Suspension& end,
                               double step_s) const;
  [[nodiscard]] const LoadConfig& config() const { return config_; }

 private:
  LoadConfig config_;
};

/// Angles (alpha, beta) with p_WL = p_WT + d (−sin a, cos a sin b, −cos a cos b): zero when plumb. Thesis
/// Eq 3.49.
[[nodiscard]] Eigen::Vector2d swing_angles_rad(const Eigen::Vector3d& p_WT, const Eigen::Vector3d& p_WL);

}  // namespace motionlab::plant
