#include "gateway/monitor/motion_score.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace motionlab::monitor {

double degrees(double rad) {
  return rad * (180.0 / std::numbers::pi);
}

double nearest_seconds(Nanoseconds d) {
  return static_cast<double>(d.count()) / 1e9;
}

double swing_deg(const MotionSample& sample) {
  const auto& [alpha, beta] = sample.swing_rad;
  return degrees(std::sqrt(alpha * alpha + beta * beta));
}

double load_error_m(const MotionSample& sample) {
  const auto& [x, y, z] = sample.load_error_m;
  return std::sqrt(x * x + y * y + z * z);
}

void MotionStatistics::add(const MotionSample& sample) {
  ++samples_;
  for (std::size_t i = 0; i < 2; ++i) {
    swing_squares_[i] += sample.swing_rad[i] * sample.swing_rad[i];
    swing_axis_max_rad_[i] = std::max(swing_axis_max_rad_[i], std::abs(sample.swing_rad[i]));
  }
  for (std::size_t i = 0; i < 3; ++i) {
    load_squares_[i] += sample.load_error_m[i] * sample.load_error_m[i];
    tool_squares_[i] += sample.tool_error_m[i] * sample.tool_error_m[i];
  }
  swing_max_deg_ = std::max(swing_max_deg_, swing_deg(sample));
  load_error_max_m_ = std::max(load_error_max_m_, load_error_m(sample));
  // Welford's recurrence: the spread may be far smaller than the mean.
  const double off = sample.load_error_m[2] - height_mean_;
  height_mean_ += off / static_cast<double>(samples_);
  height_squares_ += off * (sample.load_error_m[2] - height_mean_);
}

std::optional<MotionScore> MotionStatistics::score() const {
  if (samples_ == 0) return std::nullopt;
  const auto n = static_cast<double>(samples_);
  MotionScore score;
  score.samples = samples_;
  score.swing_rms_deg = degrees(std::sqrt((swing_squares_[0] + swing_squares_[1]) / n));
  score.swing_max_deg = swing_max_deg_;
  for (std::size_t i = 0; i < 2; ++i) {
    score.swing_axis_rms_deg[i] = degrees(std::sqrt(swing_squares_[i] / n));
    score.swing_axis_max_deg[i] = degrees(swing_axis_max_rad_[i]);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    score.load_error_rms_m[i] = std::sqrt(load_squares_[i] / n);
    score.tool_error_rms_m[i] = std::sqrt(tool_squares_[i] / n);
  }
  score.load_error_rms_norm_m = std::sqrt((load_squares_[0] + load_squares_[1] + load_squares_[2]) / n);
  score.load_error_max_m = load_error_max_m_;
  score.tool_error_rms_norm_m = std::sqrt((tool_squares_[0] + tool_squares_[1] + tool_squares_[2]) / n);
  score.heave_residual_rms_m = std::sqrt(height_squares_ / n);
  return score;
}

void Settling::add(LabTime t, double swing_deg) {
  last_ = t;
  if (swing_deg > kWithin_deg) last_outside_ = t;
}

std::optional<double> Settling::time_s(LabTime since) const {
  const LabTime settled = std::max(since, last_outside_.value_or(since));
  if (!last_ || *last_ - settled < kStayed) return std::nullopt;
  return nearest_seconds(settled - since);
}

}  // namespace motionlab::monitor
