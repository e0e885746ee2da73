#include "gateway/estimator/ship_model.hpp"

#include <cmath>

namespace motionlab::estimator {
namespace {

double square(double v) {
  return v * v;
}

}  // namespace

ShipModel::ShipModel(const ShipBelief& ship, const MruBelief& mru)
    : axis_(ship.period_s, ship.damping), mru_(mru) {
  for (std::size_t i = 0; i < density_.size(); ++i) {
    density_[i] = square(i < 3 ? ship.translation_sd_m : ship.rotation_sd_rad) / axis_.stationary()(0, 0);
  }
}

ShipModel::Covariance ShipModel::prior() const {
  Covariance P = Covariance::Zero();
  for (int i = 0; i < ShipStates::kAxes; ++i) {
    P.block<4, 4>(ShipStates::axis(i), ShipStates::axis(i)) =
        density_[static_cast<std::size_t>(i)] * axis_.stationary();
  }
  P.diagonal().segment<3>(ShipStates::kAccelerationBias).setConstant(square(mru_.acceleration_bias_sd_mps2));
  P.diagonal().segment<3>(ShipStates::kRateBias).setConstant(square(mru_.rate_bias_sd_radps));
  P.diagonal().segment<2>(ShipStates::kTiltError).setConstant(square(mru_.tilt_error_sd_rad));
  P(ShipStates::kYawError, ShipStates::kYawError) = square(mru_.yaw_start_sd_rad);
  return P;
}

ShipModel::Step ShipModel::over(double dt) const {
  Step step;
  step.A_ = axis_.transition(dt);
  step.Q_ = ShipAxis::noise(dt);
  step.density_ = density_;
  step.tilt_decay_ = std::exp(-dt / mru_.tilt_error_correlation_s);
  step.tilt_variance_ = square(mru_.tilt_error_sd_rad) * (1 - square(step.tilt_decay_));
  step.yaw_variance_ = square(mru_.yaw_drift_rad_sqrt_s) * dt;
  return step;
}

}  // namespace motionlab::estimator
