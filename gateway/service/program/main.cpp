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
#include <vector>

#include "drivers/core/config_path.hpp"
#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"
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

int serve(const service::GatewayConfig& config) {
  const sigset_t signals = block_signals();
  RealClock clock;
  service::Gateway gateway(config, clock);
  for (const auto& note : config.notes) spdlog::warn("{}", note);
  for (const auto& refused : gateway.start()) spdlog::warn("{}", refused);
  spdlog::info("running\n{}", service::wiring(config));
  if (const auto file = gateway.recording()) spdlog::info("recording to {}", file->string());
  sd_notify(0, "READY=1");

  LinkLog links;
  std::optional<std::string> trouble;
  LabTime next_look = clock.now();
  for (;;) {
    constexpr timespec kPoll{0, 100'000'000};
    if (sigtimedwait(&signals, nullptr, &kPoll) > 0) break;
    gateway.drain_events(log_event);
    links.look(gateway);
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
    return serve(config);
  } catch (const StartupError& error) {
    std::cerr << "motionlab-gateway: " << error.what() << '\n';
    return 2;
  }
}
