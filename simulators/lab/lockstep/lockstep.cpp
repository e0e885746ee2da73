#include "simulators/lab/lockstep/lockstep.hpp"

#include <chrono>

#include "drivers/core/error.hpp"

namespace motionlab::lockstep {
namespace {

std::int64_t monotonic_ns() {
  return std::chrono::steady_clock::now().time_since_epoch().count();
}

}  // namespace

Lockstep::Lockstep(const Config& config)
    : network_(clock_),
      tape_(config.gateway.record.inputs.empty()
                ? nullptr
                : std::make_unique<record::RunTape>(config.gateway.record.outputs_every)),
      lab_(config.lab, network_, LabTime{}),
      devices_(config.gateway, network_, bus_, schedule_),
      control_(config.gateway, bus_, schedule_,
               config.timing ? std::function<std::int64_t()>(monotonic_ns) : std::function<std::int64_t()>(),
               std::function<std::int64_t()>(), tape_.get()),
      requests_(bus_.advertise<topic::ModeRequest>()),
      period_(from_seconds(config.gateway.control_period_s)) {
  const auto& rule = config.gateway.record;
  if (tape_) recorder_.emplace(rule.inputs, *tape_, config.gateway.effective, rule.zstd_level);
  std::vector<lab::PlannedFault> plans = config.lab.faults;
  plans.insert(plans.end(), config.faults.begin(), config.faults.end());
  for (const auto& plan : plans) {
    // A name that does not exist is found now, not in the middle of a run.
    if (const Status known = lab_.set_fault(plan.device, plan.fault, false); !known) {
      throw StartupError("fault " + plan.device + ":" + plan.fault + ": " + std::string(known.fault().text));
    }
    faults_.push_back({plan, false});
  }
}

void Lockstep::request(topic::ModeAction action) {
  topic::ModeRequest request;
  request.requester = "lockstep";
  request.sequence_number = ++requested_;
  request.t_created_ns = to_ns(now());
  request.action = action;
  requests_.publish(request);
}

void Lockstep::apply_faults(LabTime t) {
  const double t_s = seconds(t.time_since_epoch());
  for (auto& fault : faults_) {
    const bool active = t_s >= fault.plan.from_s && (!fault.plan.until_s || t_s < *fault.plan.until_s);
    if (active == fault.active) continue;
    fault.active = active;
    (void)lab_.set_fault(fault.plan.device, fault.plan.fault, active, fault.plan.value);
  }
}

void Lockstep::step() {
  const LabTime end = now() + period_;
  apply_faults(end);
  while (now() < end) {
    // Everything that happens, happens in order of time: the world's events, deliveries, and the drivers'
    // timers.
    LabTime next = std::min(end, std::max(lab_.next_event(), now() + 1ns));
    if (const auto due = network_.next_due()) next = std::min(next, std::max(*due, now()));
    if (devices_.next_send() > now()) next = std::min(next, devices_.next_send());
    network_.run_until(next);
    lab_.step(next);
    if (next >= devices_.next_send() && next < end) devices_.step(next);
    network_.deliver_due(next);
  }
  devices_.step(end);
  network_.deliver_due(end);
  control_.step(end);
  if (recorder_) (void)recorder_->drain();
}

void Lockstep::finish_recording() {
  if (!recorder_) return;
  recorder_->finish();
  if (const auto trouble = recorder_->trouble()) throw StartupError(*trouble);
}

}  // namespace motionlab::lockstep
