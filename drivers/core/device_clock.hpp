/// @file  Maps a device's own time to laboratory time: a minimum-delay filter that follows drift.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/core/time.hpp"

namespace motionlab {

/// Learns the offset between a device's clock and the laboratory's from samples that carry the device's time.
///
/// A datagram can be late but never early: the smallest (arrival − device time) is the best offset. The
/// offset in use is a line below all of them. It falls at once to a sample that comes earlier than any
/// before; what is left between the line and the smallest of a whole window is made up by creeping, at no
/// more than `drift_ppm_max`; and the line's slope is the drift between the minima of whole windows. What no
/// such filter can see is a constant latency: that comes from configuration. A quantised device time reads as
/// latency of up to one step.
///
/// The device's clock has restarted when it goes back, or ahead of all experience, by more than
/// `restart_gap`: the filter starts afresh. A sample that is only late keeps its true, old time; if all are
/// late for more than a second, the device's clock has lost that time, and the filter starts afresh too.
class DeviceClock {
 public:
  struct Config {
    Nanoseconds latency{0};          ///< known constant delay from measurement to arrival, >= 0; subtracted
    Nanoseconds window{10s};         ///< length of one minimum window, > 0
    double drift_ppm_max = 200.0;    ///< fastest drift that is followed
    Nanoseconds restart_gap{500ms};  ///< a jump by more than this is a restart of the device's clock
  };

  explicit DeviceClock(Config config) noexcept : config_(config) {}

  /// The laboratory time at which the sample with this device time was measured. Never later than its
  /// arrival, and never earlier than that of a sample with an earlier device time that was mapped before.
  /// @pre arrivals do not go backwards
  LabTime map(Nanoseconds t_device, LabTime t_received) noexcept;

  /// Forgets everything, e.g. after a reconnect.
  void reset() noexcept;

  /// Laboratory time minus device time in use, the configured latency not subtracted; 0 before the first
  /// sample.
  [[nodiscard]] double offset_s() const noexcept { return line_ ? seconds(line_->offset) : 0.0; }
  /// How fast the offset moves, from the whole windows so far; 0 until there are two.
  [[nodiscard]] double drift_ppm() const noexcept { return drift_ppm_; }

 private:
  /// The offset at one time; from there it moves with the drift.
  struct Point {
    LabTime at;
    Nanoseconds offset;
  };

  void start(Point sample, Nanoseconds t_device) noexcept;
  [[nodiscard]] bool restarted(Nanoseconds t_device, const Point& sample) noexcept;
  void creep(LabTime t) noexcept;
  void look_at_window(const Point& sample) noexcept;
  void close_window(LabTime t) noexcept;

  Config config_;
  std::optional<Point> line_;  ///< in use
  double drift_ppm_ = 0.0;
  Nanoseconds deficit_{0};  ///< how far the line lies too low; made up by creeping

  LabTime window_start_{};
  Point window_min_{};           ///< sample of the current window closest above the line
  Nanoseconds window_margin_{};  ///< its distance from the line, >= 0
  std::optional<Point> previous_min_;
  bool has_drift_ = false;

  std::optional<LabTime> late_since_;  ///< all samples since then are late by more than `restart_gap`
  Nanoseconds newest_device_{};        ///< greatest device time mapped so far
  LabTime newest_mapped_{};            ///< what it was mapped to
};

}  // namespace motionlab
