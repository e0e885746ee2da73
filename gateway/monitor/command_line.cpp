#include "gateway/monitor/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/error.hpp"
#include "gateway/monitor/check_command.hpp"
#include "gateway/monitor/completion.hpp"
#include "gateway/monitor/delay_command.hpp"
#include "gateway/monitor/echo_command.hpp"
#include "gateway/monitor/export_command.hpp"
#include "gateway/monitor/mode_command.hpp"
#include "gateway/monitor/nearest_name.hpp"
#include "gateway/monitor/rate_command.hpp"
#include "gateway/monitor/record_command.hpp"
#include "gateway/monitor/reference_command.hpp"
#include "gateway/monitor/replay_command.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/score_command.hpp"
#include "gateway/monitor/status_command.hpp"
#include "gateway/monitor/topic_table.hpp"
#include "gateway/monitor/topics_command.hpp"
#include "gateway/monitor/verify_command.hpp"

namespace motionlab::monitor {
namespace {

constexpr const char* kFooter = R"(
Examples:
  motionlab status                            is everything fresh and healthy?
  motionlab topics                            who writes and reads what on the bus
  motionlab echo estimate --field swing_rad   how the load swings, as it happens
  motionlab engage --wait 30                  wait until the gateway is ready, then engage
  motionlab settle                            bring everything to rest, from anywhere, at any time
  motionlab reset                             acknowledge a latched fault once its cause is gone
  motionlab --interface 127.0.0.1 status      a laboratory started by lab.sh
Each command has more examples: motionlab COMMAND --help

Exit codes: 0 good, 1 something is wrong or the gateway said no, 2 nobody answers or nothing was heard,
64 wrong usage, no such topic or field, or no connection, 130 interrupted.)";

/// What the command line says, and which command it chose.
struct Chosen : Common {
  ModeCommand mode;
  ScoreCommand score;
  CheckMruCommand check_mru;
  TopicsCommand topics;
  EchoCommand echo;
  RateCommand rate;
  DelayCommand delay;
  ReferenceCommand reference;
  RecordCommand record;
  VerifyCommand verify;
  ExportCommand exporting;
  ReplayCommand replay;
  std::vector<double> place;
  std::string shell;
  Run run;
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
  CLI::Option* const peers =
      app.add_option("--peer", chosen.connection.peers,
                     "address of another host, where multicast does not go; several with commas")
          ->delimiter(',')
          ->allow_extra_args(false)
          ->envname("MOTIONLAB_PEER");
  app.add_option("--server", chosen.connection.server, "address:port of the discovery server of this bus")
      ->excludes(peers)
      ->envname("MOTIONLAB_SERVER");
  app.add_option("--security", chosen.connection.security,
                 "folder with your identity, where the bus is protected")
      ->type_name("FOLDER")
      ->envname("MOTIONLAB_SECURITY");
  app.add_option("--timeout", chosen.connection.timeout_s, "seconds to wait for an answer (5)")
      ->check(CLI::Range(0.0, 3600.0));
  app.add_flag("--json", chosen.json, "answer in JSON on standard output");
}

topic::Authority authority_named(std::string_view name) {
  for (const auto level : {topic::Authority::observe, topic::Authority::shadow, topic::Authority::limited}) {
    if (to_string(level) == name) return level;
  }
  return topic::Authority::full;
}

void add_mode_command(CLI::App& app, Chosen& chosen, topic::ModeAction action, const std::string& what,
                      const std::string& examples) {
  CLI::App* const command = app.add_subcommand(std::string{to_string(action)}, what);
  if (action == topic::ModeAction::engage) {
    command->add_option("--wait", chosen.mode.wait_ready_s, "first wait so many seconds for ready (0)")
        ->check(CLI::Range(0.0, 3600.0));
    command->add_option("--at-ns", chosen.mode.at_ns, "ask at this laboratory time, in ns since 1970 (now)");
  }
  if (action == topic::ModeAction::authority) {
    command
        ->add_option_function<std::string>(
            "level", [&chosen](const std::string& level) { chosen.mode.authority = authority_named(level); },
            "how much the gateway may do once engaged: observe sends nothing, shadow computes and publishes, "
            "limited "
            "sends at a tenth of the limits, full")
        ->required()
        ->type_name("LEVEL")
        ->check(CLI::IsMember({"observe", "shadow", "limited", "full"}));
  }
  command->footer(examples);
  command->callback([&chosen, action] {
    chosen.mode.action = action;
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.mode.json = chosen.json;
      return run_mode(chosen.connection, chosen.mode, terminal);
    };
  });
}

