#include "gateway/controller/guard.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::controller {
namespace {

/// Longest time that one step may claim to have passed: a late step must not buy a jump.
constexpr double kLongestStep = 0.005;

/// One command period, the age of a measurement, and the servo's lag.
constexpr double kReaction = 0.07;

using Vector7 = Eigen::Matrix<double, 7, 1>;

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

bool finite(const math::RigidTransform& X) {
  return X.R.allFinite() && X.p.allFinite();
}

Vector7 speeds_of(const std::array<double, 6>& qd, double wire) {
  Vector7 speeds;
  speeds << Eigen::Map<const Eigen::Matrix<double, 6, 1>>(qd.data()), wire;
  return speeds;
}

std::uint32_t bit_of(FenceKind kind) {
  switch (kind) {
    case FenceKind::workspace:
      return kGuardWorkspace;
    case FenceKind::floor:
      return kGuardFloor;
    case FenceKind::second_platform:
      break;
  }
  return kGuardSecondPlatform;
}

}  // namespace

double Guard::guard_joint(std::size_t i, double wish, double q, double authority, double dt,
                          std::uint32_t& changed) const {
  double qd = wish;
  const auto bound = [&](double low, double high, std::uint32_t bit) {
    const double kept = std::clamp(qd, low, high);
    if (kept != qd) changed |= bit;
    qd = kept;
  };
  const double before = last_.qd_radps[i];
  // First, because what keeps the limits may need a harder brake than a wish may ask for.
  const double smooth = before + last_qdd_radps2_[i] * dt, jolt = limits_.jerk_max_radps3 * dt * dt;
  bound(smooth - jolt, smooth + jolt, kGuardJerk);
  const double ahead = travelled(q, before, under_way_[i]);
  const double a = limits_.stop_deceleration_radps2;
  const double up = stopping_speed(limits_.q_max_rad[i] - std::max(q, ahead), a);
  const double down = -stopping_speed(std::min(q, ahead) - limits_.q_min_rad[i], a);
  bound(down, up, kGuardPosition << i);
  const double fastest = authority * limits_.qd_max_radps[i];
  bound(-fastest, fastest, kGuardVelocity << i);
  // Away from rest within the share of the limit, towards rest always at the stop deceleration at least.
  const double away = authority * limits_.qdd_max_radps2[i] * dt;
  const double towards = std::max(away, a * dt);
  const double low = before > 0 ? std::min(before - away, std::max(before - towards, 0.0)) : before - away;
  const double high = before < 0 ? std::max(before + away, std::min(before + towards, 0.0)) : before + away;
  bound(low, high, kGuardAcceleration << i);
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

std::uint32_t Guard::reasons_to_brake(const Inputs& in) const {
  const bool wish_finite = in.wish && finite(in.wish->qd_radps) && std::isfinite(in.wish->wire_speed_mps);
  const bool posture_finite =
      in.q_rad && finite(*in.q_rad) && in.wire_length_m && std::isfinite(*in.wire_length_m);
  const bool base_known = !limits_.fences || (in.X_WR && finite(*in.X_WR));
  // Written so that an age that is no number is too old.
  const bool fresh = in.q_age_s <= limits_.posture_age_max_s && in.wire_age_s <= limits_.posture_age_max_s;
  std::uint32_t reasons = 0;
  if (!wish_finite || !posture_finite || !base_known) reasons |= kGuardNotFinite;
  if (!fresh) reasons |= kGuardNotFresh;
  return reasons;
}

Vector7 Guard::decelerations() const {
  Vector7 a = Vector7::Constant(limits_.stop_deceleration_radps2);
  a[6] = limits_.wire_acceleration_max_mps2;
  return a;
}

Wish Guard::within_fences(const std::array<Fence, kFences>& all, const Wish& wish,
                          std::uint32_t& changed) const {
  const Vector7 wanted = speeds_of(wish.qd_radps, wish.wire_speed_mps);
  double share = 1.0;
  for (const Fence& fence : all) {
    const double fits = share_that_fits(fence, wanted, decelerations());
    if (fits < 1.0) changed |= bit_of(fence.kind);
    share = std::min(share, fits);
  }
  Wish kept = wish;
  for (double& qd : kept.qd_radps) qd *= share;
  kept.wire_speed_mps *= share;
  return kept;
}

void Guard::follow(const Inputs& in, double authority, double dt, GuardedCommand& out) const {
  const std::array<double, 6>& q = *in.q_rad;
  const double wire = *in.wire_length_m;
  Wish wish = *in.wish;
  const double torque = in.motor_torque_nm.value_or(0.0);
  const bool slack = torque<limits_.motor_torque_min_nm, held = torque> limits_.motor_torque_max_nm;
  if (in.motor_torque_nm && ((slack && wish.wire_speed_mps > 0) || (held && wish.wire_speed_mps < 0))) {
    wish.wire_speed_mps = 0;
    out.changed |= kGuardTension;
  }
  std::array<Fence, kFences> all;
  if (limits_.fences) {
    Eigen::Vector3d q_ahead;
    for (std::size_t i = 0; i < 3; ++i) {
      q_ahead[static_cast<Eigen::Index>(i)] = travelled(q[i], last_.qd_radps[i], under_way_[i]);
    }
    all = fences(*limits_.fences, q_ahead, travelled(wire, last_.wire_speed_mps, under_way_[6]), *in.X_WR);
    wish = within_fences(all, wish, out.changed);
  }
  out.follow = true;
  for (std::size_t i = 0; i < 6; ++i) {
    out.qd_radps[i] = guard_joint(i, wish.qd_radps[i], q[i], authority, dt, out.changed);
  }
  out.wire_speed_mps = guard_winch(wish.wire_speed_mps, wire, authority, dt, out.changed);
  if (!limits_.fences) return;
  // The limits of the joints bend the direction: what then no longer fits is braked.
  const Vector7 speeds = speeds_of(out.qd_radps, out.wire_speed_mps);
  for (const Fence& fence : all) {
    if (share_that_fits(fence, speeds, decelerations()) >= 1.0) continue;
    const std::uint32_t changed = out.changed | bit_of(fence.kind);
    out = brake(true, dt);
    out.changed = changed;
    return;
  }
}

GuardedCommand Guard::brake(bool keep, double dt) const {
  GuardedCommand out;
  for (std::size_t i = 0; i < 6; ++i) {
    out.qd_radps[i] = towards_zero(last_.qd_radps[i], limits_.stop_deceleration_radps2 * dt);
  }
  out.wire_speed_mps = towards_zero(last_.wire_speed_mps, limits_.wire_acceleration_max_mps2 * dt);
  // The robot is let go of only at rest: letting go earlier would stop it in one step.
  out.follow = keep || std::any_of(out.qd_radps.begin(), out.qd_radps.end(), [](double v) { return v != 0; });
  return out;
}

GuardedCommand Guard::step(const Inputs& in) {
  const double dt = std::isnan(in.dt_s) ? 0.0 : std::clamp(in.dt_s, 0.0, kLongestStep);
  const double authority = std::isfinite(in.authority) ? std::clamp(in.authority, 0.0, 1.0) : 0.0;
  const bool permitted = in.may_move && in.lease && in.lease->valid(in.t);
  const std::uint32_t reasons = permitted ? reasons_to_brake(in) : 0;
  GuardedCommand out;
  if (permitted && reasons == 0) {
    follow(in, authority, dt, out);
  } else {
    out = brake(permitted, dt);
    out.changed = reasons;
  }
  if (out.changed != 0) ++changed_count_;
  for (std::size_t i = 0; i < 7; ++i) {
    const double speed = i < 6 ? out.qd_radps[i] : out.wire_speed_mps;
    under_way_[i] += dt * (speed - under_way_[i] / kReaction);
    if (i < 6 && dt > 0) last_qdd_radps2_[i] = (speed - last_.qd_radps[i]) / dt;
  }
  last_ = out;
  return out;
}

void Guard::forget_command() {
  last_ = {};
  last_qdd_radps2_ = {};
  under_way_ = {};
}

bool Guard::at_rest() const {
  return last_.wire_speed_mps == 0 &&
         std::all_of(last_.qd_radps.begin(), last_.qd_radps.end(), [](double v) { return v == 0; });
}

}  // namespace motionlab::controller
