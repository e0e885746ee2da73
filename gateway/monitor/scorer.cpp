#include "gateway/monitor/scorer.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace motionlab::monitor {
namespace {

using Vector3 = std::array<double, 3>;

Vector3 difference(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

std::optional<Spread> spread(const Quantiles& of) {
  if (of.empty()) return std::nullopt;
  return Spread{of.at(0.50), of.at(0.99), of.max()};
}

/// Velocity, acceleration or position limit of a joint, as `motionlab/control` tells it.
bool held_back(std::uint32_t guard_changed, std::size_t joint) {
  constexpr std::uint32_t kFirstJoint = 1u << 0 | 1u << 8 | 1u << 16;
  return (guard_changed & kFirstJoint << joint) != 0;
}

}  // namespace

Scorer::Scorer(const ScorerConfig& config)
    : config_(config),
      p_WL_set_(config.p_world_load_m),
      p_WT_set_(config.p_world_tool_m),
      t_start_(config.t_start),
      age_us_(1, 200'000),
      step_us_(10, 20'000) {}

bool Scorer::moves_on(LabTime t) {
  if (t_newest_ && t <= *t_newest_) return false;
  if (!t_start_) t_start_ = t;
  if (t < *t_start_) return false;
  t_newest_ = t;
  run_until(t);
  return true;
}

void Scorer::run_until(LabTime t) {
  t_end_ = std::max(t, t_end_.value_or(t));
}

bool Scorer::in_window(std::int64_t t_ns) const {
  if (!t_start_) return false;
  const Nanoseconds t = from_ns(t_ns) - *t_start_;
  return t >= from_seconds(config_.score_from_s) &&
         (!config_.score_to_s || t <= from_seconds(*config_.score_to_s));
}

void Scorer::take(const topic::TruthWorld& truth) {
  const LabTime t = from_ns(truth.t_ns);
  if (config_.source != Source::truth || !moves_on(t)) return;
  newest_ = {truth.swing_rad, difference(truth.p_world_load_m, p_WL_set_),
             difference(truth.p_world_tool_m, p_WT_set_)};
  newest_baseline_ = {truth.twin_swing_rad, difference(truth.p_world_twin_load_m, config_.p_world_load_m),
                      difference(truth.p_world_twin_tool_m, config_.p_world_tool_m)};
  settling_.add(t, swing_deg(*newest_));
  baseline_settling_.add(t, swing_deg(*newest_baseline_));
  if (!in_window(truth.t_ns)) return;
  motion_.add(*newest_);
  baseline_.add(*newest_baseline_);
}

void Scorer::take(const topic::Estimate& estimate) {
  const LabTime t = from_ns(estimate.t_estimated_ns);
  if (config_.source != Source::estimate || !estimate.valid || !moves_on(t)) return;
  newest_ = {estimate.swing_rad, difference(estimate.p_world_load_m, p_WL_set_),
             difference(estimate.p_world_tool_m, p_WT_set_)};
  settling_.add(t, swing_deg(*newest_));
  if (in_window(estimate.t_estimated_ns)) motion_.add(*newest_);
}

void Scorer::take(const topic::Control& control) {
  faults_.take(control);
  if (!in_window(control.t_snapshot_ns)) return;
  if (control.following) age_us_.add(1e6 * control.age_mru_s);
  step_us_.add(control.step_time_us);
  for (std::size_t joint = 0; joint < limited_.size(); ++joint) {
    if (held_back(control.guard_changed, joint)) ++limited_[joint];
  }
}

void Scorer::take(const topic::ArmState& arm) {
  if (!in_window(arm.t_measured_ns)) return;
  if (!qd_max_radps_) qd_max_radps_.emplace();
  for (std::size_t joint = 0; joint < arm.qd_radps.size(); ++joint) {
    (*qd_max_radps_)[joint] = std::max((*qd_max_radps_)[joint], std::abs(arm.qd_radps[joint]));
  }
}

void Scorer::take(const topic::WinchState& winch) {
  if (!in_window(winch.t_measured_ns)) return;
  wire_speed_max_mps_ = std::max(wire_speed_max_mps_.value_or(0), std::abs(winch.wire_speed_mps));
}

void Scorer::take(const topic::Mode& mode) {
  if (mode.state == topic::ModeState::engaged) t_engaged_ = from_ns(mode.t_changed_ns);
  faults_.take(mode);
}

void Scorer::take(const topic::Reference& reference) {
  const Vector3 tool_above_load = difference(config_.p_world_tool_m, config_.p_world_load_m);
  p_WL_set_ = reference.p_world_load_m;
  for (std::size_t i = 0; i < 3; ++i) p_WT_set_[i] = p_WL_set_[i] + tool_above_load[i];
}

void Scorer::take(const topic::Health& health) {
  const std::string device = health.device.str();
  auto place = std::ranges::lower_bound(freshness_, device, {}, &Freshness::device);
  if (place == freshness_.end() || place->device != device) {
    constexpr std::size_t kMostDevices = 64;
    if (freshness_.size() == kMostDevices) return;
    place = freshness_.insert(place, Freshness{.device = device});
  }
  place->age_max_s = health.age_max_s;
  place->stale_after_s = health.stale_after_s;
}

double Scorer::elapsed_s() const {
  if (!t_start_ || !t_end_) return 0;
  const double elapsed = nearest_seconds(*t_end_ - *t_start_);
  return config_.score_to_s ? std::min(elapsed, *config_.score_to_s) : elapsed;
}

topic::Score Scorer::live(LabTime now) const {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  topic::Score score;
  score.t_ns = to_ns(now);
  score.from_truth = config_.source == Source::truth;
  score.duration_s = std::max(0.0, elapsed_s() - config_.score_from_s);
  if (newest_) {
    score.swing_now_deg = swing_deg(*newest_);
    score.load_error_now_m = load_error_m(*newest_);
  }
  if (const auto motion = motion_.score()) {
    score.swing_rms_deg = motion->swing_rms_deg;
    score.swing_max_deg = motion->swing_max_deg;
    score.load_error_rms_m = motion->load_error_rms_m;
    score.load_error_rms_norm_m = motion->load_error_rms_norm_m;
    score.heave_residual_rms_m = motion->heave_residual_rms_m;
  }
  const auto baseline = baseline_.score();
  score.baseline_swing_now_deg = newest_baseline_ ? swing_deg(*newest_baseline_) : kNone;
  score.baseline_load_error_now_m = newest_baseline_ ? load_error_m(*newest_baseline_) : kNone;
  score.baseline_swing_rms_deg = baseline ? baseline->swing_rms_deg : kNone;
  score.baseline_load_error_rms_norm_m = baseline ? baseline->load_error_rms_norm_m : kNone;
  return score;
}

Report Scorer::report() const {
  Report report;
  report.labels = config_.labels;
  report.duration_s = elapsed_s();
  report.score_from_s = config_.score_from_s;
  report.source = config_.source;
  report.motion = motion_.score();
  report.baseline = baseline_.score();
  if (t_start_) {
    const LabTime since = std::max(*t_start_, t_engaged_.value_or(*t_start_));
    report.settling_time_s = settling_.time_s(since);
    report.baseline_settling_time_s = baseline_settling_.time_s(since);
  }
  if (qd_max_radps_) {
    report.joint_speed_max_degps.emplace();
    std::ranges::transform(*qd_max_radps_, report.joint_speed_max_degps->begin(), degrees);
  }
  report.winch_speed_max_mps = wire_speed_max_mps_;
  report.limited = limited_;
  report.age_at_actuation_us = spread(age_us_);
  if (config_.timing) report.step_time_us = spread(step_us_);
  for (const FaultLog::Entry& entry : faults_.entries()) {
    if (!t_start_ || entry.t < *t_start_) continue;  // latched before this run
    FaultReport fault{.t_s = nearest_seconds(entry.t - *t_start_),
                      .fault = entry.name,
                      .code = entry.code,
                      .detected_after_s = std::nullopt,
                      .at_rest_after_s = std::nullopt};
    if (entry.caused && entry.latched) fault.detected_after_s = nearest_seconds(*entry.latched - entry.t);
    if (entry.at_rest) fault.at_rest_after_s = nearest_seconds(*entry.at_rest - entry.t);
    report.faults.push_back(fault);
  }
  report.freshness = freshness_;
  return report;
}

}  // namespace motionlab::monitor
