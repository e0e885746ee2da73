#include "drivers/mru/mru_wire_motion.hpp"

namespace motionlab::mru {

double hippy_roll(double euler_roll_rad, double pitch_rad) noexcept {
  return std::asin(std::sin(euler_roll_rad) * std::cos(pitch_rad));
}

double euler_roll(double hippy_roll_rad, double pitch_rad) noexcept {
  const double sine = std::sin(hippy_roll_rad) / std::cos(pitch_rad);
  // Beyond a right angle the sine falls again and would pass for a smaller roll.
  const bool exists = std::abs(hippy_roll_rad) <= std::numbers::pi / 2 && std::abs(sine) <= 1.0;
  return exists ? std::asin(sine) : kNotTold;
}

double yaw_of_heading(double heading_deg) noexcept {
  return kDegree * (heading_deg > 180.0 ? heading_deg - 360.0 : heading_deg);
}

double heading_of_yaw(double yaw_rad) noexcept {
  const double turned = std::fmod(yaw_rad / kDegree, 360.0);
  // A tiny negative angle plus 360 rounds to 360, which is 0.
  const double heading = turned < 0.0 ? turned + 360.0 : turned;
  return heading >= 360.0 ? 0.0 : heading;
}

Motion::Triple heading_from_ned(const Motion::Triple& ned, double yaw_rad) noexcept {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
  return {c * ned[0] + s * ned[1], -s * ned[0] + c * ned[1], ned[2]};
}

Motion::Triple ned_from_heading(const Motion::Triple& heading, double yaw_rad) noexcept {
  return heading_from_ned(heading, -yaw_rad);
}

Status check_plausible(const Motion& motion, const PlausibilityLimits& limits) noexcept {
  const auto within = [](double value, double limit) {
    return std::isnan(value) || std::abs(value) <= limit;
  };
  const auto& [roll, pitch, yaw] = motion.euler_heading_mru_rad;
  if (!(std::abs(roll) <= limits.tilt_rad) || !(std::abs(pitch) <= limits.tilt_rad)) {
    return Fault{Reason::bad_value, "roll or pitch is missing or beyond its limit: check format and units"};
  }
  if (!within(motion.p_heading_origin_m[2], limits.heave_m)) {
    return Fault{Reason::bad_value, "heave is beyond its limit: check format and units"};
  }
  for (const double rate : motion.omega_mru_radps) {
    if (!within(rate, limits.rate_radps)) {
      return Fault{Reason::bad_value, "a rate of turn is beyond its limit: check format and units"};
    }
  }
  return Done{};
}

}  // namespace motionlab::mru
