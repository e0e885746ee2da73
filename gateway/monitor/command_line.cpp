#include "gateway/monitor/command_line.hpp"

#include <CLI/CLI.hpp>
#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include "drivers/core/error.hpp"
#include "gateway/monitor/check_command.hpp"
#include "gateway/monitor/mode_command.hpp"
#include "gateway/monitor/score_command.hpp"
#include "gateway/monitor/status_command.hpp"

namespace motionlab::monitor {
namespace {

constexpr const char* kFooter = R"(
Examples:
  motionlab status                            is everything fresh and healthy?
  motionlab engage --wait 30                  wait until the gateway is ready, then engage
  motionlab settle                            bring everything to rest, from anywhere, at any time
  motionlab reset                             acknowledge a latched fault once its cause is gone
  motionlab score --seconds 60 --report r.json
  motionlab check mru --listen 50043          which format does this unit send?
  motionlab --interface 127.0.0.1 status      a laboratory started by lab.sh

Exit codes: 0 good, 1 something is wrong or the gateway said no, 2 nobody answers, 64 wrong usage, 130 interrupted.)";

/// What the command line says, and which command it chose.
struct Chosen {
  Connection connection;
  bool json = false;
  ModeCommand mode;
  ScoreCommand score;
  CheckMruCommand check_mru;
  std::function<int(const Terminal&)> run;
};

/// They may stand before or after the name of the command.
void add_common(CLI::App& app, Chosen& chosen) {
  app.add_option("--domain", chosen.connection.domain, "DDS domain, 0 to 232 (42)")
      ->check(CLI::Range(0, 232))
      ->envname("MOTIONLAB_DOMAIN");
  app.add_option("--interface", chosen.connection.interfaces,
                 "address of this host to use for DDS; may be given several times (all interfaces)")
      ->allow_extra_args(false)
      ->envname("MOTIONLAB_INTERFACE");
  app.add_option("--timeout", chosen.connection.timeout_s, "seconds to wait for an answer (5)")
      ->check(CLI::Range(0.0, 3600.0));
  app.add_flag("--json", chosen.json, "answer in JSON on standard output");
}

void add_mode_command(CLI::App& app, Chosen& chosen, topic::ModeAction action, const std::string& what) {
  CLI::App* const command = app.add_subcommand(std::string{to_string(action)}, what);
  if (action == topic::ModeAction::engage) {
    command->add_option("--wait", chosen.mode.wait_ready_s, "first wait so many seconds for ready (0)")
        ->check(CLI::Range(0.0, 3600.0));
    command->add_option("--at-ns", chosen.mode.at_ns, "ask at this laboratory time, in ns since 1970 (now)");
  }
  command->callback([&chosen, action] {
    chosen.mode.action = action;
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.mode.json = chosen.json;
      return run_mode(chosen.connection, chosen.mode, terminal);
    };
  });
}

void add_status(CLI::App& app, Chosen& chosen) {
  app.add_subcommand("status", "mode, owner, reason, and one line for each device")->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      return run_status(chosen.connection, chosen.json, terminal);
    };
  });
}

void add_score(CLI::App& app, Chosen& chosen) {
  CLI::App* const command =
      app.add_subcommand("score", "how still the load is: a line a second, then a report");
  ScoreCommand& score = chosen.score;
  command->add_option("--seconds", score.seconds, "end of the run (until Ctrl-C)")
      ->check(CLI::PositiveNumber);
  command->add_option("--from", score.from_s, "second of the run from which is scored (20)")
      ->check(CLI::NonNegativeNumber);
  command->add_option("--start-ns", score.start_ns,
                      "laboratory time of second 0, in ns since 1970 (the first sample that is seen)");
  command->add_option("--report", score.report_path, "write the report to this file");
  command->add_option("--scenario", score.labels.scenario, "name of the scenario, for the report");
  command->add_option("--seed", score.labels.seed, "seed of the run, for the report");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.score.json = chosen.json;
      return run_score(chosen.connection, chosen.score, terminal);
    };
  });
}

void add_check(CLI::App& app, Chosen& chosen) {
  CLI::App* const check = app.add_subcommand("check", "listens to a device in the gateway's place");
  check->require_subcommand(1);
  CLI::App* const command =
      check->add_subcommand("mru", "which format a motion reference unit sends, and one sample of it");
  CheckMruCommand& mru = chosen.check_mru;
  command->add_option("--listen", mru.port, "UDP port; no gateway may be listening there")
      ->required()
      ->check(CLI::Range(1, 65535));
  command->add_option("--seconds", mru.seconds, "how long to listen (2)")->check(CLI::Range(0.1, 3600.0));
  command
      ->add_option("--variables", mru.variables,
                   "list of an mrubin unit, by number, with commas (the laboratory's)")
      ->delimiter(',');
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.check_mru.json = chosen.json;
      return run_check_mru(chosen.check_mru, terminal);
    };
  });
}

}  // namespace

int run_command_line(int argc, const char* const* argv, const Terminal& terminal) {
  Chosen chosen;
  CLI::App app{"The user's hand on a running motionlab-gateway.", "motionlab"};
  app.footer(kFooter);
  app.fallthrough();
  add_common(app, chosen);
  add_status(app, chosen);
  add_mode_command(app, chosen, topic::ModeAction::engage, "ask the gateway to keep the load still");
  add_mode_command(app, chosen, topic::ModeAction::settle, "bring everything to rest");
  add_mode_command(app, chosen, topic::ModeAction::reset, "acknowledge a latched fault");
  add_score(app, chosen);
  add_check(app, chosen);
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    return chosen.run(terminal);
  } catch (const CLI::RequiredError& error) {
    const std::vector<std::string> unknown = app.remaining();
    if (unknown.empty()) {
      app.exit(error, terminal.out, terminal.err);
    } else {
      terminal.err << "motionlab: there is no " << unknown.front() << "; see motionlab --help\n";
    }
    return kExitUsage;
  } catch (const CLI::ParseError& error) {
    return app.exit(error, terminal.out, terminal.err) == 0 ? kExitGood : kExitUsage;
  } catch (const StartupError& error) {
    terminal.err << "motionlab: " << error.what() << "\n";
    return kExitUsage;
  }
}

}  // namespace motionlab::monitor
