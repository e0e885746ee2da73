/// @file  How the ship moves: regular waves, random seas, calm.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace motionlab::plant {

enum class Sea { calm, thesis_wave, pierson_moskowitz, jonswap };

/// What the ship does in a run.
struct Scenario {
  Sea sea = Sea::thesis_wave;
  double significant_height_m = 0.5;  ///< of heave; random seas only
  double peak_period_s = 7.0;         ///< random seas only
  double peak_enhancement = 3.3;      ///< JONSWAP gamma
  double delay_s = 0.0;               ///< the ship stands still for so long first
  double fade_in_s = 5.0;             ///< the motion grows from nothing over this time; 0: at once
};

/// `thesis-wave`, `sea` (JONSWAP, Hs 0.5 m, Tp 7 s), `pierson-moskowitz` (the same Hs and Tp), `calm`;
/// nothing for other names.
[[nodiscard]] std::optional<Scenario> scenario_named(std::string_view name);

/// Wave spectrum S(w) of heave in m² s. Source: thesis Sec 6.3; one-sided, its integral is Hs²/16.
[[nodiscard]] double pierson_moskowitz(double omega_radps, double significant_height_m, double peak_period_s);
[[nodiscard]] double jonswap(double omega_radps, double significant_height_m, double peak_period_s,
                             double gamma);

using Vector6d = Eigen::Matrix<double, 6, 1>;

/// Ship coordinates and their exact time derivatives: surge, sway, heave in m along the axes of N (z down),
/// then roll, pitch, yaw in rad with R_NB = Rz(yaw) Ry(pitch) Rx(roll).
struct ShipCoordinates {
  Vector6d eta = Vector6d::Zero();
  Vector6d eta_dot = Vector6d::Zero();
  Vector6d eta_ddot = Vector6d::Zero();
};

/// The ship's motion as a sum of harmonics, a pure function of time.
///
/// A random sea has 40 bins of equal energy between 0.25 and 3 times the peak frequency; in each a frequency
/// is drawn from the seed, and for each coordinate a phase. Heave has the stated spectrum; the other
/// coordinates have its shape and, for each metre of heave's standard deviation, 0.6 m (surge, sway), 18°
/// (roll), 15° (pitch), 8° (yaw). The fade-in is a quintic ramp (two continuous derivatives), differentiated
/// with the rest.
class ShipMotion {
 public:
  ShipMotion(const Scenario& scenario, std::uint64_t seed);

  /// At `t_s` since the ship began to move; before that it stands at neutral. (The delay is the world's
  /// business.)
  [[nodiscard]] ShipCoordinates at(double t_s) const;

 private:
  struct Harmonic {
    double omega_radps;
    Vector6d sine;
    Vector6d cosine;
  };

  void add_thesis_wave();
  void add_random_sea(const Scenario& scenario, std::uint64_t seed);

  double fade_in_s_;
  std::vector<Harmonic> harmonics_;
};

/// The same motion for a caller whose time mostly runs forward: exact values every 10 ms, and between them
/// the quintic polynomial through value, speed and acceleration at both ends. For wave frequencies below 1 Hz
/// the coordinates agree to 1e-10 and their accelerations to 1e-6 (relative to amplitude).
class CachedShipMotion {
 public:
  CachedShipMotion(const Scenario& scenario, std::uint64_t seed);
  [[nodiscard]] ShipCoordinates at(double t_s);

 private:
  void move_to(long long node);

  ShipMotion motion_;
  long long node_ = -2;
  ShipCoordinates begin_, end_;
  std::array<Vector6d, 6> c_;  ///< polynomial in the share of the interval
};

}  // namespace motionlab::plant
