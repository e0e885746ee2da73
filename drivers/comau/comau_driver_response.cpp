#include "drivers/comau/comau_driver_response.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::comau {
namespace {

/// Slower than this nobody can tell moving from noise.
constexpr double kSlowestWorthWatching_radps = 0.02;
/// A joint that was told to go less far than this is not judged.
constexpr double kShortestWorthWatching_rad = 0.002;
constexpr double kShareThatIsMotion = 0.1;
/// Squared steps of one second's motion at the slowest speed, in answers of 5 ms; less says nothing.
constexpr double kEnough_rad2 =
    200 * (0.005 * kSlowestWorthWatching_radps) * (0.005 * kSlowestWorthWatching_radps);

}  // namespace

void ResponseWatch::step(const std::array<float, kJointCount>& qd_sent_radps, const Joints& q_measured_rad,
                         double dt_s) noexcept {
  if (!begun_) {
    begun_ = true;
    q_before_rad_ = q_watched_rad_ = q_measured_rad;
    return;
  }
  learnt_s_ += dt_s;
  watch_whether(qd_sent_radps, q_measured_rad, dt_s);
  watch_how_much(qd_sent_radps, q_measured_rad, dt_s);
  q_before_rad_ = q_measured_rad;
}

void ResponseWatch::watch_whether(const std::array<float, kJointCount>& qd_sent_radps, const Joints& q_rad,
                                  double dt_s) noexcept {
  bool wanted = false;
  bool moves = false;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double sent = static_cast<double>(qd_sent_radps[i]);
    wanted = wanted || std::abs(sent) >= kSlowestWorthWatching_radps;
    told_rad_[i] += sent * dt_s;
    const double gone = std::copysign(1.0, told_rad_[i]) * (q_rad[i] - q_watched_rad_[i]);
    const double told = std::abs(told_rad_[i]);
    moves = moves || (told >= kShortestWorthWatching_rad && gone >= kShareThatIsMotion * told);
  }
  watched_s_ += dt_s;
  if (!wanted || moves) {
    q_watched_rad_ = q_rad;
    told_rad_ = {};
    watched_s_ = 0.0;
    ignored_ = false;
    return;
  }
  const bool worth = std::ranges::any_of(
      told_rad_, [](double told) { return std::abs(told) >= kShortestWorthWatching_rad; });
  ignored_ = worth && watched_s_ > config_.ignored_after_s;
}

void ResponseWatch::watch_how_much(const std::array<float, kJointCount>& qd_sent_radps, const Joints& q_rad,
                                   double dt_s) noexcept {
  const double follow = 1.0 - std::exp(-dt_s / config_.reaction_s);
  const double keep = std::exp(-dt_s / config_.memory_s);
  wanted_measured_ *= keep;
  wanted_squared_ *= keep;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    lagged_radps_[i] += follow * (static_cast<double>(qd_sent_radps[i]) - lagged_radps_[i]);
    const double wanted_rad = lagged_radps_[i] * dt_s;
    wanted_measured_ += wanted_rad * (q_rad[i] - q_before_rad_[i]);
    wanted_squared_ += wanted_rad * wanted_rad;
  }
}

double ResponseWatch::share() const noexcept {
  return learnt_s_ < config_.memory_s || wanted_squared_ < kEnough_rad2 ? 1.0
                                                                        : wanted_measured_ / wanted_squared_;
}

}  // namespace motionlab::comau