void add_status(CLI::App& app, Chosen& chosen) {
  CLI::App* const command = app.add_subcommand("status", "mode, owner, reason, and one line for each device");
  command->footer(R"(
Examples:
  motionlab status
  motionlab status --json | jq .mode.state
Ends with 0 when all is healthy, 1 when something is not.)");
  command->callback([&chosen] {
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
  command->add_option("--report", score.report_path, "write the report to this file")->type_name("FILE");
  command->add_option("--scenario", score.labels.scenario, "name of the scenario, for the report");
  command->add_option("--seed", score.labels.seed, "seed of the run, for the report");
  command->footer(R"(
Examples:
  motionlab score --seconds 60 --report r.json
  motionlab score --json > r.json             until Ctrl-C)");
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
                   "list of an mrubin or nmeap unit, by number, with commas (the laboratory's)")
      ->delimiter(',');
  command->footer(R"(
Example:
  motionlab check mru --listen 50043          which format does this unit send?)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.check_mru.json = chosen.json;
      return run_check_mru(chosen.check_mru, terminal);
    };
  });
}

void add_topics(CLI::App& app, Chosen& chosen) {
  CLI::App* const command =
      app.add_subcommand("topics", "who writes and reads what on the bus, strangers included");
  command->add_option("--wait", chosen.topics.wait_s, "seconds to listen: discovery has no end (2)")
      ->check(CLI::Range(0.0, 3600.0));
  command->add_flag("--endpoints", chosen.topics.endpoints, "also show every writer and reader");
  command->footer(R"(
Examples:
  motionlab topics
  motionlab topics --endpoints --wait 5
  motionlab topics --json | jq '.topics[] | select(.known | not)'    what is not ours)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.topics.json = chosen.json;
      return run_topics(chosen.connection, chosen.topics, terminal);
    };
  });
}

void add_topic_name(CLI::App& command, std::string& topic) {
  command.add_option("topic", topic, "e.g. motionlab/mru, or mru for short; see motionlab topics")
      ->required()
      ->type_name("TOPIC");
}

void add_echo(CLI::App& app, Chosen& chosen) {
  CLI::App* const command = app.add_subcommand("echo", "the samples of a topic, as they come");
  EchoCommand& echo = chosen.echo;
  add_topic_name(*command, echo.topic);
  command
      ->add_option("--field", echo.fields,
                   "only this field, e.g. p_world_load_m[2]; may be given several times")
      ->allow_extra_args(false)
      ->type_name("PATH");
  command->add_option("--device", echo.device, "only samples of this device")->type_name("NAME");
  CLI::Option* const count =
      command->add_option("--count", echo.count, "end after so many samples (until Ctrl-C)")
          ->check(CLI::PositiveNumber);
  command
      ->add_flag_callback(
          "--once", [&echo] { echo.count = 1; }, "end after the first sample")
      ->excludes(count);
  command->add_flag_callback(
      "--csv", [&echo] { echo.format = EchoCommand::Format::csv; },
      "as CSV with a header; --json: one line a sample");
  command->footer(R"(
Examples:
  motionlab echo mode --once
  motionlab echo estimate --field swing_rad --field p_world_load_m[2]
  motionlab echo mru --device mru1 --json --count 1000 > mru1.jsonl
  motionlab echo arm_state --csv > arm.csv
Nothing within --timeout seconds ends it with 2.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      if (chosen.json && chosen.echo.format == EchoCommand::Format::csv) {
        throw StartupError{"--json and --csv exclude each other: choose one"};
      }
      if (chosen.json) chosen.echo.format = EchoCommand::Format::json;
      return run_echo(chosen.connection, chosen.echo, terminal);
    };
  });
}

