/// @file  motionlab-study: the whole line in lockstep, faster than time and the same to the byte on every
/// run.

#include <CLI/CLI.hpp>
#include <fstream>
#include <iostream>
#include <string>

#include "drivers/core/error.hpp"
#include "gateway/monitor/report.hpp"
#include "simulators/lab/study/lab_run.hpp"

namespace {

using namespace motionlab;

struct Options {
  study::LabRun lab;
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

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "The whole line - ship, devices, wires, drivers, estimator, controller, guard - in lockstep on a "
      "virtual "
      "clock. The same options give the same bytes."};
  app.footer("Example: motionlab-study --scenario sea --seed 3 --seconds 120 --report report.json");
  app.add_flag("--list", options.list, "list scenarios, controllers and estimators");
  app.add_option("--scenario", options.lab.scenario, "thesis-wave, sea or calm")->capture_default_str();
  app.add_option("--controller", options.lab.controller, "ours or none")
      ->check(CLI::IsMember({"ours", "none"}))
      ->capture_default_str();
  app.add_option("--estimator", options.lab.estimator)->check(CLI::IsMember({"ours"}))->capture_default_str();
  app.add_option("--sensors", options.lab.sensors, "real, or ideal: no noise, bias or drift")
      ->check(CLI::IsMember({"ideal", "real"}))
      ->capture_default_str();
  app.add_option("--platform", options.lab.platform, "whether the cameras see a body on the platform")
      ->check(CLI::IsMember({"tracked", "untracked"}))
      ->capture_default_str();
  app.add_option("--differences", options.lab.differences, "off: the world is what the gateway believes")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option("--seed", options.lab.seed)->capture_default_str();
  app.add_option("--seconds", options.lab.seconds)->check(CLI::Range(0.01, 86400.0))->capture_default_str();
  app.add_option("--engage-at", options.lab.engage_at_s, "s since the start")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--score-from", options.lab.score_from_s, "s since the start")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--fault", options.lab.faults,
                 "DEVICE:FAULT[=VALUE]@FROM[..UNTIL] in s, e.g. mru1:silent@30")
      ->take_all();
  app.add_option("--set", options.lab.settings,
                 "world.KEY=VALUE or lab.KEY=VALUE over the files, e.g. world.load.mass_kg=36")
      ->take_all();
  app.add_option("--config", options.lab.config,
                 "lab.toml; default: found in deploy/config or /etc/motionlab");
  app.add_option("--world-config", options.lab.world_config, "world.toml; likewise");
  app.add_option("--report", options.report, "write the report here; default: standard output");
  app.add_flag("--timing", options.lab.timing,
               "measure control steps (the report then differs from run to run)");
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.list) {
      list();
      return 0;
    }
    const std::string text = monitor::to_json(study::run_lab(options.lab).report);
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
