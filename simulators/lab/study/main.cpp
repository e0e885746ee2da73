/// @file  motionlab-study: the whole line in lockstep, faster than time and the same to the byte on every
/// run.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>

#include "drivers/core/error.hpp"
#include "gateway/monitor/report.hpp"
#include "gateway/service/replay.hpp"
#include "simulators/lab/study/fault_matrix_command.hpp"
#include "simulators/lab/study/figures.hpp"
#include "simulators/lab/study/lab_run.hpp"
#include "simulators/lab/study/option_words.hpp"
#include "simulators/lab/study/replay_report.hpp"
#include "simulators/lab/study/robustness_table.hpp"
#include "simulators/lab/study/source_table.hpp"
#include "simulators/lab/study/thesis_words.hpp"
#include "simulators/lab/thesis/metrics.hpp"
#include "simulators/lab/thesis/table.hpp"

namespace {

using namespace motionlab;

/// A run of a table, when nobody says how long.
constexpr double kTable_s = 120;

struct Options {
  study::LabRun lab;
  study::ThesisWords thesis;
  study::FaultMatrixWords matrix;
  bool list = false;
  std::string table;
  std::string figures;
  std::string report;
  std::string replay;
};

void list() {
  std::cout
      << "scenarios    thesis-wave  the wave of the thesis, Tab 4.4 (default)\n"
         "             sea          JONSWAP, Hs 0.5 m, Tp 7 s, drawn from the seed\n"
         "             pierson-moskowitz  Hs 0.4 m, Tp 7 s, likewise\n"
         "             calm         the ship rests\n"
         "             csv:FILE     a recording: t_s, surge_m, sway_m, heave_m (down), roll_deg, "
         "pitch_deg, yaw_deg\n"
         "controllers  ours         keeps the load still (default)\n"
         "             integral     the thesis' integral controller, to compare with\n"
         "             none         nothing is engaged; everything else runs\n"
         "estimators   ours\n"
         "references   hold         where lab.toml says (default)\n"
         "             step         0.15 m in x and y, 0.2 m down, at 30, 50, 70 s, back at 90 s\n"
         "             sine         0.1, 0.08, 0.1 m at 0.05, 0.07, 0.04 Hz from 30 s, told every 10 ms\n"
         "             follow       a circle of 0.12 m in 30 s from 30 s, told every 100 ms\n\n"
      << thesis::describe()
      << "\ntables       thesis       every printed number of the thesis beside ours\n"
         "             robustness   what wrong beliefs, failures and a gust do to the load; 120 s each "
         "unless told\n"
         "             sources      which error the load's rest comes from; likewise\n\n"
      << study::describe_figures();
}

void write_figures(const CLI::App& app, const Options& options) {
  study::allow_only(app, "figures", "--figures",
                    {"seed", "seconds", "set", "config", "world-config", "differences", "sensors", "limits"});
  study::write_figures(options.figures, options.lab);
  std::cout << "open " << (std::filesystem::path(options.figures) / "index.html").string() << '\n';
}

void write_file(const std::string& name, const std::string& text) {
  std::ofstream file(name, std::ios::binary);
  file << text;
  if (!file.flush())
    throw StartupError("cannot write " + name + "; choose a folder that exists and is writable");
}

std::string report(const CLI::App& app, const Options& options) {
  if (options.thesis.wanted()) {
    return monitor::to_json(thesis::report(choose(study::thesis_request(app, options.lab, options.thesis))));
  }
  study::refuse_thesis_words(options.lab, options.thesis);
  return monitor::to_json(study::run_lab(options.lab).report);
}

std::string answer(const CLI::App& app, const Options& options) {
  if (options.table == "thesis") return thesis::comparison_table();
  study::LabRun each = options.lab;
  if (app.count("--seconds") == 0) each.seconds = kTable_s;
  if (options.table == "robustness") return study::robustness_table(each);
  if (options.table == "sources") return study::source_table(each);
  return report(app, options);
}

/// Runs a recording again. @returns the exit code
int replay(const CLI::App& app, const Options& options) {
  study::allow_only(app, "replay", "--replay", {"report"});
  const service::ReplayOutcome outcome = service::replay(options.replay);
  std::cout << service::describe(outcome) << '\n';
  if (!options.report.empty()) write_file(options.report, study::replay_json(outcome));
  return outcome.difference ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "The whole line - ship, devices, wires, drivers, estimator, controller, guard - in lockstep on a "
      "virtual "
      "clock. The same options give the same bytes."};
  app.footer("Example: motionlab-study --scenario sea --seed 3 --seconds 120 --report report.json");
  app.add_flag("--list", options.list, "list scenarios, controllers, estimators, tables and figures");
  app.add_option("--scenario", options.lab.scenario, "thesis-wave, sea, pierson-moskowitz, calm or csv:FILE")
      ->capture_default_str();
  app.add_option("--controller", options.lab.controller, "ours or none; --list shows those of the thesis")
      ->check(CLI::IsMember({"ours", "none", "prefilter", "integral", "damper"}))
      ->capture_default_str();
  app.add_option("--estimator", options.lab.estimator, "ours; --list shows those of the thesis")
      ->check(CLI::IsMember({"ours", "ideal", "kf4", "ekf4", "ekf10", "ekf35"}))
      ->capture_default_str();
  options.thesis.add_to(app);
  app.add_option("--table", options.table, "print a table and exit")
      ->check(CLI::IsMember({"thesis", "robustness", "sources"}));
  app.add_option("--figures", options.figures,
                 "write the thesis' result figures, ours beside them, and index.html into this folder; seed, "
                 "seconds, files and differences are those of ours");
  options.matrix.add_to(app);
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
  app.add_option("--limits", options.lab.limits,
                 "of the platform, which the sea has to keep; default: [limits] platform of lab.toml")
      ->check(CLI::IsMember({"mechanical", "plc"}));
  app.add_option("--reference", options.lab.reference,
                 "where the load is asked to be: hold, step, sine or follow (--list)")
      ->check(CLI::IsMember({"hold", "step", "sine", "follow"}))
      ->capture_default_str();
  app.add_option("--reference-from", options.lab.reference_from_s,
                 "s since the start, when it begins to move")
      ->check(CLI::Range(0.0, 86400.0))
      ->capture_default_str();
  app.add_option("--reference-frame", options.lab.reference_frame, "what carries that place")
      ->check(CLI::IsMember({"world", "em1500"}))
      ->capture_default_str();
  app.add_option("--second-ship", options.lab.second_ship,
                 "its scenario; default: sea if it carries the reference, else as in world.toml");
  app.add_option("--set", options.lab.settings,
                 "world.KEY=VALUE or lab.KEY=VALUE over the files, e.g. world.load.mass_kg=36")
      ->take_all();
  app.add_option("--config", options.lab.config,
                 "lab.toml; default: found in deploy/config or /etc/motionlab");
  app.add_option("--world-config", options.lab.world_config, "world.toml; likewise");
  app.add_option("--record", options.lab.record,
                 "write what the control thread takes in and gives out into this MCAP file");
  app.add_option(
      "--replay", options.replay,
      "run such a file, of the study or of motionlab-gateway, through estimator, controller and guard "
      "again; exit code 0 only if everything comes out the same to the bit");
  app.add_option("--report", options.report, "write the report here; default: standard output");
  app.add_flag("--timing", options.lab.timing,
               "measure control steps (the report then differs from run to run)");
  CLI11_PARSE(app, argc, argv);
  try {
    if (options.list) {
      list();
      return 0;
    }
    if (!options.replay.empty()) return replay(app, options);
    if (!options.figures.empty()) {
      write_figures(app, options);
      return 0;
    }
    if (options.matrix.wanted()) {
      return study::fault_matrix(app, options.lab, options.matrix, options.report);
    }
    const std::string text = answer(app, options);
    if (options.report.empty()) {
      std::cout << text;
      return 0;
    }
    write_file(options.report, text);
    return 0;
  } catch (const StartupError& error) {
    std::cerr << "motionlab-study: " << error.what() << '\n';
    return 2;
  }
}
