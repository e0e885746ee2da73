#include "gateway/doctor/doctor_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "drivers/core/config_path.hpp"
#include "drivers/core/error.hpp"
#include "gateway/doctor/devices.hpp"
#include "gateway/doctor/machine.hpp"
#include "gateway/doctor/network.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"
#include "gateway/service/gateway_config.hpp"

namespace motionlab::doctor {
namespace {

using monitor::Ink;

constexpr std::size_t kSubjectWidth = 20;

void append(Findings& to, Findings more) {
  std::ranges::move(more, std::back_inserter(to));
}

Findings examine(const DoctorCommand& command, const monitor::Connection& connection,
                 const std::atomic<bool>& interrupted) {
  Findings say;
  service::GatewayConfig config;
  try {
    const auto file =
        command.config.empty() ? find_config("lab.toml") : std::filesystem::path(command.config);
    config = service::load_gateway_config(file, {command.overlays.begin(), command.overlays.end()});
    say.push_back({Grade::pass, "configuration", file.string() + " is well-formed", ""});
  } catch (const StartupError& error) {
    return {{Grade::fail, "configuration", error.what(), "motionlab-gateway --check reads it, too"}};
  }
  for (const std::string& note : config.notes) say.push_back({Grade::warn, "configuration", note, ""});
  append(say, judge(look_at_machine(config), config));
  append(say, judge(look_at_network(), config));

  monitor::Connection gateway = connection;
  gateway.domain = config.bus.domain;
  if (gateway.interfaces.empty()) gateway.interfaces = config.bus.interface_whitelist;
  if (gateway.peers.empty() && gateway.server.empty()) {
    gateway.peers = config.bus.peers;
    gateway.server = config.bus.server;
  }
  if (gateway.security.empty()) gateway.security = config.bus.security;
  try {
    const auto status = monitor::hear_status(gateway, interrupted);
    if (status.nobody()) {
      say.push_back({Grade::pass, "gateway", "none runs on domain " + std::to_string(gateway.domain), ""});
      append(say, look_for_devices(config, interrupted));
    } else {
      append(say, judge(status));
    }
  } catch (const StartupError& error) {
    say.push_back({Grade::fail, "DDS", error.what(), ""});
  }
  return say;
}

std::string painted(Grade grade, monitor::Paint paint) {
  const Ink ink = grade == Grade::pass ? Ink::good : grade == Grade::warn ? Ink::caution : Ink::bad;
  return paint(ink, to_string(grade));
}

void print(const Findings& findings, const monitor::Terminal& terminal) {
  const monitor::Paint paint{terminal.colour};
  for (const Finding& finding : findings) {
    std::string subject = finding.subject;
    subject.resize(std::max(subject.size(), kSubjectWidth), ' ');
    terminal.out << painted(finding.grade, paint) << "  " << subject << "  " << monitor::escaped(finding.text)
                 << "\n";
    if (!finding.fix.empty()) {
      terminal.out << std::string(kSubjectWidth + 8, ' ') << "-> " << monitor::escaped(finding.fix) << "\n";
    }
  }
  const auto number = [&](Grade grade) { return std::ranges::count(findings, grade, &Finding::grade); };
  terminal.out << number(Grade::pass) << " passed, " << number(Grade::warn) << " to be looked at, "
               << number(Grade::fail) << " failed\n";
}

nlohmann::ordered_json to_json(const Findings& findings) {
  nlohmann::ordered_json json;
  json["worst"] = to_string(worst(findings));
  json["findings"] = nlohmann::ordered_json::array();
  for (const Finding& finding : findings) {
    json["findings"].push_back({{"grade", to_string(finding.grade)},
                                {"subject", finding.subject},
                                {"text", finding.text},
                                {"fix", finding.fix}});
  }
  return json;
}

}  // namespace

int run_doctor(const DoctorCommand& command, const monitor::Connection& connection, bool json,
               const monitor::Terminal& terminal) {
  const Findings findings = examine(command, connection, terminal.interrupted);
  if (terminal.interrupted) return monitor::kExitInterrupted;
  if (json) {
    terminal.out << monitor::json_text(to_json(findings));
  } else {
    print(findings, terminal);
  }
  return worst(findings) == Grade::fail ? monitor::kExitWrong : monitor::kExitGood;
}

monitor::FurtherCommand doctor_command() {
  return [](CLI::App& app, const monitor::Common& common, monitor::Run& run) {
    CLI::App* const command =
        app.add_subcommand("doctor", "is everything as the gateway needs it: machine, network, devices");
    const auto chosen = std::make_shared<DoctorCommand>();
    command
        ->add_option("--config", chosen->config,
                     "lab.toml; default: found in deploy/config or /etc/motionlab")
        ->type_name("FILE");
    command
        ->add_option("--overlay", chosen->overlays,
                     "laid over the configuration, in order; e.g. loopback.toml")
        ->type_name("FILE");
    command->footer(R"(
Examples:
  motionlab doctor                            on the gateway's machine, with its configuration
  motionlab doctor --json | jq '.findings[] | select(.grade != "pass")'
The domain is the configuration's. Nothing is changed and nothing is sent to any device. Ends with 1 when something
fails, with 0 otherwise; what is only to be looked at is no failure.)");
    command->callback([chosen, &common, &run] {
      run = [chosen, &common](const monitor::Terminal& terminal) {
        return run_doctor(*chosen, common.connection, common.json, terminal);
      };
    });
  };
}

}  // namespace motionlab::doctor
