#include "gateway/deadman/brake_sequence.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::deadman {
namespace {

using comau::Command;
using comau::kJointCount;
using comau::Mode;

/// An answer older than this says nothing about now.
constexpr Nanoseconds kAnswerFresh = 200ms;

Command follow_with_zero() noexcept {
  Command command;
  command.mode = static_cast<std::int32_t>(Mode::follow);
  return command;
}

/// What the robot computer has made of a command that is so old, if it brakes by itself.
Command braked_meanwhile(const Said& said, const BrakeSequence::Config& config) noexcept {
  Command now = said.command;
  if (!config.robot_brakes_after_s) return now;
  const double braking_s = std::max(0.0, seconds(said.age) - *config.robot_brakes_after_s);
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double lost = config.shaper.stop_deceleration_radps2[i] * braking_s;
    const double qd = static_cast<double>(now.qd_radps[i]);
    now.qd_radps[i] = static_cast<float>(qd - std::clamp(qd, -lost, lost));
  }
  return now;
}

}  // namespace

BrakeSequence::BrakeSequence(const Config& config, LabTime now, const std::optional<Said>& last) noexcept
    : config_(config), shaper_(config.shaper), asking_(!last), next_(now), give_up_(now + config.patience) {
  if (last) begin(braked_meanwhile(*last, config_), now);
}

void BrakeSequence::begin(const Command& from, LabTime now) noexcept {
  shaper_ = comau::VelocityShaper(config_.shaper, from);
  double ramp_s = config_.shaper.rest_before_hold_s;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    ramp_s = std::max(
        ramp_s, std::abs(static_cast<double>(from.qd_radps[i])) / config_.shaper.stop_deceleration_radps2[i] +
                    config_.shaper.rest_before_hold_s);
  }
  give_up_ = now + from_seconds(ramp_s) + config_.patience;
}

std::optional<Command> BrakeSequence::due(LabTime now) noexcept {
  if (now < next_) return std::nullopt;
  keep_schedule(now);
  if (asking_) return follow_with_zero();
  if (first_) return *std::exchange(first_, std::nullopt);
  const Command command = shaper_.brake();
  if (shaper_.holding()) ++holds_;
  return command;
}

void BrakeSequence::keep_schedule(LabTime now) noexcept {
  const Nanoseconds period = from_seconds(config_.shaper.period_s);
  next_ += period * ((now - next_) / period + 1);
}

void BrakeSequence::heard(const comau::Answer& answer, LabTime t) noexcept {
  t_heard_ = t;
  if (asking_) {
    asking_ = false;
    Command measured = follow_with_zero();
    for (std::size_t i = 0; i < kJointCount && !slow(answer.qd_radps); ++i) {
      const double fastest = config_.shaper.qd_max_radps[i];
      measured.qd_radps[i] = static_cast<float>(std::clamp(answer.qd_radps[i], -fastest, fastest));
    }
    begin(measured, t);
    first_ = measured;
    next_ = t;
  }
  if (holds_ > 0 && slow(answer.qd_radps)) {
    t_resting_ = t;
  } else {
    t_resting_.reset();
  }
}

bool BrakeSequence::slow(const comau::Joints& qd_radps) const noexcept {
  return std::ranges::all_of(qd_radps, [this](double qd) { return std::abs(qd) < config_.at_rest_radps; });
}

BrakeSequence::End BrakeSequence::end(LabTime now) const noexcept {
  const bool resting = t_resting_ && now - *t_resting_ <= kAnswerFresh;
  if (holds_ >= config_.holds && resting) return End::at_rest;
  if (now < give_up_) return End::not_yet;
  return t_heard_ && now - *t_heard_ <= kAnswerFresh ? End::moving : End::silent;
}

}  // namespace motionlab::deadman
