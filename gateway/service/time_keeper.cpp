#include "gateway/service/time_keeper.hpp"

#include <cstdio>

namespace motionlab::service {
namespace {

constexpr double kDeadlinePeriods = 3.0;
constexpr std::uint64_t kStepsToSettle = 1000;

Nanoseconds deadline(double period_s) {
  return from_seconds(kDeadlinePeriods * period_s);
}

}  // namespace

TimeKeeper::TimeKeeper(const GatewayConfig& config)
    : period_us_(1e6 * config.control_period_s),
      mru_{config.mrus.front().driver.device, deadline(config.mrus.front().driver.period_s)},
      arm_{config.comau.driver.device, deadline(config.comau.driver.command_period_s)},
      winch_{config.winch.driver.device, deadline(config.winch.driver.command_period_s)} {}

void TimeKeeper::woke(Nanoseconds late, std::uint64_t missed_beats) noexcept {
  wakeup_.add(1e6 * seconds(late));
  if (missed_beats > 0) missed(MissedDeadline::late_wakeup, missed_beats);
}

void TimeKeeper::page_faults(std::uint64_t count) noexcept {
  if (steps_ < kStepsToSettle) return;
  if (!page_faults_at_start_) page_faults_at_start_ = count;
  page_faults_ = count - *page_faults_at_start_;
}

void TimeKeeper::stepped(const Snapshot& now, double step_us, std::optional<double> age_s) noexcept {
  ++steps_;
  if (t_last_) period_.add(1e6 * seconds(now.t - *t_last_));
  t_last_ = now.t;
  step_.add(step_us);
  if (step_us > period_us_) missed(MissedDeadline::long_step);
  if (age_s) age_.add(1e6 * *age_s);
  look(mru_, now.mru);
  look(arm_, now.arm);
  look(winch_, now.winch);
}

template <class Sample>
void TimeKeeper::look(Source& source, const std::optional<Sample>& sample) noexcept {
  if (!sample || sample->sequence_number == source.sequence) return;
  const bool first = source.sequence == 0;
  const Nanoseconds waited{sample->t_received_ns - source.t_received_ns};
  const Nanoseconds measured_apart{sample->t_measured_ns - source.t_measured_ns};
  source.sequence = sample->sequence_number;
  source.t_received_ns = sample->t_received_ns;
  source.t_measured_ns = sample->t_measured_ns;
  if (first || waited <= source.deadline) return;
  const bool of_device = measured_apart > source.deadline;
  missed(of_device ? MissedDeadline::late_device : MissedDeadline::late_sample);
  char text[201];
  std::snprintf(text, sizeof text, "%.*s came %.1f ms after its last sample, %s",
                static_cast<int>(source.device.view().size()), source.device.view().data(),
                1e3 * seconds(waited), of_device ? "measured late or lost" : "measured in time");
  last_miss_ = text;
}

void TimeKeeper::missed(MissedDeadline cause, std::uint64_t times) noexcept {
  missed_[static_cast<std::size_t>(cause)] += times;
}

topic::Health TimeKeeper::health(LabTime t) const {
  topic::Health health;
  health.device = "gateway";
  health.t_ns = to_ns(t);
  health.link = topic::LinkState::up;
  health.rate_hz = 1e6 / period_us_;
  health.received = steps_;
  health.missed_deadlines = missed_;
  return health;
}

topic::Timing TimeKeeper::timing(LabTime t) const {
  topic::Timing timing;
  timing.t_ns = to_ns(t);
  timing.steps = steps_;
  timing.page_faults = page_faults_;
  timing.last_missed = last_miss_;
  timing.period_count = period_.counts();
  timing.wakeup_count = wakeup_.counts();
  timing.step_time_count = step_.counts();
  timing.age_at_actuation_count = age_.counts();
  timing.period_max_us = period_.max_us();
  timing.wakeup_max_us = wakeup_.max_us();
  timing.step_time_max_us = step_.max_us();
  timing.age_at_actuation_max_us = age_.max_us();
  return timing;
}

}  // namespace motionlab::service
