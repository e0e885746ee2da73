/// @file  How the ship moves: regular waves, random seas, recordings, calm.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "simulators/plant/recorded_motion.hpp"

namespace motionlab::plant {

enum class Sea { calm, thesis_wave, pierson_moskowitz, jonswap, recorded };

/// Where the waves of a random sea run, seen from above in N: 0 towards the bow (x), 90° to starboard (y).
struct WaveDirection {
  double mean_rad = 0.0;
  double spreading_rad = 0.436332313;  ///< standard deviation of the single waves about the mean: 25°
};

/// What the ship does in a run.
struct Scenario {
  Sea sea = Sea::thesis_wave;
  double significant_height_m = 0.5;                  ///< of heave; random seas only
  double peak_period_s = 7.0;                         ///< random seas only
  double peak_enhancement = 3.3;                      ///< JONSWAP gamma
  std::optional<WaveDirection> direction{};           ///< random seas; nothing: no coordinate knows another
  std::shared_ptr<const RecordedMotion> recording{};  ///< `Sea::recorded` only
  double delay_s = 0.0;                               ///< the ship stands still for so long first
  double fade_in_s = 5.0;  ///< the motion grows from nothing over this time; 0: at once
};

/// `thesis-wave`, `sea` (JONSWAP, Hs 0.5 m, Tp 7 s), `pierson-moskowitz` (Hs 0.4 m, Tp 7 s: of 0.5 m the
/// short waves accelerate EM8000 too much), `calm`; nothing for other names.
[[nodiscard]] std::optional<Scenario> scenario_named(std::string_view name);

/// Wave spectrum S(w) of heave in m² s. Source: thesis Sec 6.3; one-sided, its integral is Hs²/16.
[[nodiscard]] double pierson_moskowitz(double omega_radps, double significant_height_m, double peak_period_s);
[[nodiscard]] double jonswap(double omega_radps, double significant_height_m, double peak_period_s,
                             double gamma);

/// The ship's motion, a pure function of time: a sum of harmonics or a recording.
///
/// A random sea has 40 bins of equal energy between 0.25 and 3 times the peak frequency; in each a frequency
/// is drawn from the seed. Heave has the stated spectrum. The other coordinates have its shape and, for each
/// metre of heave's standard deviation, at most 0.6 m (surge, sway), 18° (roll), 15° (pitch), 8° (yaw):
///  - without a direction each coordinate has exactly these and phases of its own;
///  - with one, each bin is a long wave that runs to chi, drawn about the mean, and the ship goes with the
///    water: surge 0.6 cos chi and sway 0.6 sin chi a quarter period after the crest, pitch 15° cos chi and
///    roll −18° sin chi with the slope, yaw 8° sin 2 chi with the crest.
///
/// The fade-in is a quintic ramp (two continuous derivatives), differentiated with the rest; a recording
/// fades out likewise before it ends, and then the ship stands at neutral.
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
  static void add_wave(Harmonic& harmonic, double amplitude, double phase, double direction);
  void add_random_sea(const Scenario& scenario, std::uint64_t seed);
  [[nodiscard]] ShipCoordinates sum_at(double t_s) const;

  double fade_in_s_;
  std::shared_ptr<const RecordedMotion> recording_;
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
