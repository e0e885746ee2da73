#include "drivers/comau/comau_driver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace motionlab::comau {
namespace {

bool all_finite(const Joints& values) noexcept {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

bool follows(const Command& command) noexcept {
  return command.mode == static_cast<std::int32_t>(Mode::follow);
}

/// Limits in which an arm can be and move; zeros, for example, are none.
bool is_a_box(const ReportedLimits& limits) noexcept {
  for (std::size_t i = 0; i < kJointCount; ++i) {
    if (limits.q_min_rad[i] >= limits.q_max_rad[i] || limits.qd_max_radps[i] <= 0.0) return false;
  }
  return true;
}

}  // namespace

VelocityShaper::Config shaper_config(const DriverConfig& config) {
  return {.period_s = config.command_period_s,
          .rest_before_motion_s = config.rest_before_motion_s,
          .rest_before_hold_s = config.rest_before_hold_s,
          .q_min_rad = config.q_min_rad,
          .q_max_rad = config.q_max_rad,
          .qd_max_radps = config.qd_max_radps,
          .qdd_max_radps2 = config.qdd_max_radps2,
          .stop_deceleration_radps2 = config.stop_deceleration_radps2};
}

ComauDriver::ComauDriver(DriverConfig config, DatagramOut& out, Sink<topic::ArmState> on_state,
                         Sink<topic::ArmCommand> on_sent)
    : config_(std::move(config)),
      out_(out),
      on_state_(std::move(on_state)),
      on_sent_(std::move(on_sent)),
      shaper_(shaper_config(config_)),
      clock_({.latency = from_seconds(config_.latency_s), .drift_ppm_max = config_.drift_ppm_max}),
      frames_(std::llround(config_.restart_gap_s / kCycleSeconds)),
      response_({.ignored_after_s = config_.ignored_after_s}) {
  state_.device = config_.device;
  health_.phase(LinkPhase::connecting);
}

void ComauDriver::set_command(const topic::ArmCommand& command) {
  if (command.follow && wanted_ && command.t_created_ns < wanted_->t_created_ns) {
    health_.rejected({Reason::out_of_order, "an arm command is older than the one before it: not taken"});
    return;
  }
  if (command.follow && !all_finite(command.qd_wanted_radps)) {
    health_.rejected({Reason::bad_value, "a wanted joint velocity is not finite: the arm is braked"});
  }
  if (!command.follow) ignored_ = false;
  wanted_ = command;
}

void ComauDriver::step(LabTime now) {
  if (!t_started_) {
    t_started_ = now;
    next_send_ = now;
  }
  // A command from the future would stay fresh for too long.
  if (wanted_) wanted_->t_created_ns = std::min(wanted_->t_created_ns, to_ns(now));
  if (silent(now)) health_.phase(health_.received() > 0 ? LinkPhase::down : LinkPhase::connecting);
  if (!stopped_ && now >= next_send_) {
    send_slot(now);
    keep_schedule(now);
  }
  health_.advice(advice(now));
}

void ComauDriver::send_slot(LabTime now) {
  const Brake brake = why_brake(now);
  if (brake == Brake::stale && brake_ != Brake::stale) ++stale_commands_;
  brake_ = brake;
  const VelocityShaper before = shaper_;
  const Command command =
      brake == Brake::none ? shaper_.follow(wanted_->qd_wanted_radps, state_.q_rad) : shaper_.brake();
  // The next command is a step from what the robot computer was told, not from what should have left. Only an
  // orderly stop has to come to an end without a network.
  if (!send(command, now) && !stopping_) shaper_ = before;
  if (stopping_ && shaper_.holding()) stopped_ = ++farewells_ >= config_.farewell_datagrams;
}

ComauDriver::Brake ComauDriver::why_brake(LabTime now) const noexcept {
  if (stopping_ || !wanted_ || !wanted_->follow) return Brake::hold;
  if (!all_finite(wanted_->qd_wanted_radps)) return Brake::not_finite;
  if (now - from_ns(wanted_->t_created_ns) > from_seconds(config_.command_stale_after_s)) return Brake::stale;
  if (unchanged_answers_ >= config_.frozen_after_answers) return Brake::frozen;
  if (blind(now)) return Brake::blind;
  if (ignored_) return Brake::ignored;
  return Brake::none;
}

bool ComauDriver::send(const Command& command, LabTime now) {
  if (const Status status = out_.send(config_.robot_computer, encode(command)); !status) {
    health_.rejected(status.fault());
    return false;
  }
  last_sent_ = command;
  t_last_sent_ = now;
  ++sent_;
  if (!on_sent_) return true;
  topic::ArmCommand said;
  said.device = config_.device;
  said.sequence_number = sent_;
  said.t_created_ns = to_ns(now);
  said.follow = follows(command);
  std::ranges::copy(command.qd_radps, said.qd_wanted_radps.begin());
  on_sent_(said);
  return true;
}

void ComauDriver::keep_schedule(LabTime now) noexcept {
  if (stopped_) {
    next_send_ = LabTime::max();
    return;
  }
  // In the robot's time: so many of its cycles as meant, and the phase to them does not wander.
  const Nanoseconds period = from_seconds(config_.command_period_s * (1.0 + 1e-6 * clock_.drift_ppm()));
  next_send_ += period;
  if (next_send_ > now) return;
  const auto missed = (now - next_send_) / period + 1;
  missed_slots_ += static_cast<std::uint64_t>(missed);
  next_send_ += missed * period;
}

void ComauDriver::on_datagram(Bytes datagram, Endpoint from, LabTime t_received) {
  const Endpoint& expected = config_.robot_computer;
  if (from.address != expected.address || (expected.port != 0 && from.port != expected.port)) {
    health_.rejected(
        {Reason::foreign, "a datagram from somebody who is not the robot computer: who sends it?"});
    return;
  }
  const Result<Answer> answer = decode_answer(datagram);
  if (!answer) return refuse(answer.fault(), t_received);
  const Result<WrappingCounter::Step> step = judge_counter(answer->frame_counter, t_received);
  if (!step) return refuse(step.fault(), t_received);
  const Nanoseconds passed = passed_since_last(*answer, *step, t_received);
  if (const Status possible = posture_.check(*answer, passed); !possible) {
    response_.reset();  // across such a jump nothing can be said of motion
    return refuse(possible.fault(), t_received);
  }
  posture_.accept(*answer);
  const LabTime t_measured = place_in_time(*answer, *step, t_received);
  health_.accepted(t_measured, t_received);
  health_.phase(LinkPhase::up);
  watch_response(*answer, passed);
  note_limits(*answer);
  ++state_.sequence_number;
  state_.t_measured_ns = to_ns(t_measured);
  state_.t_received_ns = to_ns(t_received);
  state_.frame_counter = answer->frame_counter;
  state_.following = last_sent_ && follows(*last_sent_);
  state_.ignoring = ignored_;
  state_.q_rad = answer->q_rad;
  state_.qd_radps = answer->qd_radps;
  if (on_state_) on_state_(state_);
}

void ComauDriver::refuse(Fault fault, LabTime t_received) noexcept {
  health_.rejected(fault);
  t_refused_ = t_received;
}

Result<WrappingCounter::Step> ComauDriver::judge_counter(std::uint32_t frame_counter,
                                                         LabTime t_received) noexcept {
  using Step = WrappingCounter::Step;
  Step step = frames_.classify(frame_counter);
  if (step == Step::first) return step;
  if (step == Step::repeated) {
    ++unchanged_answers_;
    return Fault{Reason::duplicate,
                 "the frame counter has not moved: repeated, or the robot's cycle stands still"};
  }
  if (step == Step::backward) {
    return Fault{Reason::out_of_order, "the frame counter is older than the last accepted one"};
  }
  if (step == Step::forward) {
    // The robot's time cannot run ahead of ours: a restart can also look like a step forward.
    const double ahead_s =
        kCycleSeconds * static_cast<double>(frames_.unwrapped(frame_counter) - frames_.total()) -
        seconds(t_received - *health_.t_received());
    if (ahead_s <= config_.ahead_unasked_s) return step;
    if (ahead_s > config_.restart_gap_s) step = Step::restarted;
  }
  // One answer with another counter may be anything; two that follow from each other are a program.
  const auto frames = jump_ ? static_cast<std::int32_t>(frame_counter - jump_->frame_counter) : 0;
  const bool goes_on =
      frames > 0 && frames * kCycleSeconds <= seconds(t_received - jump_->t_received) + config_.restart_gap_s;
  if (goes_on) return step;
  jump_ = Jump{frame_counter, t_received};
  return Fault{Reason::unexpected,
               "the frame counter has jumped: believed if the next answer goes on from there"};
}

Nanoseconds ComauDriver::passed_since_last(const Answer& answer, WrappingCounter::Step step,
                                           LabTime t_received) const noexcept {
  const Nanoseconds by_our_clock = health_.t_received() ? t_received - *health_.t_received() : 0ns;
  if (step != WrappingCounter::Step::forward) return by_our_clock;
  const std::int64_t frames = frames_.unwrapped(answer.frame_counter) - frames_.total();
  return std::max(by_our_clock, frames * from_seconds(kCycleSeconds));
}

LabTime ComauDriver::place_in_time(const Answer& answer, WrappingCounter::Step step,
                                   LabTime t_received) noexcept {
  using Step = WrappingCounter::Step;
  if (step == Step::restarted) {
    frames_.reset();
    clock_.reset();
    response_.reset();
    health_.reconnected();
  }
  jump_.reset();
  const std::int64_t advance = frames_.advance(answer.frame_counter);
  if (step == Step::forward) {
    // Lost is what we asked for and did not get; slots in which nothing was sent are no loss.
    const auto periods =
        std::llround(static_cast<double>(advance) * kCycleSeconds / config_.command_period_s);
    const auto asked = static_cast<long long>(sent_ - sent_at_last_frame_);
    health_.lost(static_cast<std::uint64_t>(std::max(0LL, std::min(periods, asked) - 1)));
  }
  // A cycle that stood still has lost that time.
  if (unchanged_answers_ >= config_.frozen_after_answers) clock_.reset();
  unchanged_answers_ = 0;
  sent_at_last_frame_ = sent_;
  // 0.4 ms, in whole nanoseconds.
  return clock_.map(frames_.total() * from_seconds(kCycleSeconds), t_received);
}

void ComauDriver::watch_response(const Answer& answer, Nanoseconds passed) noexcept {
  if (!last_sent_ || !follows(*last_sent_)) {
    response_.reset();
    return;
  }
  // Over a gap nobody knows what the robot computer got, nor whether it braked meanwhile.
  if (seconds(passed) > config_.answer_gap_s) {
    response_.reset();
    return;
  }
  response_.step(last_sent_->qd_radps, answer.q_rad, seconds(passed));
  ignored_ = ignored_ || response_.ignored();
}

void ComauDriver::note_limits(const Answer& answer) noexcept {
  state_.limits_known = answer.limits && is_a_box(*answer.limits);
  if (answer.limits) {
    state_.q_min_rad = answer.limits->q_min_rad;
    state_.q_max_rad = answer.limits->q_max_rad;
    state_.qd_max_radps = answer.limits->qd_max_radps;
  }
  constexpr double kRoundingOfTheWire = 1e-4;
  limits_narrower_ = false;
  for (std::size_t i = 0; state_.limits_known && i < kJointCount; ++i) {
    limits_narrower_ = limits_narrower_ || state_.q_min_rad[i] > config_.q_min_rad[i] + kRoundingOfTheWire ||
                       state_.q_max_rad[i] < config_.q_max_rad[i] - kRoundingOfTheWire ||
                       state_.qd_max_radps[i] < config_.qd_max_radps[i] - kRoundingOfTheWire;
  }
}

bool ComauDriver::silent(LabTime now) const noexcept {
  const auto t_last = health_.t_received() ? health_.t_received() : t_started_;
  return t_last && now - *t_last > from_seconds(config_.silent_after_s);
}

bool ComauDriver::blind(LabTime now) const noexcept {
  return !health_.t_measured() || now - *health_.t_measured() > from_seconds(config_.answer_stale_after_s);
}

bool ComauDriver::feedback_fresh(LabTime now) const noexcept {
  return unchanged_answers_ < config_.frozen_after_answers && !blind(now);
}

std::string_view ComauDriver::advice(LabTime now) const noexcept {
  if (unchanged_answers_ >= config_.frozen_after_answers) {
    return "The robot's control cycle stands still: look for a Power Link Error and restart the robot "
           "program.";
  }
  if (silent(now) && t_refused_ && now - *t_refused_ <= from_seconds(config_.silent_after_s)) {
    return "Answers come from the robot computer and all are refused: which program runs there? The reasons "
           "are counted.";
  }
  if (silent(now)) {
    return health_.received() > 0
               ? "The robot computer has fallen silent: if the arm moves, stop it by hand; check program and "
                 "network."
               : "The robot computer does not answer: check its address, and that its program runs.";
  }
  if (ignored_) {
    return "The arm was told to move and did not; it is held until settled. Remote mode selected, drives on, "
           "program started, joints inside their box?";
  }
  if (brake_ == Brake::blind) {
    return "No answer of the robot computer is fresh enough to move on: the arm is held; check network and "
           "load of both ends.";
  }
  if (brake_ == Brake::not_finite) {
    return "The controller asked for a velocity that is no number: the arm is held; settle and look into the "
           "controller.";
  }
  if (brake_ == Brake::stale) {
    return "The controller's commands are too old: the arm is held; check that the controller runs in time.";
  }
  if (response_.share() < config_.slow_below_share) {
    return "The arm moves more slowly than it is told: set the override on the pendant to 100 %; are the "
           "robot computer's speed limits below ours?";
  }
  if (limits_narrower_) {
    return "The robot computer reports limits narrower than ours and clips what we send: bring [comau] in "
           "line with its settings file.";
  }
  return {};
}

}  // namespace motionlab::comau
