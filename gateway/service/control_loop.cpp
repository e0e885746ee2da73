#include "gateway/service/control_loop.hpp"

#include <algorithm>
#include <cmath>

#include "gateway/controller/load_keeper.hpp"
#include "gateway/controller/thesis_keeper.hpp"

namespace motionlab::service {
namespace {

using controller::Obstacle;
using topic::ModeState;

/// The estimate must know the tool this well before the gateway may be engaged.
constexpr double kToolSdToEngage = 0.05;
/// The arm must stand this still before the gateway may be engaged.
constexpr double kRestToEngage = 0.01;
/// How long the compensation takes to come back after the load was found again.
constexpr double kShareBack = 2.0;
/// How long before a state that nobody changed is told again, so that its lease is seen to live.
constexpr Nanoseconds kModeRepeat = 1s;
/// How far ahead the owner's lease reaches; renewed with every step of the built-in controller.
constexpr Nanoseconds kLease = 100ms;
/// A reference that moves goes on moving for so long after it was last told.
constexpr Nanoseconds kReferenceGoesOn = 250ms;
/// No place of any laboratory is further from its origin.
constexpr double kFarthestReference = 20.0;

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

ControlLoop::ControlLoop(const GatewayConfig& config, bus::LocalBus& local, ArmSchedule& schedule,
                         std::function<std::int64_t()> stopwatch)
    : config_(config),
      snapshots_(config, local),
      schedule_(schedule),
      stopwatch_(std::move(stopwatch)),
      estimator_(config.belief),
      keeper_(keeper_of(config)),
      guard_(config.limits),
      modes_(config.authority),
      reference_{Eigen::Map<const Eigen::Vector3d>(config.p_world_load_reference_m.data())},
      requests_(local.subscribe<topic::ModeRequest>()),
      references_(local.subscribe<topic::Reference>()),
      publish_estimate_(local.advertise<topic::Estimate>()),
      publish_control_(local.advertise<topic::Control>()),
      publish_arm_(local.advertise<topic::ArmCommand>()),
      publish_winch_(local.advertise<topic::WinchCommand>()),
      publish_mode_(local.advertise<topic::Mode>()),
      publish_event_(local.advertise<topic::Event>()) {}

void ControlLoop::step(LabTime t) {
  const std::int64_t begun = stopwatch_ ? stopwatch_() : 0;
  take_requests(t);
  const Snapshot now = snapshots_.at(t);
  const topic::Estimate estimate =
      estimator_.step({t, now.mru, now.load, now.platform, now.arm, now.winch, now.second_mru});

  modes_.step(facts(now, estimate));
  coast(now);

  const bool engaged = modes_.state() == ModeState::engaged;
  std::optional<controller::Wish> wish;
  if (estimate.valid && now.arm) {
    const LabTime t_send = std::max(t, from_ns(schedule_.t_next_send_ns.load(std::memory_order_relaxed)));
    wish = keeper_->step(
        {t, std::min(t_send, t + 10ms), estimate, *now.arm, reference_at(t), horizontal_share_, engaged});
  }
  wish_missing_ = engaged && !wish;

  const double dt = stepped_ ? seconds(t - *stepped_) : config_.control_period_s;
  stepped_ = t;
  const auto guarded = guard_.step({dt, modes_.may_move(), modes_.share_of_limits(), wish,
                                    now.arm ? std::optional(now.arm->q_rad) : std::nullopt,
                                    now.winch ? std::optional(now.winch->wire_length_m) : std::nullopt});
  command(now, guarded);
  publish_estimate_.publish(estimate);

  topic::Control control;
  control.sequence_number = ++steps_;
  control.t_snapshot_ns = to_ns(t);
  control.following = guarded.follow;
  if (wish) {
    control.qd_wish_radps = wish->qd_radps;
    control.wire_speed_wish_mps = wish->wire_speed_mps;
  }
  control.qd_command_radps = guarded.qd_radps;
  control.wire_speed_command_mps = guarded.wire_speed_mps;
  control.guard_changed = guarded.changed;
  control.guard_changed_count = guard_.changed_count();
  control.age_mru_s = age_s(now.mru, t);
  control.age_bodies_s = age_s(now.load, t);
  control.age_arm_s = age_s(now.arm, t);
  control.age_winch_s = age_s(now.winch, t);
  Eigen::Map<Eigen::Vector3d>(control.servo_omega_radps.data()) = keeper_->servo_omega_radps();
  if (stopwatch_) control.step_time_us = 1e-3 * static_cast<double>(stopwatch_() - begun);
  publish_control_.publish(control);
  tell_mode(t);
}

void ControlLoop::take_requests(LabTime t) {
  while (const auto request = requests_.next()) modes_.request(*request, t);
  while (const auto reference = references_.next()) {
    const Eigen::Map<const Eigen::Vector3d> p(reference->p_world_load_m.data());
    const Eigen::Map<const Eigen::Vector3d> v(reference->v_world_load_mps.data());
    // A reference is a wish like any other: only a possible one counts, and the guard has the last word.
    const bool possible = p.allFinite() && v.allFinite() &&
                          std::max(p.cwiseAbs().maxCoeff(), v.cwiseAbs().maxCoeff()) <= kFarthestReference;
    if (!possible) continue;
    reference_ = {p, v, reference->frame == topic::ReferenceFrame::em1500};
    reference_moved_ = t;
  }
  while (const auto sent = schedule_.sent.pop()) keeper_->sent(from_ns(sent->t_created_ns), *sent);
}

controller::LoadReference ControlLoop::reference_at(LabTime t) const {
  controller::LoadReference now = reference_;
  if (!reference_moved_) return now;
  const Nanoseconds since = std::min(t - *reference_moved_, kReferenceGoesOn);
  now.p_WL += seconds(since) * now.v_WL;
  if (since == kReferenceGoesOn) now.v_WL.setZero();
  return now;
}

controller::ModeFacts ControlLoop::facts(const Snapshot& now, const topic::Estimate& estimate) {
  controller::ModeFacts facts;
  facts.t = now.t;
  facts.links_up = now.mru && now.arm && now.winch;
  facts.at_rest = guard_.at_rest();
  if (now.load && now.load->tracked && fresh(now.load, now.t, config_.qualisys.rule.stale_after_s))
    load_seen_ = now.t;
  if (now.mru && now.mru->stable) mru_stable_ = now.t;

  // What ends an engagement: the first that holds is told.
  const auto unsafe = [&]() -> std::optional<Obstacle> {
    if (schedule_.deadman_lost.load(std::memory_order_relaxed)) {
      return Obstacle{
          "deadman_lost",
          "the deadman process is gone, nobody would stop the arm if the gateway died; restart the "
          "gateway"};
    }
    // The driver has let go of the arm by itself; going on would be resuming by itself.
    if (stepped_ && seconds(now.t - *stepped_) > config_.comau.driver.command_stale_after_s) {
      return Obstacle{
          "control_late",
          "control stood still for longer than the arm may wait; see what else this machine does, "
          "then reset"};
    }
    const auto stale = [](const char* code, const char* text) { return Obstacle{code, text}; };
    if (!fresh(now.mru, now.t, config_.mrus.front().rule.stale_after_s)) {
      return stale("mru1_stale", "no fresh sample from mru1; check the unit and its cable, then reset");
    }
    if (!fresh(now.arm, now.t, config_.comau.rule.stale_after_s)) {
      return stale("arm_stale",
                   "no fresh answer from the robot computer; check that its program runs, then reset");
    }
    if (!fresh(now.winch, now.t, config_.winch.rule.stale_after_s)) {
      return stale("winch_stale", "no fresh status from the winch controller; check the PLC, then reset");
    }
    if (now.winch->error)
      return Obstacle{"winch_fault", "the winch drive reports a fault; clear it at the drive, then reset"};
    // For as long as it may be silent: one datagram whose header was damaged says little.
    if (!mru_stable_ || seconds(now.t - *mru_stable_) > config_.mrus.front().rule.stale_after_s)
      return Obstacle{"mru1_unstable", "mru1 says that it is settling; wait until it is stable, then reset"};
    if (!estimate.valid)
      return Obstacle{"no_estimate", "there is no estimate; wait until the load is seen, then reset"};
    if (!load_seen_ || seconds(now.t - *load_seen_) > config_.qualisys.rest_by_s) {
      return Obstacle{"load_lost",
                      "the cameras have not seen the load for too long; free the view, then reset"};
    }
    if (reference_.on_second_ship &&
        !(estimate.second_valid && fresh(now.second_mru, now.t, config_.mrus.back().rule.stale_after_s))) {
      return Obstacle{"mru2_stale",
                      "the reference is on the second ship, whose unit is not heard or still settles; check "
                      "mru2 or give a reference in world, then reset"};
    }
    if (wish_missing_)
      return Obstacle{"out_of_reach",
                      "the tool point is out of the arm's reach; move the reference, then reset"};
    return std::nullopt;
  };
  facts.unsafe = unsafe();

  // What keeps it from being engaged: all of that, and more.
  facts.not_ready = facts.unsafe;
  if (facts.not_ready) return facts;
  const auto& sd = estimate.p_world_tool_sd_m;
  const auto& qd = now.arm->qd_radps;
  if (!estimate.load_tracked) {
    facts.not_ready = Obstacle{"load_lost", "the cameras do not see the load; free the view"};
  } else if (config_.belief.use_platform_body && !estimate.platform_tracked) {
    facts.not_ready = Obstacle{"platform_lost",
                               "the cameras do not see the body on the platform; free the view or set "
                               "[control] platform = \"untracked\""};
  } else if (std::any_of(sd.begin(), sd.end(), [](double s) { return s > kToolSdToEngage; })) {
    facts.not_ready = Obstacle{"estimate_settling", "the estimate is still settling; wait a few seconds"};
  } else if (std::any_of(qd.begin(), qd.end(), [](double v) { return std::abs(v) > kRestToEngage; })) {
    facts.not_ready = Obstacle{"arm_moving", "the arm moves; wait until it rests"};
  } else if (!now.winch->ready) {
    facts.not_ready =
        Obstacle{"winch_not_ready", "the winch drive is not ready; switch on its power and clear its faults"};
  }
  return facts;
}

void ControlLoop::coast(const Snapshot& now) {
  const auto& rule = config_.qualisys;
  const double unseen = load_seen_ ? seconds(now.t - *load_seen_) : rule.rest_by_s;
  const double wanted = std::clamp((rule.rest_by_s - unseen) / (rule.rest_by_s - rule.coast_s), 0.0, 1.0);
  // Given back slowly: the load may be found far from where it was lost.
  const double most = horizontal_share_ + config_.control_period_s / kShareBack;
  horizontal_share_ = modes_.state() == ModeState::engaged ? std::min(wanted, most) : 1.0;
}

void ControlLoop::command(const Snapshot& now, const controller::GuardedCommand& guarded) {
  // Observe and settled send nothing that moves; mode 0 and hold are what "nothing" is on these wires.
  const bool engaged = modes_.may_move();
  topic::ArmCommand arm;
  arm.device = config_.comau.driver.device;
  arm.sequence_number = steps_ + 1;
  arm.t_created_ns = to_ns(now.t);
  arm.follow = guarded.follow;
  arm.qd_wanted_radps = guarded.qd_radps;
  publish_arm_.publish(arm);

  topic::WinchCommand winch;
  winch.device = config_.winch.driver.device;
  winch.sequence_number = steps_ + 1;
  winch.t_created_ns = to_ns(now.t);
  const bool moving = engaged || guarded.wire_speed_mps != 0;
  const bool powered = modes_.state() == ModeState::engaged || modes_.state() == ModeState::stopping ||
                       (modes_.state() == ModeState::fault && !guard_.at_rest());
  winch.enable = powered && modes_.authority() >= topic::Authority::limited;
  winch.mode = moving && winch.enable ? topic::WinchCommandMode::velocity
               : winch.enable         ? topic::WinchCommandMode::hold
                                      : topic::WinchCommandMode::off;
  winch.reset = modes_.state() == ModeState::engaged && now.winch && !now.winch->enabled;
  winch.wire_speed_wanted_mps = guarded.wire_speed_mps;
  publish_winch_.publish(winch);
}

void ControlLoop::tell_mode(LabTime t) {
  topic::Mode mode = modes_.topic();
  const bool changed = mode.sequence_number != mode_told_;
  if (!changed && steps_ % static_cast<std::uint64_t>(seconds(kModeRepeat) / config_.control_period_s) != 0)
    return;
  if (!mode.owner.empty()) mode.t_lease_expires_ns = to_ns(t + kLease);
  mode_told_ = mode.sequence_number;
  publish_mode_.publish(mode);
  if (!changed || mode.state == state_told_) return;
  state_told_ = mode.state;
  topic::Event event;
  event.sequence_number = ++events_;
  event.t_ns = to_ns(t);
  event.severity = mode.fault_latched ? topic::Severity::fault : topic::Severity::info;
  event.source = "mode";
  event.code = mode.fault_code.empty() ? Text<32>{to_string(mode.state)} : mode.fault_code;
  event.text = mode.reason;
  publish_event_.publish(event);
}

}  // namespace motionlab::service
