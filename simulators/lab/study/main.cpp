/// @file  motionlab-study: the whole line in lockstep, faster than time and the same to the byte on every
/// run.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "drivers/core/config_path.hpp"
#include "drivers/core/error.hpp"
#include "gateway/monitor/scorer.hpp"
#include "gateway/service/gateway_config.hpp"
#include "simulators/lab/lockstep/lockstep.hpp"

namespace {

using namespace motionlab;

/// The truth is scored this often.
constexpr Nanoseconds kTruthPeriod = 1ms;

struct Options {
  std::string config;
  std::string world_config;
  std::string scenario = "thesis-wave";
  std::string controller = "ours";
  std::string estimator = "ours";
  std::string sensors = "real";
  std::string platform = "tracked";
  std::string differences = "on";
  std::vector<std::string> faults;
  std::uint64_t seed = 1;
  double seconds = 60;
  double engage_at_s = 10;
  double score_from_s = 20;
  bool timing = false;
  bool list = false;
  std::string report;
};

void list() {
  std::cout << "scenarios    thesis-wave  the wave of the thesis, Tab 4.4 (default)\n"
               "             sea          JONSWAP, Hs 0.5 m, Tp 7 s, drawn from the seed\n"
               "             calm         the ship rests\n"
               "controllers  ours         keeps the load still (default)\n"
               "             none         nothing is engaged; everything else runs\n"
               "estimators   ours\n";
}

lockstep::Config configure(const Options& options) {
  lockstep::Config config;
  // Addresses of the loopback overlay, freshness limits of the laboratory: a virtual clock never stands
  // still.
  const auto lab_toml =
      options.config.empty() ? find_config("lab.toml") : std::filesystem::path(options.config);
  config.gateway = service::load_gateway_config(lab_toml, {find_config("loopback.toml")});
  config.lab = lab::LabConfig::load(
      options.world_config.empty() ? find_config("world.toml") : std::filesystem::path(options.world_config));
  config.lab.set_scenario(options.scenario);
  config.lab.seed = options.seed;
  const bool tracked = options.platform == "tracked";
  config.lab.set_platform_tracked(tracked);
  config.gateway.set_platform_tracked(tracked);
  if (options.differences == "off") config.lab.use_belief_as_world();
  if (options.sensors == "ideal") config.lab.use_perfect_sensors();
  for (const auto& text : options.faults) config.faults.push_back(lab::PlannedFault::parse(text));
  config.timing = options.timing;
  return config;
}

monitor::Report run(const Options& options) {
  const lockstep::Config config = configure(options);
  lockstep::Lockstep line(config);

  monitor::ScorerConfig scoring;
  scoring.labels.scenario = options.scenario;
  scoring.labels.controller = options.controller;
  scoring.labels.estimator = options.estimator;
  scoring.labels.sensors = options.sensors;
  scoring.labels.seed = options.seed;
  scoring.labels.platform = options.platform;
  scoring.p_world_load_m = config.gateway.p_world_load_reference_m;
  scoring.t_start = LabTime{};
  scoring.score_from_s = options.score_from_s;
  scoring.timing = options.timing;
  monitor::Scorer scorer(scoring);
  for (const auto& fault : config.faults) {
    scorer.note_fault(LabTime{} + from_seconds(fault.from_s), fault.device + ":" + fault.fault);
  }

  auto control = line.bus().reader<topic::Control>();
  auto mode = line.bus().reader<topic::Mode>();
  auto arm = line.bus().reader<topic::ArmState>(config.gateway.comau.driver.device);
  auto winch = line.bus().reader<topic::WinchState>(config.gateway.winch.driver.device);
  const LabTime end = LabTime{} + from_seconds(options.seconds);
  const LabTime engage_at = LabTime{} + from_seconds(options.engage_at_s);
  bool engaged = options.controller == "none";
  LabTime next_truth{};
  while (line.now() < end) {
    if (!engaged && line.now() >= engage_at) {
      line.request(topic::ModeAction::engage);
      engaged = true;
    }
    line.step();
    if (const auto sample = mode.newer()) scorer.take(*sample);
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
  return scorer.report();
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "The whole line - ship, devices, wires, drivers, estimator, controller, guard - in lockstep on a "
      "virtual "
      "clock. The same options give the same bytes."};
  app.footer("Example: motionlab-study --scenario sea --seed 3 --seconds 120 --report report.json");
  app.add_flag("--list", options.list, "list scenarios, controllers and estimators");
  app.add_option("--scenario", options.scenario, "thesis-wave, sea or calm")->capture_default_str();
  app.add_option("--controller", options.controller, "ours or none")
      ->check(CLI::IsMember({"ours", "none"}))
      ->capture_default_str();
  app.add_option("--estimator", options.estimator)->check(CLI::IsMember({"ours"}))->capture_default_str();
  app.add_option("--sensors", options.sensors, "real, or ideal: no noise, bias or drift")
      ->check(CLI::IsMember({"ideal", "real"}))
      ->capture_default_str();
  app.add_option("--platform", options.platform, "whether the cameras see a body on the platform")
      ->check(CLI::IsMember({"tracked", "untracked"}))
      ->capture_default_str();
  app.add_option("--differences", options.differences, "off: the world is what the gateway believes")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_option("--seconds", options.seconds)->check(CLI::Range(0.01, 86400.0))->capture_default_str();
  app.add_option("--engage-at", options.engage_at_s, "s since the start")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--score-from", options.score_from_s, "s since the start")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--fault", options.faults, "DEVICE:FAULT[=VALUE]@FROM[..UNTIL] in s, e.g. mru1:silent@30")
      ->take_all();
  app.add_option("--config", options.config, "lab.toml; default: found in deploy/config or /etc/motionlab");
  app.add_option("--world-config", options.world_config, "world.toml; likewise");
  app.add_option("--report", options.report, "write the report here; default: standard output");
  app.add_flag("--timing", options.timing, "measure control steps (the report then differs from run to run)");
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.list) {
      list();
      return 0;
    }
    const std::string text = monitor::to_json(run(options));
    if (options.report.empty()) {
      std::cout << text;
      return 0;
    }
    std::ofstream file(options.report, std::ios::binary);
    file << text;
    if (!file.flush())
      throw StartupError("cannot write " + options.report + "; choose a folder that exists and is writable");
    return 0;
  } catch (const StartupError& error) {
    std::cerr << "motionlab-study: " << error.what() << '\n';
    return 2;
  }
}
