#include "drivers/comau/comau_driver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace motionlab::comau {
namespace {

DeviceClock::Config clock_config(const DriverConfig& config) {
  DeviceClock::Config clock;
  clock.latency = from_seconds(config.latency_s);
  clock.drift_ppm_max = config.drift_ppm_max;
  return clock;
}

VelocityShaper::Config shaper_config(const DriverConfig& config) {
  return {.period_s = config.command_period_s,
          .rest_before_hold_s = config.rest_before_hold_s,
          .stop_deceleration_radps2 = config.stop_deceleration_radps2,
          .qd_max_radps = config.qd_max_radps};
}

bool all_finite(const Joints& values) noexcept {
  return std::ranges::all_of(values, [](double value) { return std::isfinite(value); });
}

bool follows(const Command& command) noexcept {
  return command.mode == static_cast<std::int32_t>(Mode::follow);
}

}  // namespace

ComauDriver::ComauDriver(DriverConfig config, DatagramOut& out, Sink<topic::ArmState> on_state,
                         Sink<topic::ArmCommand> on_sent)
    : config_(std::move(config)),
      out_(out),
      on_state_(std::move(on_state)),
      on_sent_(std::move(on_sent)),
      shaper_(shaper_config(config_)),
      clock_(clock_config(config_)),
      frames_(std::llround(config_.restart_gap_s / kCycleSeconds)) {
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
  const Command command =
      brake == Brake::none ? shaper_.follow(wanted_->qd_wanted_radps) : shaper_.brake(brake != Brake::hold);
  send(command, now);
  if (stopping_ && shaper_.holding()) stopped_ = ++farewells_ >= config_.farewell_datagrams;
}

ComauDriver::Brake ComauDriver::why_brake(LabTime now) const noexcept {
  if (stopping_ || !wanted_ || !wanted_->follow) return Brake::hold;
  if (!all_finite(wanted_->qd_wanted_radps)) return Brake::not_finite;
  if (now - from_ns(wanted_->t_created_ns) > from_seconds(config_.command_stale_after_s)) return Brake::stale;
  if (unchanged_answers_ >= config_.frozen_after_answers) return Brake::frozen;
  if (silent(now)) return Brake::silent;
  return Brake::none;
}

void ComauDriver::send(const Command& command, LabTime now) {
  if (const Status status = out_.send(config_.robot_computer, encode(command)); !status) {
    health_.rejected(status.fault());
    return;
  }
  last_sent_ = command;
  t_last_sent_ = now;
  ++sent_;
  if (!on_sent_) return;
  topic::ArmCommand said;
  said.device = config_.device;
  said.sequence_number = sent_;
  said.t_created_ns = to_ns(now);
  said.follow = follows(command);
  std::ranges::copy(command.qd_radps, said.qd_wanted_radps.begin());
  on_sent_(said);
}

void ComauDriver::keep_schedule(LabTime now) noexcept {
  if (stopped_) {
    next_send_ = LabTime::max();
    return;
  }
  const Nanoseconds period = from_seconds(config_.command_period_s);
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
  if (!answer) {
    health_.rejected(answer.fault());
    return;
  }
  const Result<LabTime> t_measured = place_in_time(*answer, t_received);
  if (!t_measured) {
    health_.rejected(t_measured.fault());
    return;
  }
  health_.accepted(*t_measured, t_received);
  health_.phase(LinkPhase::up);
  watch_motion(*answer, t_received);
  ++state_.sequence_number;
  state_.t_measured_ns = to_ns(*t_measured);
  state_.t_received_ns = to_ns(t_received);
  state_.frame_counter = answer->frame_counter;
  state_.following = last_sent_ && follows(*last_sent_);
  state_.q_rad = answer->q_rad;
  state_.qd_radps = answer->qd_radps;
  if (on_state_) on_state_(state_);
}

Result<LabTime> ComauDriver::place_in_time(const Answer& answer, LabTime t_received) noexcept {
  using Step = WrappingCounter::Step;
  Step step = frames_.classify(answer.frame_counter);
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
        kCycleSeconds * static_cast<double>(frames_.unwrapped(answer.frame_counter) - frames_.total()) -
        seconds(t_received - *health_.t_received());
    if (ahead_s > config_.restart_gap_s) step = Step::restarted;
  }
  if (step == Step::restarted) {
    frames_.reset();
    clock_.reset();
    health_.reconnected();
  }
  const std::int64_t advance = frames_.advance(answer.frame_counter);
  if (step == Step::forward) {
    // Lost is what we asked for and did not get; slots in which nothing was sent are no loss.
    const auto periods =
        std::llround(static_cast<double>(advance) * kCycleSeconds / config_.command_period_s);
    const auto asked = static_cast<long long>(sent_ - sent_at_last_frame_);
    health_.lost(static_cast<std::uint64_t>(std::max(0LL, std::min(periods, asked) - 1)));
  }
  unchanged_answers_ = 0;
  sent_at_last_frame_ = sent_;
  // 0.4 ms, in whole nanoseconds.
  return clock_.map(frames_.total() * from_seconds(kCycleSeconds), t_received);
}

void ComauDriver::watch_motion(const Answer& answer, LabTime t_received) noexcept {
  constexpr double kSlowestWorthWatching_radps = 0.02;
  constexpr double kShareThatIsMotion = 0.1;
  bool wanted = false;
  bool moves = false;
  for (std::size_t i = 0; last_sent_ && i < kJointCount; ++i) {
    const double sent = std::abs(static_cast<double>(last_sent_->qd_radps[i]));
    if (sent < kSlowestWorthWatching_radps) continue;
    wanted = true;
    moves = moves || std::abs(answer.qd_radps[i]) > kShareThatIsMotion * sent;
  }
  if (!wanted || moves) {
    t_ignored_since_.reset();
  } else if (!t_ignored_since_) {
    t_ignored_since_ = t_received;
  }
}

bool ComauDriver::silent(LabTime now) const noexcept {
  const auto t_last = health_.t_received() ? health_.t_received() : t_started_;
  return t_last && now - *t_last > from_seconds(config_.silent_after_s);
}

bool ComauDriver::feedback_fresh(LabTime now) const noexcept {
  return health_.received() > 0 && unchanged_answers_ < config_.frozen_after_answers && !silent(now);
}

std::string_view ComauDriver::advice(LabTime now) const noexcept {
  if (unchanged_answers_ >= config_.frozen_after_answers) {
    return "The robot's control cycle stands still: look for a Power Link Error and restart the robot "
           "program.";
  }
  if (silent(now)) {
    return health_.received() > 0
               ? "The robot computer has fallen silent: if the arm moves, stop it by hand; check program and "
                 "network."
               : "The robot computer does not answer: check its address, and that its program runs.";
  }
  if (brake_ == Brake::not_finite) {
    return "The controller asked for a velocity that is no number: the arm is held; settle and look into the "
           "controller.";
  }
  if (brake_ == Brake::stale) {
    return "The controller's commands are too old: the arm is held; check that the controller runs in time.";
  }
  if (t_ignored_since_ && now - *t_ignored_since_ > from_seconds(config_.ignored_after_s)) {
    return "The arm is told to move and does not: remote mode selected, drives on, joints inside their box?";
  }
  return {};
}

}  // namespace motionlab::comau
