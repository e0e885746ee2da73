#include "simulators/lab/study/lab_run.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "drivers/core/config_path.hpp"
#include "gateway/monitor/scorer.hpp"
#include "gateway/service/gateway_config.hpp"
#include "simulators/lab/settings.hpp"
#include "simulators/lab/study/reference_plan.hpp"
#include "simulators/lab/study/two_at_a_time.hpp"

namespace motionlab::study {

namespace {

/// The truth is scored this often.
constexpr Nanoseconds kTruthPeriod = 1ms;
/// In which it is seen whether the load hangs still again.
constexpr Nanoseconds kLastWindow = 15s;

/// How far from engaged.
int severity(topic::ModeState state) {
  switch (state) {
    case topic::ModeState::engaged:
      return 0;
    case topic::ModeState::ready:
    case topic::ModeState::settled:
      return 1;
    case topic::ModeState::stopping:
      return 2;
    default:
      return 3;
  }
}

/// Watches over modes and limits, which the score does not know.
class Watch {
 public:
  Watch(const service::GatewayConfig& gateway, LabTime last_from)
      : limits_(gateway.limits), last_from_(last_from) {}

  void take(const topic::Mode& mode, LabOutcome& outcome) {
    outcome.engaged_at_end = mode.state == topic::ModeState::engaged;
    was_engaged_ |= outcome.engaged_at_end;
    if (was_engaged_ && severity(mode.state) > severity(outcome.worst_mode)) outcome.worst_mode = mode.state;
    if (mode.fault_latched && outcome.fault_code.empty()) outcome.fault_code = mode.fault_code.view();
  }

  void take(const topic::TruthWorld& truth, const topic::Reference& set, const plant::World& world,
            LabTime now, LabOutcome& outcome) const {
    constexpr std::size_t kCraneJoints = 3;
    for (std::size_t j = 0; j < kCraneJoints; ++j) {
      outcome.beyond_angle_limit_rad =
          std::max({outcome.beyond_angle_limit_rad, truth.q_rad[j] - limits_.q_max_rad[j],
                    limits_.q_min_rad[j] - truth.q_rad[j]});
      outcome.share_of_speed_limit =
          std::max(outcome.share_of_speed_limit, std::abs(world.qd_radps()[j]) / limits_.qd_max_radps[j]);
    }
    if (now < last_from_) return;
    double squared = 0;
    for (std::size_t i = 0; i < 3; ++i)
      squared += std::pow(truth.p_world_load_m[i] - set.p_world_load_m[i], 2);
    outcome.last_load_error_max_m = std::max(outcome.last_load_error_max_m, std::sqrt(squared));
  }

