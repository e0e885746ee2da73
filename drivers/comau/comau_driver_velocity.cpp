#include "drivers/comau/comau_driver_velocity.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::comau {
namespace {

bool all_finite(const Joints& values) noexcept {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

/// The float nearest to `value`, or its neighbour on the side of `before` and of zero if rounding would make
/// the step or the speed greater than allowed.
float to_wire(double value, double before, double step_max, double speed_max) noexcept {
  auto rounded = static_cast<float>(value);
  if (std::abs(static_cast<double>(rounded) - before) > step_max) {
    rounded = std::nextafter(rounded, static_cast<float>(before));
  }
  return std::abs(static_cast<double>(rounded)) > speed_max ? std::nextafter(rounded, 0.0F) : rounded;
}

/// The greatest speed from which a stop in steps of `period` fits into `distance`.
double stopping_speed(double distance, double deceleration, double period) noexcept {
  return std::max(0.0, std::sqrt(2.0 * deceleration * std::max(0.0, distance)) - 0.5 * deceleration * period);
}

/// Periods that make up at least this time; half a period of slack for the rounding of times.
bool lasted(int periods, double period_s, double time_s) noexcept {
  return (periods + 0.5) * period_s > time_s;
}

}  // namespace

Command VelocityShaper::brake() noexcept {
  periods_of_following_ = 0;
  if (holding()) return current_;
  bool at_rest = true;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    at_rest = at_rest && current_.qd_radps[i] == 0.0F;
    const double before = static_cast<double>(current_.qd_radps[i]);
    const double step = config_.stop_deceleration_radps2[i] * config_.period_s;
    const double after = before - std::clamp(before, -step, step);
    current_.qd_radps[i] = to_wire(after, before, step, std::abs(before));
  }
  periods_at_rest_ = at_rest ? periods_at_rest_ + 1 : 0;
  if (at_rest && lasted(periods_at_rest_, config_.period_s, config_.rest_before_hold_s)) {
    current_ = {};
    under_way_rad_ = {};
  }
  note_under_way();
  return current_;
}

Command VelocityShaper::follow(const Joints& qd_wanted_radps, const Joints& q_measured_rad) noexcept {
  if (!all_finite(qd_wanted_radps) || !all_finite(q_measured_rad)) return brake();
  const bool from_hold = holding();
  current_.mode = static_cast<std::int32_t>(Mode::follow);
  periods_at_rest_ = 0;
  periods_of_following_ = from_hold ? 0 : periods_of_following_ + 1;
  const bool at_rest = current_.qd_radps == Command{}.qd_radps;
  if (at_rest && !lasted(periods_of_following_, config_.period_s, config_.rest_before_motion_s)) {
    note_under_way();
    return current_;
  }
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double before = static_cast<double>(current_.qd_radps[i]);
    const double step =
        std::max(config_.qdd_max_radps2[i], config_.stop_deceleration_radps2[i]) * config_.period_s;
    const double qd = limited(i, qd_wanted_radps[i], q_measured_rad[i]);
    current_.qd_radps[i] = to_wire(qd, before, step, config_.qd_max_radps[i]);
  }
  note_under_way();
  return current_;
}

double VelocityShaper::limited(std::size_t i, double qd_wanted, double q_measured) const noexcept {
  const double T = config_.period_s;
  const double a = config_.stop_deceleration_radps2[i];
  const double before = static_cast<double>(current_.qd_radps[i]);

  // A joint that slows down has more under way than its last velocity tells, one that speeds up less.
  const double lead = config_.reaction_s * before;
  const double ahead = std::max({0.0, lead, under_way_rad_[i]});
  const double behind = std::min({0.0, lead, under_way_rad_[i]});
  const double up = stopping_speed(config_.q_max_rad[i] - (q_measured + ahead), a, T);
  const double down = -stopping_speed((q_measured + behind) - config_.q_min_rad[i], a, T);
  const double fastest = config_.qd_max_radps[i];
  const double qd = std::clamp(std::clamp(qd_wanted, -fastest, fastest), down, up);

  const double away = config_.qdd_max_radps2[i] * T;
  const double towards = std::max(away, a * T);
  const double low = before > 0 ? std::min(before - away, std::max(before - towards, 0.0)) : before - away;
  const double high = before < 0 ? std::max(before + away, std::min(before + towards, 0.0)) : before + away;
  return std::clamp(qd, low, high);
}

void VelocityShaper::note_under_way() noexcept {
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double qd = static_cast<double>(current_.qd_radps[i]);
    under_way_rad_[i] += config_.period_s * (qd - under_way_rad_[i] / config_.reaction_s);
  }
}

}  // namespace motionlab::comau
