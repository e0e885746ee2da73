#include "simulators/lab/study/lab_run.hpp"

#include <filesystem>

#include "drivers/core/config_path.hpp"
#include "gateway/monitor/scorer.hpp"
#include "gateway/service/gateway_config.hpp"
#include "simulators/lab/settings.hpp"

namespace motionlab::study {

namespace {

/// The truth is scored this often.
constexpr Nanoseconds kTruthPeriod = 1ms;

}  // namespace

lockstep::Config configure(const LabRun& run) {
  lockstep::Config config;
  // Addresses of the loopback overlay, freshness limits of the laboratory: a virtual clock never stands
  // still.
  const auto lab_toml = run.config.empty() ? find_config("lab.toml") : std::filesystem::path(run.config);
  const auto world_toml =
      run.world_config.empty() ? find_config("world.toml") : std::filesystem::path(run.world_config);
  const auto settings = lab::Settings::parse(run.settings);
  config.gateway = service::load_gateway_config(lab_toml, {find_config("loopback.toml")}, settings.lab);
  config.lab = lab::LabConfig::load(world_toml, {}, settings.world);
  config.lab.set_scenario(run.scenario);
  config.lab.seed = run.seed;
  const bool tracked = run.platform == "tracked";
  config.lab.set_platform_tracked(tracked);
  config.gateway.set_platform_tracked(tracked);
  if (run.differences == "off") config.lab.use_belief_as_world();
  if (run.sensors == "ideal") {
    config.lab.use_perfect_sensors();
    // Without noise a sensor at rest repeats itself.
    for (auto& mru : config.gateway.mrus) mru.driver.stuck_after_s = 0.0;
  }
  for (const auto& text : run.faults) config.faults.push_back(lab::PlannedFault::parse(text));
  config.timing = run.timing;
  return config;
}

LabOutcome run_lab(const LabRun& run) {
  const lockstep::Config config = configure(run);
  lockstep::Lockstep line(config);

  monitor::ScorerConfig scoring;
  scoring.labels.scenario = run.scenario;
  scoring.labels.controller = run.controller;
  scoring.labels.estimator = run.estimator;
  scoring.labels.sensors = run.sensors;
  scoring.labels.seed = run.seed;
  scoring.labels.platform = run.platform;
  scoring.p_world_load_m = config.gateway.p_world_load_reference_m;
  scoring.t_start = LabTime{};
  scoring.score_from_s = run.score_from_s;
  scoring.timing = run.timing;
  monitor::Scorer scorer(scoring);
  for (const auto& fault : config.faults) {
    scorer.note_fault(LabTime{} + from_seconds(fault.from_s), fault.device + ":" + fault.fault);
  }

  auto control = line.bus().reader<topic::Control>();
  auto mode = line.bus().reader<topic::Mode>();
  auto arm = line.bus().reader<topic::ArmState>(config.gateway.comau.driver.device);
  auto winch = line.bus().reader<topic::WinchState>(config.gateway.winch.driver.device);
  const LabTime end = LabTime{} + from_seconds(run.seconds);
  const LabTime engage_at = LabTime{} + from_seconds(run.engage_at_s);
  bool engaged = run.controller == "none";
  LabTime next_truth{};
  LabOutcome outcome;
  while (line.now() < end) {
    if (!engaged && line.now() >= engage_at) {
      line.request(topic::ModeAction::engage);
      engaged = true;
    }
    line.step();
    if (const auto sample = mode.newer()) {
      scorer.take(*sample);
      outcome.last_mode = sample->state;
      if (sample->fault_latched && outcome.fault_code.empty()) outcome.fault_code = sample->fault_code.view();
    }
    if (const auto sample = control.newer()) scorer.take(*sample);
    if (const auto sample = arm.newer()) scorer.take(*sample);
    if (const auto sample = winch.newer()) scorer.take(*sample);
    if (line.now() >= next_truth) {
      scorer.take(line.lab().truth());
      next_truth += kTruthPeriod;
    }
  }
  line.bus().for_each_newest<topic::Health>([&scorer](const topic::Health& health) { scorer.take(health); });
  scorer.run_until(end);
  outcome.report = scorer.report();
  return outcome;
}

}  // namespace motionlab::study