 private:
  controller::GuardLimits limits_;
  LabTime last_from_;
  bool was_engaged_ = false;
};

}  // namespace

namespace {

topic::ReferenceFrame frame_of(const LabRun& run) {
  return run.reference_frame == "em1500" ? topic::ReferenceFrame::em1500 : topic::ReferenceFrame::world;
}

/// Where the load should truly be: the place the plan asks for, with the ship that carries it.
topic::Reference set_point(const ReferencePlan& plan, LabTime t, const math::RigidTransform& X_WN,
                           const plant::PlatformState& second) {
  const ReferencePlan::Place place = plan.at(t);
  Eigen::Vector3d p_WL = place.p_WL;
  if (place.frame == topic::ReferenceFrame::em1500) p_WL = second.X_WB * (X_WN.inverse() * p_WL);
  topic::Reference set;
  Eigen::Map<Eigen::Vector3d>(set.p_world_load_m.data()) = p_WL;
  return set;
}

/// What the words of the command line change in lab.toml: as texts, so that the effective configuration, from
/// which a recording is run again, has it.
std::vector<TomlText> laid_over(const LabRun& run) {
  std::vector<TomlText> texts;
  const auto lay = [&texts](const std::string& option, const std::string& text) {
    texts.push_back({option, text});
  };
  lay("--platform", "control.platform = \"" + run.platform + '"');
  if (!run.limits.empty()) lay("--limits", "limits.platform = \"" + run.limits + '"');
  if (run.controller == "integral") lay("--controller", "control.law = \"integral\"");
  // Without noise a sensor at rest repeats itself.
  if (run.sensors == "ideal") lay("--sensors", "mru1.stuck_after_s = 0\nmru2.stuck_after_s = 0");
  return texts;
}

}  // namespace

lockstep::Config configure(const LabRun& run) {
  lockstep::Config config;
  // Addresses of the loopback overlay, freshness limits of the laboratory: a virtual clock never stands
  // still.
  const auto lab_toml = run.config.empty() ? find_config("lab.toml") : std::filesystem::path(run.config);
  const auto world_toml =
      run.world_config.empty() ? find_config("world.toml") : std::filesystem::path(run.world_config);
  auto settings = lab::Settings::parse(run.settings);
  for (const auto& text : laid_over(run)) settings.lab.push_back(text);
  config.gateway = service::load_gateway_config(lab_toml, {find_config("loopback.toml")}, settings.lab);
  if (!run.record.empty()) config.gateway.record.inputs = run.record;
  config.lab = lab::LabConfig::load(world_toml, {}, settings.world);
  config.lab.set_scenario(run.scenario);
  config.lab.seed = run.seed;
  if (!run.second_ship.empty()) {
    config.lab.set_second_ship(run.second_ship);
  } else if (frame_of(run) == topic::ReferenceFrame::em1500) {
    config.lab.set_second_ship("sea");
  }
  config.lab.refuse_beyond(config.gateway.platform_limits == "plc" ? plant::PlatformLimits::plc()
                                                                   : plant::PlatformLimits::mechanical(),
                           run.seconds);
  config.lab.set_platform_tracked(run.platform == "tracked");
  if (run.differences == "off") config.lab.use_belief_as_world();
  if (run.sensors == "ideal") config.lab.use_perfect_sensors();
  for (const auto& text : run.faults) config.faults.push_back(lab::PlannedFault::parse(text));
  config.timing = run.timing;
  return config;
}

LabOutcome run_lab(const LabRun& run, const LabObserver& observer) {
  const lockstep::Config config = configure(run);
  lockstep::Lockstep line(config);

  monitor::ScorerConfig scoring;
  scoring.labels.scenario = run.scenario;
  scoring.labels.controller = run.controller;
  scoring.labels.estimator = run.estimator;
  scoring.labels.sensors = run.sensors;
  scoring.labels.seed = run.seed;
  scoring.labels.platform = run.platform;
  scoring.labels.limits = config.gateway.platform_limits;
  scoring.labels.reference_frame = run.reference_frame;
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
  const auto estimate = line.bus().reader<topic::Estimate>();
  const LabTime end = LabTime{} + from_seconds(run.seconds);
  const LabTime engage_at = LabTime{} + from_seconds(run.engage_at_s);
  bool engaged = run.controller == "none";
  LabTime next_truth{};
  LabOutcome outcome;
  Watch watch(config.gateway, end - kLastWindow);
  ReferencePlan plan(run.reference, frame_of(run),
                     Eigen::Map<const Eigen::Vector3d>(config.gateway.p_world_load_reference_m.data()),
                     run.reference_from_s);
  auto references = line.bus().advertise<topic::Reference>();
  while (line.now() < end) {
    if (!engaged && line.now() >= engage_at) {
      line.request(topic::ModeAction::engage);
      engaged = true;
    }
    if (const auto reference = plan.next(line.now())) references.publish(*reference);
    line.step();
    if (const auto sample = mode.newer()) {
      scorer.take(*sample);
      watch.take(*sample, outcome);
    }
    if (const auto sample = control.newer()) scorer.take(*sample);
    if (const auto sample = arm.newer()) scorer.take(*sample);
    if (const auto sample = winch.newer()) scorer.take(*sample);
    if (line.now() >= next_truth) {
      const topic::TruthWorld truth = line.lab().truth();
      const topic::Reference set = set_point(plan, line.now(), config.lab.world.calibration.world_to_em1500,
                                             line.lab().state().second);
      scorer.take(set);
      scorer.take(truth);
      watch.take(truth, set, line.lab().world(), line.now(), outcome);
      if (observer) {
        const auto newest = estimate.newest();
        observer(truth, newest ? &*newest : nullptr);
      }
      next_truth += kTruthPeriod;
    }
  }
  line.bus().for_each_newest<topic::Health>([&scorer](const topic::Health& health) { scorer.take(health); });
  line.finish_recording();
  scorer.run_until(end);
  outcome.report = scorer.report();
  return outcome;
}

std::vector<LabOutcome> run_labs(const std::vector<LabRun>& runs) {
  std::vector<LabOutcome> outcomes(runs.size());
  two_at_a_time(runs.size(), [&](std::size_t i) { outcomes[i] = run_lab(runs[i]); });
  return outcomes;
}

}  // namespace motionlab::study