void add_rate(CLI::App& app, Chosen& chosen) {
  CLI::App* const command =
      app.add_subcommand("rate", "how fast and how even a topic is, and what is missing of it");
  RateCommand& rate = chosen.rate;
  add_topic_name(*command, rate.topic);
  command->add_option("--window", rate.window_s, "seconds to measure, from the first sample on (5)")
      ->check(CLI::Range(0.1, 3600.0));
  command->add_option("--count", rate.count, "end after so many samples")->check(CLI::PositiveNumber);
  command->add_option("--at-least", rate.at_least_hz, "end with 1 when any instance is slower, in Hz")
      ->check(CLI::PositiveNumber);
  command->footer(R"(
Examples:
  motionlab rate mru
  motionlab rate bodies --window 60 --json
  motionlab rate arm_state --at-least 190 || echo "the arm is slow"
The rate comes from the samples' own numbers and stamps, never from when they arrived. "missing numbers" are gaps in a
device's own count; "lost on DDS" are samples that were written, but not heard here.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.rate.json = chosen.json;
      return run_rate(chosen.connection, chosen.rate, terminal);
    };
  });
}

void add_delay(CLI::App& app, Chosen& chosen) {
  CLI::App* const command =
      app.add_subcommand("delay", "how old the data is, hop by hop, from the measurement to here");
  command->add_option("--window", chosen.delay.window_s, "seconds to measure, from the first sample on (5)")
      ->check(CLI::Range(0.1, 600.0));
  command->footer(R"(
Examples:
  motionlab delay
  motionlab delay --window 60 --json
Hops between two clocks are true on one host, or as good as the hosts' synchronisation; the answer says which.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.delay.json = chosen.json;
      return run_delay(chosen.connection, chosen.delay, terminal);
    };
  });
}

void add_reference(CLI::App& app, Chosen& chosen) {
  CLI::App* const command =
      app.add_subcommand("reference", "where the load shall be; without a place: where it is");
  ReferenceCommand& reference = chosen.reference;
  command->add_option("place", chosen.place, "x y z of the load in metres, z up; negative numbers after --")
      ->expected(3)
      ->type_name("METRES");
  command->add_flag("--by", reference.by, "the place is relative to where the load is now");
  command
      ->add_option_function<std::string>(
          "--frame",
          [&reference](const std::string& frame) {
            reference.frame = frame == "world" ? topic::ReferenceFrame::world : topic::ReferenceFrame::em1500;
          },
          "what carries the place: the world, or the second ship (world)")
      ->check(CLI::IsMember({"world", "em1500"}));
  command
      ->add_option("--wait", reference.wait_s,
                   "wait so many seconds until the load is there, else end with 1 (0)")
      ->check(CLI::Range(0.0, 3600.0));
  command->add_option("--within", reference.within_m, "how near is there, in metres (0.02)")
      ->check(CLI::PositiveNumber);
  command->footer(R"(
Examples:
  motionlab reference                         where is the load?
  motionlab reference 0.85 0.3 3.9 --wait 30
  motionlab reference --by -- 0 0.1 -0.05     ten centimetres to port, five down
The gateway approaches it within its own limits.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      ReferenceCommand& wanted = chosen.reference;
      wanted.json = chosen.json;
      if (!std::ranges::all_of(chosen.place, [](double x) { return std::isfinite(x); })) {
        throw StartupError{"a place is three finite numbers, x y z in metres"};
      }
      const bool on_second_ship = wanted.frame == topic::ReferenceFrame::em1500;
      if (chosen.place.empty() && (wanted.by || on_second_ship || wanted.wait_s > 0)) {
        throw StartupError{"--by, --frame and --wait belong to a place: give x y z in metres"};
      }
      if (on_second_ship && (wanted.by || wanted.wait_s > 0)) {
        throw StartupError{"--by and --wait are about the world: leave them away with --frame em1500"};
      }
      if (!chosen.place.empty()) wanted.p_world_load_m = {chosen.place[0], chosen.place[1], chosen.place[2]};
      return run_reference(chosen.connection, wanted, terminal);
    };
  });
}

