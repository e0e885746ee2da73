/// @file  How still one load hangs: the statistics of its swing and of its error.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/core/time.hpp"

namespace motionlab::monitor {

/// Degrees, because that is what the report is read in.
[[nodiscard]] double degrees(double rad);

/// Seconds for the report: the nearest double, so that 30 s is told as 30. (`seconds` multiplies by 1e-9,
/// which is not a binary number, and may be off in the last digit.)
[[nodiscard]] double nearest_seconds(Nanoseconds d);

/// One moment of one load. Errors are positions minus set points, in world.
struct MotionSample {
  std::array<double, 2> swing_rad{};
  std::array<double, 3> load_error_m{};
  std::array<double, 3> tool_error_m{};
};

/// sqrt(alpha² + beta²) in degrees.
[[nodiscard]] double swing_deg(const MotionSample& sample);
/// Distance of the load from its set point.
[[nodiscard]] double load_error_m(const MotionSample& sample);

/// What the samples of a window say.
struct MotionScore {
  std::uint64_t samples = 0;
  double swing_rms_deg = 0;
  std::array<double, 2> swing_axis_rms_deg{};  ///< alpha, beta
  double swing_max_deg = 0;
  std::array<double, 2> swing_axis_max_deg{};
  std::array<double, 3> load_error_rms_m{};  ///< x, y, z in world
  double load_error_rms_norm_m = 0;
  double load_error_max_m = 0;
  std::array<double, 3> tool_error_rms_m{};
  double tool_error_rms_norm_m = 0;
  double heave_residual_rms_m = 0;  ///< load height about its own mean: what is left of the ship's heave
};

/// Collects `MotionScore`. Means are over samples, so samples should come evenly in time; one that is lost on
/// the way counts as if it were like the others.
class MotionStatistics {
 public:
  void add(const MotionSample& sample);
  /// Nothing before the first sample.
  [[nodiscard]] std::optional<MotionScore> score() const;

 private:
  std::uint64_t samples_ = 0;
  std::array<double, 2> swing_squares_{};
  std::array<double, 2> swing_axis_max_rad_{};
  double swing_max_deg_ = 0;
  std::array<double, 3> load_squares_{};
  double load_error_max_m_ = 0;
  std::array<double, 3> tool_squares_{};
  double height_mean_ = 0;
  double height_squares_ = 0;  ///< about the mean
};

/// Finds when a swing came to within `kWithin_deg` and stayed.
///
/// It stayed when it was within for the rest of the samples, and these are at least `kStayed` long, a little
/// more than one period of a load on 2 m of wire: a passing calm is not rest.
class Settling {
 public:
  static constexpr double kWithin_deg = 1.0;
  static constexpr Nanoseconds kStayed = 3s;

  void add(LabTime t, double swing_deg);
  /// From `since` to the last sample outside; 0 when it was never outside since then; nothing when it did not
  /// stay.
  [[nodiscard]] std::optional<double> time_s(LabTime since) const;

 private:
  std::optional<LabTime> last_;
  std::optional<LabTime> last_outside_;
};

}  // namespace motionlab::monitor
