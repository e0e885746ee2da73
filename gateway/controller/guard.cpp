#include "gateway/controller/guard.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::controller {
namespace {

/// Longest time that one step may claim to have passed: a late step must not buy a jump.
constexpr double kLongestStep = 0.005;

/// One command period, the age of a measurement, and the servo's lag.
constexpr double kReaction = 0.07;

/// What was asked and is not yet measured counts as travelled. A joint that slows down has more under way
/// than its last velocity tells, one that speeds up has at most that.
double travelled(double position, double last_speed, double under_way) {
  const double reaction = kReaction * last_speed;
  return position + (last_speed > 0 ? std::max(reaction, under_way) : std::min(reaction, under_way));
}

double towards_zero(double value, double by) {
  return value > 0 ? std::max(0.0, value - by) : std::min(0.0, value + by);
}

/// The greatest speed from which a stop at `deceleration` fits into `distance`.
double stopping_speed(double distance, double deceleration) {
  return distance > 0 ? std::sqrt(2 * deceleration * distance) : 0.0;
}

template <class Array>
bool finite(const Array& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

double Guard::guard_joint(std::size_t i, double wish, double q, double authority, double dt,
                          std::uint32_t& changed) const {
  double qd = wish;
  const auto bound = [&](double low, double high, std::uint32_t bit) {
    const double kept = std::clamp(qd, low, high);
    if (kept != qd) changed |= bit << i;
    qd = kept;
  };
  const double ahead = travelled(q, last_.qd_radps[i], under_way_[i]);
  const double a = limits_.stop_deceleration_radps2;
  const double up = stopping_speed(limits_.q_max_rad[i] - std::max(q, ahead), a);
  const double down = -stopping_speed(std::min(q, ahead) - limits_.q_min_rad[i], a);
  bound(down, up, kGuardPosition);
  const double fastest = authority * limits_.qd_max_radps[i];
  bound(-fastest, fastest, kGuardVelocity);
  const double before = last_.qd_radps[i];
  // Away from rest within the share of the limit, towards rest always at the stop deceleration at least.
  const double away = authority * limits_.qdd_max_radps2[i] * dt;
  const double towards = std::max(away, a * dt);
  const double low = before > 0 ? std::min(before - away, std::max(before - towards, 0.0)) : before - away;
  const double high = before < 0 ? std::max(before + away, std::min(before + towards, 0.0)) : before + away;
  bound(low, high, kGuardAcceleration);
  return qd;
}

double Guard::guard_winch(double wish, double length, double authority, double dt,
                          std::uint32_t& changed) const {
  const double a = limits_.wire_acceleration_max_mps2;
  const double fastest = authority * limits_.wire_speed_max_mps;
  const double before = last_.wire_speed_mps;
  const double ahead = travelled(length, before, under_way_[6]);
  const double out = std::min(fastest, stopping_speed(limits_.wire_max_m - std::max(length, ahead), a));
  const double in = -std::min(fastest, stopping_speed(std::min(length, ahead) - limits_.wire_min_m, a));
  const double speed = std::clamp(std::clamp(wish, in, out), before - a * dt, before + a * dt);
  if (speed != wish) changed |= kGuardWinch;
  return speed;
}

GuardedCommand Guard::step(const Inputs& in) {
  const double dt = std::isnan(in.dt_s) ? 0.0 : std::clamp(in.dt_s, 0.0, kLongestStep);
  const bool wish_finite = in.wish && finite(in.wish->qd_radps) && std::isfinite(in.wish->wire_speed_mps);
  const bool posture_finite =
      in.q_rad && finite(*in.q_rad) && in.wire_length_m && std::isfinite(*in.wire_length_m);
  const double authority = std::isfinite(in.authority) ? std::clamp(in.authority, 0.0, 1.0) : 0.0;
  GuardedCommand out;
  if (in.may_move && wish_finite && posture_finite) {
    out.follow = true;
    for (std::size_t i = 0; i < 6; ++i) {
      out.qd_radps[i] = guard_joint(i, in.wish->qd_radps[i], (*in.q_rad)[i], authority, dt, out.changed);
    }
    out.wire_speed_mps = guard_winch(in.wish->wire_speed_mps, *in.wire_length_m, authority, dt, out.changed);
  } else {
    if (in.may_move) out.changed |= kGuardNotFinite;
    for (std::size_t i = 0; i < 6; ++i) {
      out.qd_radps[i] = towards_zero(last_.qd_radps[i], limits_.stop_deceleration_radps2 * dt);
    }
    out.wire_speed_mps = towards_zero(last_.wire_speed_mps, limits_.wire_acceleration_max_mps2 * dt);
    // The robot is let go of only at rest: letting go earlier would stop it in one step.
    out.follow =
        in.may_move || std::any_of(out.qd_radps.begin(), out.qd_radps.end(), [](double v) { return v != 0; });
  }
  if (out.changed != 0) ++changed_count_;
  for (std::size_t i = 0; i < 7; ++i) {
    const double speed = i < 6 ? out.qd_radps[i] : out.wire_speed_mps;
    under_way_[i] += dt * (speed - under_way_[i] / kReaction);
  }
  last_ = out;
  return out;
}

bool Guard::at_rest() const {
  return last_.wire_speed_mps == 0 &&
         std::all_of(last_.qd_radps.begin(), last_.qd_radps.end(), [](double v) { return v == 0; });
}

}  // namespace motionlab::controller