void add_record(CLI::App& app, Chosen& chosen) {
  CLI::App* const command = app.add_subcommand("record", "what is said on the bus, into an MCAP file");
  RecordCommand& record = chosen.record;
  command
      ->add_option("-o,--output", record.to,
                   "file, or folder for a file named by the date; nothing is ever written over")
      ->type_name("FILE_OR_FOLDER");
  command->add_option("--topics", record.topics, "only these, with commas between them (all of the house)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("TOPIC");
  command->add_option("--seconds", record.seconds, "end after so many seconds (until Ctrl-C)")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--config", record.config,
                   "the gateway's lab.toml: attached, and what is in effect with its overlays")
      ->type_name("FILE");
  command->add_option("--overlay", record.overlays, "the gateway's overlay; may be given several times")
      ->allow_extra_args(false)
      ->needs("--config")
      ->type_name("FILE");
  command->add_option("--attach", record.attachments, "any other file to attach; may be given several times")
      ->allow_extra_args(false)
      ->type_name("FILE");
  CLI::Option* const on_event =
      command
          ->add_option("--on-event", record.on_event,
                       "only what surrounds such events, each into a file of its own: info, warning, fault "
                       "(at least so "
                       "severe) or the code of an event; several with commas between them")
          ->delimiter(',')
          ->allow_extra_args(false)
          ->type_name("WHAT");
  command->add_option("--before", record.before_s, "seconds before the event (10)")
      ->check(CLI::Range(0.0, 120.0))
      ->needs(on_event);
  command->add_option("--after", record.after_s, "seconds after the last such event (10)")
      ->check(CLI::Range(0.0, 3600.0))
      ->needs(on_event);
  command->add_option("--split-mb", record.split_mb, "begin a new file after so many megabytes (1024)")
      ->check(CLI::Range(1, 1'000'000));
  command
      ->add_option(
          "--disk-mb", record.disk_mb,
          "keep the newest so many megabytes: the oldest files of this recording are deleted, each a "
          "quarter of it at most (no limit)")
      ->check(CLI::Range(4, 100'000'000));
  command->footer(R"(
Examples:
  motionlab record                                        everything, into a file named by the date
  motionlab record -o run.mcap --seconds 60 --config /etc/motionlab/lab.toml
  motionlab record -o /var/tmp --topics mru,arm_state
  motionlab record -o /data --disk-mb 20000               the newest 20 GB, for ever
  motionlab record -o /data --on-event fault --before 30  half a minute before each fault, and 10 s after it
  motionlab record -o /data --on-event mru1_stale,arm_stale
Samples lie in the file as they came, with their schema: Foxglove, Lichtblick and the mcap tools read it. At its end is
the ledger of what is missing. After a power cut or kill -9 all but the last second is there: motionlab verify --repair.
Ends with 1 when the disk took no more, 2 when nothing was heard.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.record.json = chosen.json;
      return run_record(chosen.connection, chosen.record, terminal);
    };
  });
}

void add_recording_file(CLI::App& command, std::string& file) {
  command.add_option("file", file, "a recording")->required()->type_name("FILE");
}

void add_verify(CLI::App& app, Chosen& chosen) {
  CLI::App* const command = app.add_subcommand("verify", "what is in a recording, and what is missing");
  add_recording_file(*command, chosen.verify.file);
  command->add_option("--repair", chosen.verify.repaired, "write a whole file of all that is good to OUT")
      ->type_name("OUT");
  command->footer(R"(
Examples:
  motionlab verify run.mcap
  motionlab verify run.mcap --repair whole.mcap     after a power cut
  motionlab verify run.mcap --json | jq '.topics[] | {topic, messages}'
"lost" is the ledger at the end of the file; where that is missing, gaps in the numbers of the messages.
Ends with 0 when the file is whole or was repaired, 1 when it is not.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      chosen.verify.json = chosen.json;
      return run_verify(chosen.verify, terminal);
    };
  });
}

void add_export(CLI::App& app, Chosen& chosen) {
  CLI::App* const command = app.add_subcommand("export", "a recording as tables for MATLAB and pandas");
  ExportCommand& exporting = chosen.exporting;
  add_recording_file(*command, exporting.file);
  command->add_flag("--csv", exporting.csv, "as CSV, a file for each topic")->required();
  command->add_option("--topic", exporting.topics, "only this topic; may be given several times (all)")
      ->allow_extra_args(false)
      ->type_name("TOPIC");
  command->add_option("-o,--output", exporting.folder, "folder (named like the file, beside it)")
      ->type_name("FOLDER");
  command->footer(R"(
Examples:
  motionlab export run.mcap --csv                      run/motionlab_mru.csv and so on
  motionlab export run.mcap --csv --topic estimate -o tables
  pandas.read_csv("run/motionlab_mru.csv")             readtable("run/motionlab_mru.csv") in MATLAB
Columns are the fields of the IDL, units in their names; before them when a sample was heard and written, in ns since
1970. Tables are never written over.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) { return run_export(chosen.exporting, terminal); };
  });
}

