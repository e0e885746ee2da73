#include "gateway/estimator/second_ship.hpp"

#include <algorithm>
#include <cmath>

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
    : mount_(mount),
      belief_(mru),
      gravity_(gravity),
      axis_model_(ship.period_s, ship.damping),
      R_WD_(level_frame(mount.X_WN.R)) {
  for (std::size_t i = 0; i < sd_.size(); ++i) {
    sd_[i] = i < 3 ? ship.translation_sd_m : ship.rotation_sd_rad;
    noise_density_[i] = sd_[i] * sd_[i] / axis_model_.stationary()(0, 0);
  }
}

void SecondShip::begin(LabTime t) {
  filter_ = Filter{};
  for (int i = 0; i < ShipStates::kAxes; ++i) {
    filter_.P.block<4, 4>(ShipStates::axis(i), ShipStates::axis(i)) =
        noise_density_[static_cast<std::size_t>(i)] * axis_model_.stationary();
  }
  const auto set_sd = [this](int first, int count, double sd) {
    for (int i = first; i < first + count; ++i) filter_.P(i, i) = sd * sd;
  };
  set_sd(ShipStates::kAccelerationBias, 3, belief_.acceleration_bias_sd_mps2);
  set_sd(ShipStates::kRateBias, 3, belief_.rate_bias_sd_radps);
  set_sd(ShipStates::kTiltError, 2, belief_.tilt_error_sd_rad);
  set_sd(ShipStates::kYawError, 1, belief_.yaw_start_sd_rad);
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
      take_mru(*mru, ship, mount_, belief_, gravity_,
               [this](Reading, const math::SparseRow& row, double innovation, double sd) {
                 filter_.update(row, innovation, sd * sd, kGateSigma);
               });
    }
  }
  valid_ = heard_since_ && t_ - *heard_since_ >= kSettling;
}

void SecondShip::predict(double dt) {
  const Eigen::Matrix4d A = axis_model_.transition(dt);
  const Eigen::Matrix4d Q = ShipAxis::noise(dt);
  const double decay = std::exp(-dt / belief_.tilt_error_correlation_s);
  for (int i = 0; i < ShipStates::kAxes; ++i) {
    const int a = ShipStates::axis(i);
    filter_.x.segment<4>(a) = A * filter_.x.segment<4>(a).eval();
    const Eigen::Matrix<double, 4, ShipStates::kSize> rows = A * filter_.P.middleRows<4>(a);
    filter_.P.middleRows<4>(a) = rows;
  }
  for (int i = 0; i < ShipStates::kAxes; ++i) {
    const int a = ShipStates::axis(i);
    const Eigen::Matrix<double, ShipStates::kSize, 4> columns = filter_.P.middleCols<4>(a) * A.transpose();
    filter_.P.middleCols<4>(a) = columns;
    filter_.P.block<4, 4>(a, a) += noise_density_[static_cast<std::size_t>(i)] * Q;
  }
  filter_.x.segment<2>(ShipStates::kTiltError) *= decay;
  filter_.P.middleRows<2>(ShipStates::kTiltError) *= decay;
  filter_.P.middleCols<2>(ShipStates::kTiltError) *= decay;
  const double tilt = belief_.tilt_error_sd_rad, walk = belief_.yaw_drift_rad_sqrt_s;
  for (int i = 0; i < 2; ++i) {
    filter_.P(ShipStates::kTiltError + i, ShipStates::kTiltError + i) += tilt * tilt * (1 - decay * decay);
  }
  filter_.P(ShipStates::kYawError, ShipStates::kYawError) += walk * walk * dt;
}

void SecondShip::integrate(double dt) {
  const Eigen::Vector3d v = ShipView(filter_.x.data(), mount_.X_WN.p, R_WD_).triple(1, 0);
  slow_v_ += dt / kSlow_s * (v - slow_v_);
  place_ += dt * (v - slow_v_ - place_ / kLeak_s);
}

math::BodyMotion SecondShip::motion() const {
  Filter::Vector ahead = filter_.x;
  const double dt = std::clamp(seconds(now_ - t_), 0.0, 0.1);
  for (int i = 0; i < ShipStates::kAxes; ++i) {
    const int a = ShipStates::axis(i);
    ahead.segment<4>(a) = axis_model_.propagate(filter_.x.segment<4>(a), dt);
  }
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
