/// @file  motionlab-gateway: the service. This thread is the house: configuration, log, service manager.

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "drivers/core/config_path.hpp"
#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"
#include "gateway/deadman/deadman.hpp"
#include "gateway/deadman/settlement.hpp"
#include "gateway/service/gateway.hpp"
#include "gateway/service/gateway_config.hpp"

namespace {

using namespace motionlab;

/// How long arm and winch may take to come to rest at the end.
constexpr Nanoseconds kStopPatience = 8s;

struct Options {
  std::string config;
  std::vector<std::string> overlays;
  bool check = false;
  bool settle = false;
};

/// Blocks the signals that end the service, for this thread and all that it starts, so that they can be
/// waited for.
sigset_t block_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return signals;
}

void log_event(const topic::Event& event) {
  const auto level = event.severity == topic::Severity::info      ? spdlog::level::info
                     : event.severity == topic::Severity::warning ? spdlog::level::warn
                                                                  : spdlog::level::err;
  spdlog::log(level, "{} {}: {}", event.source.view(), event.code.view(), event.text.view());
}

/// Says it once when a device's link changes, with the advice.
class LinkLog {
 public:
  void look(const service::Gateway& gateway) {
    gateway.for_each_health([this](const topic::Health& health) {
      const std::string now = std::string(to_string(health.link)) +
                              (health.advice.empty() ? std::string() : ": " + health.advice.str());
      std::string& last = last_[health.device.str()];
      if (now == last) return;
      last = now;
      const bool fine = health.link == topic::LinkState::up && health.advice.empty();
      spdlog::log(fine ? spdlog::level::info : spdlog::level::warn, "{} {}", health.device.view(), now);
    });
  }

 private:
  std::map<std::string, std::string> last_;
};

deadman::WireConfig wires(const service::GatewayConfig& config) {
  return {.listen = config.comau.listen,
          .arm = config.comau.driver,
          .robot_brakes_after_s = config.comau.watchdog_s,
          .plc = config.winch.plc,
          .winch = config.winch.driver};
}

/// The second line: the gateway is gone, and perhaps its deadman with it. What is not at rest is told.
int settle(const service::GatewayConfig& config) {
  const deadman::WireConfig where = wires(config);
  const RealClock clock;
  deadman::Settlement settlement(where, clock);
  try {
    settlement.open(where.listen);
  } catch (const StartupError& error) {
    throw StartupError(
        std::string(error.what()) +
        ". If a gateway of this configuration is running, settle it with: motionlab settle; if "
        "one has just died, its deadman is at work: try again in some seconds");
  }
  settlement.begin(std::nullopt);
  const deadman::Outcome outcome = settlement.finish();
  spdlog::log(outcome.settled() ? spdlog::level::info : spdlog::level::err, "{}", outcome.text(where));
  return outcome.settled() ? 0 : 1;
}

int serve(const service::GatewayConfig& config) {
  // First of all: before any thread, any socket, and DDS.
  const auto lifeline =
      deadman::fork_deadman({.wires = wires(config),
                             .io_silent_after = from_seconds(config.deadman.heartbeat_s),
                             .control_silent_after = from_seconds(config.deadman.control_s)},
                            [](const std::string& said) { spdlog::warn("deadman: {}", said); });
  const sigset_t signals = block_signals();
  RealClock clock;
  service::Gateway gateway(config, clock, *lifeline);
  for (const auto& note : config.notes) spdlog::warn("{}", note);
  for (const auto& refused : gateway.start()) spdlog::warn("{}", refused);
  spdlog::info("running\n{}", service::wiring(config));
  if (const auto file = gateway.recording()) spdlog::info("recording to {}", file->string());
  sd_notify(0, "READY=1");

  LinkLog links;
  std::optional<std::string> trouble;
  LabTime next_look = clock.now();
  bool said_lost = false;
  for (;;) {
    constexpr timespec kPoll{0, 100'000'000};
    if (sigtimedwait(&signals, nullptr, &kPoll) > 0) break;
    gateway.drain_events(log_event);
    links.look(gateway);
    if (gateway.deadman_lost() && !std::exchange(said_lost, true)) {
      spdlog::error(
          "the deadman process is gone or stands still: nothing may move until the gateway is restarted");
    }
    if (clock.now() < next_look) continue;
    next_look = clock.now() + 1s;
    clock.discipline();
    if (const auto now = gateway.recording_trouble(); now && now != trouble) {
      trouble = now;
      spdlog::error("{}", *trouble);
    }
    const topic::Mode mode = gateway.mode();
    sd_notifyf(0, "STATUS=%s: %s", std::string(to_string(mode.state)).c_str(), mode.reason.str().c_str());
  }
  sd_notify(0, "STOPPING=1");
  spdlog::info("settling");
  const bool at_rest = gateway.stop(kStopPatience);
  gateway.drain_events(log_event);
  if (at_rest) {
    spdlog::info("arm and winch were told to rest; {} control periods were missed", gateway.missed_beats());
  } else {
    spdlog::warn("a device did not come to rest or did not answer; look at the arm before you go near it");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "The service between the laboratory's devices and a controller. Nothing moves before it is asked to: "
      "see "
      "motionlab engage."};
  app.add_option("--config", options.config, "lab.toml; default: found in deploy/config or /etc/motionlab");
  app.add_option("--overlay", options.overlays, "laid over the configuration, in order; e.g. loopback.toml");
  app.add_flag("--check", options.check, "read and check the configuration, print the wiring, exit");
  app.add_flag("--settle", options.settle,
               "no gateway is running: bring arm and winch to rest by the configuration, exit");
  CLI11_PARSE(app, argc, argv);
  spdlog::set_default_logger(spdlog::stderr_color_mt("motionlab-gateway"));
  spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
  try {
    const auto file =
        options.config.empty() ? find_config("lab.toml") : std::filesystem::path(options.config);
    const auto config =
        service::load_gateway_config(file, {options.overlays.begin(), options.overlays.end()});
    if (options.check) {
      std::cout << "wiring\n" << service::wiring(config) << "\neffective configuration\n" << config.effective;
      return 0;
    }
    return options.settle ? settle(config) : serve(config);
  } catch (const StartupError& error) {
    std::cerr << "motionlab-gateway: " << error.what() << '\n';
    return 2;
  }
}