void add_replay(CLI::App& app, Chosen& chosen) {
  CLI::App* const command =
      app.add_subcommand("replay", "says a recording again on DDS, where no gateway lives");
  ReplayCommand& replay = chosen.replay;
  add_recording_file(*command, replay.file);
  command->add_option("--speed", replay.speed, "so many times as fast as it was (1)")
      ->check(CLI::Range(0.001, 1e6));
  command->add_option("--topics", replay.topics, "only these, with commas between them")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("TOPIC");
  command->footer(R"(
Examples:
  motionlab replay run.mcap --domain 43                     then: motionlab-console, motionlab echo … in domain 43
  motionlab replay run.mcap --domain 43 --speed 10 --topics mru,bodies
Nothing recorded may move a robot: where a gateway lives, or as soon as one appears, nothing is said. Commands, requests
and references are said only when --topics names them.)");
  command->callback([&chosen] {
    chosen.run = [&chosen](const Terminal& terminal) {
      return run_replay(chosen.connection, chosen.replay, terminal);
    };
  });
}

void add_completion(CLI::App& app, Chosen& chosen) {
  CLI::App* const command =
      app.add_subcommand("completion", "prints a script that completes this command line");
  command->add_option("shell", chosen.shell, "of which shell")
      ->required()
      ->type_name("SHELL")
      ->check(CLI::IsMember({"bash", "zsh"}));
  command->footer(R"(
Examples:
  source <(motionlab completion bash)
  motionlab completion zsh > ~/.zfunc/_motionlab
The package installs both.)");
  command->callback([&app, &chosen] {
    chosen.run = [&app, &chosen](const Terminal& terminal) {
      ChoicesByKind choices;
      for (const TopicDescription& topic : every_topic()) choices["TOPIC"].emplace_back(topic.name);
      terminal.out << (chosen.shell == "bash" ? bash_completion(app, choices) : zsh_completion(app, choices));
      return static_cast<int>(kExitGood);
    };
  });
}

}  // namespace

int run_command_line(int argc, const char* const* argv, const Terminal& terminal,
                     const std::vector<FurtherCommand>& further) {
  Chosen chosen;
  CLI::App app{"The user's hand on a running motionlab-gateway.", "motionlab"};
  app.footer(kFooter);
  app.fallthrough();
  add_common(app, chosen);
  add_status(app, chosen);
  add_topics(app, chosen);
  add_echo(app, chosen);
  add_rate(app, chosen);
  add_delay(app, chosen);
  add_mode_command(app, chosen, topic::ModeAction::engage, "ask the gateway to keep the load still", R"(
Examples:
  motionlab engage --wait 30                  wait until the gateway is ready, then engage)");
  add_mode_command(app, chosen, topic::ModeAction::settle, "bring everything to rest", R"(
Example:
  motionlab settle                            from anywhere, at any time; needs no permission)");
  add_mode_command(app, chosen, topic::ModeAction::reset, "acknowledge a latched fault", R"(
Example:
  motionlab reset                             once the cause of the fault is gone)");
  add_mode_command(app, chosen, topic::ModeAction::authority, "how much the gateway may do once engaged", R"(
Examples:
  motionlab authority shadow                  compute and publish, send nothing
  motionlab authority limited                 at a tenth of the limits
More is granted only while nothing moves: settle first.)");
  add_reference(app, chosen);
  add_score(app, chosen);
  add_record(app, chosen);
  add_verify(app, chosen);
  add_export(app, chosen);
  add_replay(app, chosen);
  add_check(app, chosen);
  for (const FurtherCommand& add : further) add(app, chosen, chosen.run);
  add_completion(app, chosen);
  app.require_subcommand(1);
  try {
    app.parse(argc, argv);
    return chosen.run(terminal);
  } catch (const CLI::RequiredError& error) {
    const std::vector<std::string> unknown = app.remaining();
    if (unknown.empty()) {
      app.exit(error, terminal.out, terminal.err);
    } else {
      std::vector<std::string> names;
      for (const CLI::App* const command : app.get_subcommands([](const CLI::App*) { return true; })) {
        names.push_back(command->get_name());
      }
      terminal.err << "motionlab: there is no " << escaped(unknown.front())
                   << did_you_mean(unknown.front(), names) << " See motionlab --help\n";
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
