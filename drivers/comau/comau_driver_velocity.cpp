#include "drivers/comau/comau_driver_velocity.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::comau {
namespace {

/// The float nearest to `value` that does not lie beyond the limit: rounding must not add speed.
float to_wire(double value, double limit) noexcept {
  const auto rounded = static_cast<float>(std::clamp(value, -limit, limit));
  return std::abs(static_cast<double>(rounded)) > limit ? std::nextafter(rounded, 0.0F) : rounded;
}

/// One step from `from` to `to` of at most `step` >= 0.
double approach(double from, double to, double step) noexcept {
  return from + std::clamp(to - from, -step, step);
}

}  // namespace

Command VelocityShaper::brake(bool sudden) noexcept {
  rejoining_ = holding() ? rejoining_ && sudden : rejoining_ || sudden;
  if (holding()) return current_;
  bool at_rest = true;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    at_rest = at_rest && current_.qd_radps[i] == 0.0F;
    const double step = config_.stop_deceleration_radps2[i] * config_.period_s;
    current_.qd_radps[i] = static_cast<float>(approach(static_cast<double>(current_.qd_radps[i]), 0.0, step));
  }
  periods_at_rest_ = at_rest ? periods_at_rest_ + 1 : 0;
  const double half_period_s = 0.5 * config_.period_s;
  if (at_rest && periods_at_rest_ * config_.period_s + half_period_s > config_.rest_before_hold_s)
    current_ = {};
  return current_;
}

Command VelocityShaper::follow(const Joints& qd_wanted_radps) noexcept {
  current_.mode = static_cast<std::int32_t>(Mode::follow);
  periods_at_rest_ = 0;
  bool reached = true;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double limit = config_.qd_max_radps[i];
    double qd = std::clamp(qd_wanted_radps[i], -limit, limit);
    if (rejoining_) {
      const double step = config_.stop_deceleration_radps2[i] * config_.period_s;
      const double nearer = approach(static_cast<double>(current_.qd_radps[i]), qd, step);
      reached = reached && nearer == qd;
      qd = nearer;
    }
    current_.qd_radps[i] = to_wire(qd, limit);
  }
  rejoining_ = rejoining_ && !reached;
  return current_;
}

}  // namespace motionlab::comau
