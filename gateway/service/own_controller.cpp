#include "gateway/service/own_controller.hpp"

#include <algorithm>

#include "gateway/controller/load_keeper.hpp"
#include "gateway/controller/thesis_keeper.hpp"

namespace motionlab::service {
namespace {

/// How long the compensation takes to come back after the load was found again.
constexpr double kShareBack_s = 2.0;
/// A reference that moves goes on moving for so long after it was last told.
constexpr Nanoseconds kReferenceGoesOn = 250ms;
/// No place of any laboratory is further from its origin.
constexpr double kFarthestReference_m = 20.0;
/// No further ahead is a command decided.
constexpr Nanoseconds kFarthestSend = 10ms;

std::unique_ptr<controller::Keeper> keeper_of(const GatewayConfig& config) {
  const auto& k = config.keeper;
  if (config.law == ControlLaw::ours) return std::make_unique<controller::LoadKeeper>(k);
  return std::make_unique<controller::ThesisKeeper>(
      controller::ThesisKeeperConfig{.arm = k.arm,
                                     .X_WN = config.belief.calibration.X_WN,
                                     .X_BR = k.X_BR,
                                     .servo = k.servo,
                                     .command_period_s = k.command_period_s,
                                     .command_latency_s = k.command_latency_s,
                                     .observer_gain_per_s = k.observer_gain_per_s});
}

}  // namespace

OwnController::OwnController(const GatewayConfig& config)
    : control_period_s_(config.control_period_s),
      coast_s_(config.qualisys.coast_s),
      rest_by_s_(config.qualisys.rest_by_s),
      estimator_(config.belief),
      keeper_(keeper_of(config)),
      reference_{Eigen::Map<const Eigen::Vector3d>(config.p_world_load_reference_m.data())} {}

void OwnController::take(const topic::Snapshot& inputs) {
  for (const auto& reference : inputs.references) {
    const Eigen::Map<const Eigen::Vector3d> p(reference.p_world_load_m.data());
    const Eigen::Map<const Eigen::Vector3d> v(reference.v_world_load_mps.data());
    // A reference is a wish like any other: only a possible one counts, and the guard has the last word.
    const bool possible = reference.frame <= topic::ReferenceFrame::em1500 && p.allFinite() &&
                          v.allFinite() &&
                          std::max(p.cwiseAbs().maxCoeff(), v.cwiseAbs().maxCoeff()) <= kFarthestReference_m;
    if (!possible) continue;
    reference_ = {p, v, reference.frame == topic::ReferenceFrame::em1500};
    reference_moved_ = from_ns(inputs.t_ns);
  }
  for (const auto& sent : inputs.sent) keeper_->sent(from_ns(sent.t_created_ns), sent);
}

topic::Estimate OwnController::estimate(const Snapshot& now) {
  return estimator_.step({now.t, now.mru, now.load, now.platform, now.arm, now.winch, now.second_mru});
}

std::optional<controller::Wish> OwnController::wish(const Snapshot& now, const topic::Estimate& estimate,
                                                    std::optional<LabTime> load_seen, bool engaged) {
  coast(now.t, load_seen, engaged);
  if (!estimate.valid || !now.arm) return std::nullopt;
  const LabTime t_send = std::clamp(now.t_next_send, now.t, now.t + kFarthestSend);
  return keeper_->step({now.t, t_send, estimate, *now.arm, reference_at(now.t), horizontal_share_, engaged});
}

controller::LoadReference OwnController::reference_at(LabTime t) const {
  controller::LoadReference now = reference_;
  if (!reference_moved_) return now;
  const Nanoseconds since = std::min(t - *reference_moved_, kReferenceGoesOn);
  now.p_WL += seconds(since) * now.v_WL;
  if (since == kReferenceGoesOn) now.v_WL.setZero();
  return now;
}

void OwnController::coast(LabTime t, std::optional<LabTime> load_seen, bool engaged) {
  const double unseen = load_seen ? seconds(t - *load_seen) : rest_by_s_;
  const double wanted = std::clamp((rest_by_s_ - unseen) / (rest_by_s_ - coast_s_), 0.0, 1.0);
  // Given back slowly: the load may be found far from where it was lost.
  const double most = horizontal_share_ + control_period_s_ / kShareBack_s;
  horizontal_share_ = engaged ? std::min(wanted, most) : 1.0;
}

}  // namespace motionlab::service
