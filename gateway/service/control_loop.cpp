#include "gateway/service/control_loop.hpp"

#include <algorithm>
#include <cmath>

#include "gateway/estimator/ship_from_mru.hpp"

namespace motionlab::service {
namespace {

using topic::ModeState;

/// How long before a state that nobody changed is told again, so that its lease is seen to live.
constexpr Nanoseconds kModeRepeat = 1s;
/// How often the control thread tells of itself.
constexpr Nanoseconds kHealthRepeat = 100ms, kTimingRepeat = 1s;

}  // namespace

ControlLoop::ControlLoop(const GatewayConfig& config, bus::LocalBus& local, ArmSchedule& schedule,
                         std::function<std::int64_t()> stopwatch,
                         std::function<std::int64_t()> processor_time, record::RunTape* tape)
    : config_(config),
      inputs_(config, local, schedule),
      stopwatch_(std::move(stopwatch)),
      processor_time_(std::move(processor_time)),
      tape_(tape),
      own_(config),
      guard_(config.limits),
      mount_(config.belief.calibration.mount()),
      readiness_(config),
      modes_(config.authority),
      publish_estimate_(local, tape),
      publish_control_(local, tape),
      publish_arm_(local, tape),
      publish_winch_(local, tape),
      publish_mode_(local, tape),
      publish_event_(local, tape),
      publish_health_(local.advertise<topic::Health>()),
      publish_timing_(local.advertise<topic::Timing>()),
      time_keeper_(config) {
  // Nobody else may ever speak for the gateway: the first to publish an instance owns it.
  topic::ArmCommand arm;
  arm.device = config.comau.driver.device;
  arm.requester = kGatewayRequester;
  publish_arm_.claim(arm);
  topic::WinchCommand winch;
  winch.device = config.winch.driver.device;
  winch.requester = kGatewayRequester;
  publish_winch_.claim(winch);
}

Text<32> ControlLoop::external_controller(const topic::Snapshot& inputs) const {
  if (modes_.lease()) return modes_.lease()->external() ? modes_.lease()->owner() : Text<32>{};
  for (const auto& request : inputs.requests) {
    if (request.action == topic::ModeAction::engage && request.external_controller) return request.requester;
  }
  return {};
}

void ControlLoop::step(LabTime t) {
  topic::Snapshot& inputs = inputs_.gather(t);
  inputs_.gather_commands_of(external_controller(inputs));
  if (tape_) inputs.outputs_crc = tape_->outputs_crc();
  step(inputs);
}

void ControlLoop::step(const topic::Snapshot& inputs) {
  const std::int64_t computed = processor_time_ ? processor_time_() : 0;
  const std::int64_t begun = stopwatch_ ? stopwatch_() : 0;
  if (tape_) tape_->begin(inputs);
  ++steps_;
  const LabTime t = from_ns(inputs.t_ns);
  const double dt = stepped_ ? seconds(t - *stepped_) : config_.control_period_s;
  stepped_ = t;
  // By now the drivers brake arm and winch by themselves: nothing of the last command is in force, and what
  // rests is not taken up again to be braked once more.
  if (dt > std::max(config_.comau.driver.command_stale_after_s, config_.winch.driver.command_stale_after_s)) {
    guard_.forget_command();
  }
  for (const auto& request : inputs.requests) modes_.request(request, t);
  own_.take(inputs);
  const Snapshot& now = newest_.take(inputs);
  const topic::Estimate estimate = own_.estimate(now);

  controller::ModeFacts facts = readiness_.judge({now, estimate, dt, own_.on_second_ship(), wish_missing_,
                                                  modes_.applicant() && modes_.applicant()->external});
  facts.at_rest = guard_.at_rest();
  if (now.external_arm) commanded_ = std::min(t, from_ns(now.external_arm->t_created_ns));
  facts.commanded = commanded_;
  modes_.step(facts);

  const auto wish = this->wish(now, estimate);
  const auto guarded = guard(now, wish, dt);
  command(now, guarded);

  topic::Control control = account(now, wish, guarded);
  if (stopwatch_) control.step_time_us = 1e-3 * static_cast<double>(stopwatch_() - begun);
  if (processor_time_) control.step_cpu_us = 1e-3 * static_cast<double>(processor_time_() - computed);
  publish_estimate_.publish(estimate);
  publish_control_.publish(control);
  tell_mode(t);
  if (tape_) tape_->end();
  if (!stopwatch_) return;
  time_keeper_.stepped(now, control.step_time_us,
                       control.following ? std::optional(control.age_mru_s) : std::nullopt);
  tell_time(t);
}

std::optional<controller::Wish> ControlLoop::wish(const Snapshot& now, const topic::Estimate& estimate) {
  const bool engaged = modes_.state() == ModeState::engaged;
  const bool external = modes_.lease() && modes_.lease()->external();
  const auto ours = own_.wish(now, estimate, readiness_.load_seen(), engaged && !external);
  wish_missing_ = engaged && !external && !ours;
  if (!external) {
    if (ours) commanded_ = now.t;
    return ours;
  }
  if (!now.external_arm) return std::nullopt;
  controller::Wish theirs;
  if (now.external_arm->follow) theirs.qd_radps = now.external_arm->qd_wanted_radps;
  if (now.external_winch && now.t - from_ns(now.external_winch->t_created_ns) <= controller::kLeaseDuration)
    theirs.wire_speed_mps = now.external_winch->wire_speed_wanted_mps;
  return theirs;
}

controller::GuardedCommand ControlLoop::guard(const Snapshot& now,
                                              const std::optional<controller::Wish>& wish, double dt_s) {
  controller::Guard::Inputs in;
  in.t = now.t;
  in.dt_s = dt_s;
  in.may_move = modes_.may_move();
  in.lease = modes_.lease() ? &*modes_.lease() : nullptr;
  in.authority = modes_.share_of_limits();
  in.wish = wish;
  if (now.arm) in.q_rad = now.arm->q_rad;
  in.q_age_s = age_s(now.arm, now.t);
  if (now.winch) {
    in.wire_length_m = now.winch->wire_length_m;
    if (std::isfinite(now.winch->motor_torque_nm)) in.motor_torque_nm = now.winch->motor_torque_nm;
  }
  in.wire_age_s = age_s(now.winch, now.t);
  if (now.mru) in.X_WR = estimator::ship_from_mru(mount_, *now.mru) * config_.keeper.X_BR;
  return guard_.step(in);
}

void ControlLoop::command(const Snapshot& now, const controller::GuardedCommand& guarded) {
  // Observe and settled send nothing that moves; mode 0 and hold are what "nothing" is on these wires.
  const bool engaged = modes_.may_move();
  topic::ArmCommand arm;
  arm.device = config_.comau.driver.device;
  arm.requester = kGatewayRequester;
  arm.sequence_number = steps_;
  arm.t_created_ns = to_ns(now.t);
  arm.follow = guarded.follow;
  arm.qd_wanted_radps = guarded.qd_radps;
  publish_arm_.publish(arm);

  topic::WinchCommand winch;
  winch.device = config_.winch.driver.device;
  winch.requester = kGatewayRequester;
  winch.sequence_number = steps_;
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

topic::Control ControlLoop::account(const Snapshot& now, const std::optional<controller::Wish>& wish,
                                    const controller::GuardedCommand& guarded) const {
  topic::Control control;
  control.sequence_number = steps_;
  control.t_snapshot_ns = to_ns(now.t);
  control.following = guarded.follow;
  if (wish) {
    control.qd_wish_radps = wish->qd_radps;
    control.wire_speed_wish_mps = wish->wire_speed_mps;
  }
  control.qd_command_radps = guarded.qd_radps;
  control.wire_speed_command_mps = guarded.wire_speed_mps;
  control.guard_changed = guarded.changed;
  control.guard_changed_count = guard_.changed_count();
  control.age_mru_s = age_s(now.mru, now.t);
  control.age_bodies_s = age_s(now.load, now.t);
  control.age_arm_s = age_s(now.arm, now.t);
  control.age_winch_s = age_s(now.winch, now.t);
  Eigen::Map<Eigen::Vector3d>(control.servo_omega_radps.data()) = own_.servo_omega_radps();
  return control;
}

void ControlLoop::tell_time(LabTime t) {
  const auto every = [this](Nanoseconds time) {
    return steps_ % static_cast<std::uint64_t>(seconds(time) / config_.control_period_s) == 0;
  };
  if (every(kHealthRepeat)) {
    topic::Health health = time_keeper_.health(t);
    health.sequence_number = ++healths_;
    publish_health_.publish(health);
  }
  if (every(kTimingRepeat)) {
    topic::Timing timing = time_keeper_.timing(t);
    timing.sequence_number = ++timings_;
    publish_timing_.publish(timing);
  }
}

void ControlLoop::tell_mode(LabTime t) {
  const topic::Mode& mode = modes_.topic();
  const bool changed = mode.sequence_number != mode_told_;
  if (!changed && steps_ % static_cast<std::uint64_t>(seconds(kModeRepeat) / config_.control_period_s) != 0)
    return;
  mode_told_ = mode.sequence_number;
  publish_mode_.publish(mode);
  if (!changed) return;
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
