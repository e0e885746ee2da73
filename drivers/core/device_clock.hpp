/// @file  Maps a device's own time to laboratory time: a minimum-delay filter that follows drift.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/core/time.hpp"

namespace motionlab {

/// Learns the offset between a device's clock and the laboratory's from samples that carry the device's time.
///
/// A datagram can be late but never early: the smallest (arrival − device time) seen is the best offset. The minimum
/// is taken over the last whole and the current window and may creep upwards by at most `drift_ppm_max`, so that a
/// slow device clock is followed. What no such filter can see is a constant latency: that comes from configuration.
class DeviceClock {
 public:
  struct Config {
    Nanoseconds latency{0};          ///< known constant delay from measurement to arrival; subtracted
    Nanoseconds window{10s};         ///< length of one minimum window
    double drift_ppm_max = 200.0;    ///< fastest drift that is followed
    Nanoseconds restart_gap{500ms};  ///< a jump of the offset by more than this starts afresh
  };

  explicit DeviceClock(Config config) noexcept : config_(config) {}

  /// The laboratory time at which the sample with this device time was measured. Never later than its arrival.
  LabTime map(Nanoseconds t_device, LabTime t_received) noexcept;

  /// Forgets everything: after a reconnect, or when the device's time went backwards.
  void reset() noexcept;

  /// Laboratory time minus device time in use; 0 before the first sample.
  [[nodiscard]] double offset_s() const noexcept { return offset_ ? seconds(*offset_) : 0.0; }
  /// How fast the offset moves, from the last two whole windows; 0 until there are two.
  [[nodiscard]] double drift_ppm() const noexcept { return drift_ppm_; }

 private:
  void close_window(LabTime t) noexcept;

  Config config_;
  std::optional<Nanoseconds> offset_;        ///< in use
  std::optional<Nanoseconds> window_min_;    ///< smallest of the current window
  std::optional<Nanoseconds> previous_min_;  ///< smallest of the last whole window
  LabTime window_start_{};
  LabTime window_min_at_{};
  LabTime previous_min_at_{};
  LabTime updated_at_{};
  double drift_ppm_ = 0.0;
};

}  // namespace motionlab
