#include "gateway/estimator/second_ship.hpp"

#include <algorithm>
#include <cmath>

#include "gateway/estimator/mru_readings.hpp"
#include "gateway/estimator/sane.hpp"

namespace motionlab::estimator {
namespace {

/// After a silence this long nothing that was known holds any more.
constexpr Nanoseconds kLongestGap = 500ms;
constexpr Nanoseconds kAheadTolerance = 10ms;
constexpr double kLongestStep = 0.01;
/// Slower velocities are bias and tilt of the mounting, not waves; and what has been integrated leaks away.
constexpr double kSlow_s = 20.0, kLeak_s = 8.0;

}  // namespace

SecondShip::SecondShip(const MruMount& mount, const ShipBelief& ship, const MruBelief& mru, double gravity)
    : mount_(mount), belief_(mru), gravity_(gravity), model_(ship, mru), R_WD_(level_frame(mount.X_WN.R)) {}

void SecondShip::begin(LabTime t) {
  filter_.x.setZero();
  filter_.P = model_.prior();
  slow_v_ = place_ = Eigen::Vector3d::Zero();
  t_ = t;
  heard_since_ = t;
}

void SecondShip::step(LabTime t, const std::optional<topic::Mru>& mru) {
  now_ = t;
  if (heard_since_ && t - t_ > kLongestGap) heard_since_.reset();
  if (mru && mru->sequence_number != seen_) {
    seen_ = mru->sequence_number;
    const LabTime measured = from_ns(mru->t_measured_ns);
    const bool usable =
        mru->stable && sane(*mru) && measured <= t + kAheadTolerance && t - measured <= kLongestGap;
    if (usable && !heard_since_) begin(measured);
    if (usable && measured >= t_) {
      for (double left = seconds(measured - t_); left > 0; left -= kLongestStep) {
        predict(std::min(left, kLongestStep));
      }
      integrate(seconds(measured - t_));
      t_ = measured;
      constexpr double kGateSigma = 8.0;
      const ShipView ship(filter_.x.data(), mount_.X_WN.p, R_WD_);
      const MruReadings readings = compare(*mru, ship, mount_, belief_, gravity_);
      math::SparseUpdates<ShipStates::kSize, kMruReadings> updates(filter_);
      for (const auto& r : readings) updates.update(r.row, r.innovation, r.sd * r.sd, kGateSigma);
    }
  }
  valid_ = heard_since_ && t_ - *heard_since_ >= kSettling;
}

void SecondShip::predict(double dt) {
  const ShipModel::Step step = model_.over(dt);
  step.carry(filter_.x);
  step.carry_covariance(filter_.P);
  step.add_noise(filter_.P);
}

void SecondShip::integrate(double dt) {
  const Eigen::Vector3d v = ShipView(filter_.x.data(), mount_.X_WN.p, R_WD_).triple(1, 0);
  slow_v_ += dt / kSlow_s * (v - slow_v_);
  place_ += dt * (v - slow_v_ - place_ / kLeak_s);
}

math::BodyMotion SecondShip::motion() const {
  Filter::Vector ahead = filter_.x;
  const double dt = std::clamp(seconds(now_ - t_), 0.0, 0.1);
  model_.over(dt).carry(ahead);
  math::BodyMotion motion = ShipView(ahead.data(), mount_.X_WN.p, R_WD_).motion();
  motion.v_WB -= slow_v_;
  motion.X_WB.p = mount_.X_WN.p + place_ + dt * motion.v_WB;
  return motion;
}

Eigen::Vector3d SecondShip::p_sd_m() const {
  Eigen::Vector3d sd;
  for (int i = 0; i < 3; ++i) {
    const int a = ShipStates::axis(i);
    sd[i] = std::sqrt(std::max(filter_.P(a, a), 0.0));
  }
  return sd;
}

}  // namespace motionlab::estimator
