#include "drivers/core/device_clock.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab {
namespace {

/// For so long nobody believes that a late datagram is an early restart.
constexpr Nanoseconds kLatePatience = 1s;
/// How much of a new drift is believed.
constexpr double kDriftGain = 0.25;

Nanoseconds share(Nanoseconds span, double ppm) noexcept {
  return Nanoseconds{std::llround(static_cast<double>(span.count()) * 1e-6 * ppm)};
}

}  // namespace

LabTime DeviceClock::map(Nanoseconds t_device, LabTime t_received) noexcept {
  const Point sample{t_received, t_received.time_since_epoch() - t_device};
  if (!line_ || restarted(t_device, sample)) {
    start(sample, t_device);
  } else {
    creep(t_received);
    look_at_window(sample);
    if (t_received - window_start_ >= config_.window) close_window(t_received);
  }

  LabTime mapped{t_device + line_->offset - config_.latency};
  if (t_device >= newest_device_) {
    mapped = std::max(mapped, newest_mapped_);
    newest_device_ = t_device;
    newest_mapped_ = mapped;
  }
  return std::min(mapped, t_received);
}

void DeviceClock::reset() noexcept {
  *this = DeviceClock{config_};
}

void DeviceClock::start(Point sample, Nanoseconds t_device) noexcept {
  reset();
  line_ = sample;
  window_start_ = sample.at;
  window_min_ = sample;
  newest_device_ = t_device;
  newest_mapped_ = LabTime{t_device + sample.offset - config_.latency};
}

bool DeviceClock::restarted(Nanoseconds t_device, const Point& sample) noexcept {
  if (newest_device_ - t_device > config_.restart_gap) return true;
  if (line_->offset - sample.offset > config_.restart_gap) return true;
  if (sample.offset - line_->offset <= config_.restart_gap) {
    late_since_.reset();
    return false;
  }
  if (!late_since_) late_since_ = sample.at;
  return sample.at - *late_since_ > kLatePatience;
}

/// Moves the line to `t`: with the drift, and up by as much of the deficit as the time allows.
void DeviceClock::creep(LabTime t) noexcept {
  const Nanoseconds span = std::max(t - line_->at, Nanoseconds{0});
  const Nanoseconds up = std::min(deficit_, share(span, config_.drift_ppm_max));
  deficit_ -= up;
  window_margin_ -= up;
  line_->offset += up + share(span, drift_ppm_);
  line_->at += span;
}

void DeviceClock::look_at_window(const Point& sample) noexcept {
  const Nanoseconds margin = sample.offset - line_->offset;
  if (margin >= window_margin_) return;
  window_min_ = sample;
  window_margin_ = std::max(margin, Nanoseconds{0});
  deficit_ = std::min(deficit_, window_margin_);
  if (margin < Nanoseconds{0}) line_->offset = sample.offset;
}

void DeviceClock::close_window(LabTime t) noexcept {
  if (previous_min_ && window_min_.at > previous_min_->at) {
    const Nanoseconds span = window_min_.at - previous_min_->at;
    const double raw = std::clamp(1e6 * seconds(window_min_.offset - previous_min_->offset) / seconds(span),
                                  -config_.drift_ppm_max, config_.drift_ppm_max);
    // Two minima close to each other say little about the slope.
    const double weight = std::min(1.0, seconds(span) / seconds(config_.window));
    drift_ppm_ += weight * (has_drift_ ? kDriftGain : 1.0) * (raw - drift_ppm_);
    has_drift_ = true;
  }
  previous_min_ = window_min_;
  deficit_ = window_margin_;
  window_margin_ = Nanoseconds::max();
  window_start_ = t;
}

}  // namespace motionlab
