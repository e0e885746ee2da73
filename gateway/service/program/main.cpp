/// @file  motionlab-gateway: the service between the laboratory's devices and a controller.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "drivers/core/config_path.hpp"
#include "drivers/core/error.hpp"
#include "gateway/deadman/deadman.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/log/log.hpp"
#include "gateway/service/nftables.hpp"
#include "gateway/service/program/house.hpp"
#include "gateway/service/program/settle.hpp"
#include "gateway/service/wiring.hpp"

namespace {

using namespace motionlab;

struct Options {
  std::string config;
  std::vector<std::string> overlays;
  bool check = false;
  bool settle = false;
  bool nftables = false;
};

service::GatewayConfig read_config(const Options& options) {
  const auto file = options.config.empty() ? find_config("lab.toml") : std::filesystem::path(options.config);
  return service::load_gateway_config(file, {options.overlays.begin(), options.overlays.end()});
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
  app.add_flag("--nftables", options.nftables,
               "print firewall rules that admit exactly the configured peers, for nft -f, exit");
  CLI11_PARSE(app, argc, argv);
  service::open_log();
  try {
    const auto config = read_config(options);
    if (options.check) {
      std::cout << service::wiring_drawing(config) << "\nwiring\n"
                << service::wiring(config) << "\neffective configuration\n"
                << config.effective;
      return 0;
    }
    if (options.nftables) {
      std::cout << service::nftables_rules(config, service::interface_addresses());
      return 0;
    }
    if (options.settle) return service::settle(config);
    // First of all: before any thread, any socket, and DDS.
    const auto lifeline = deadman::fork_deadman(
        {.wires = service::wires(config),
         .io_silent_after = from_seconds(config.deadman.heartbeat_s),
         .control_silent_after = from_seconds(config.deadman.control_s)},
        [](const std::string& said) {
          service::say(service::LogLevel::warning, "deadman", "deadman", "deadman: " + said);
        });
    service::House house(
        config, [&options] { return read_config(options); }, *lifeline);
    house.run();
    return 0;
  } catch (const StartupError& error) {
    std::cerr << "motionlab-gateway: " << error.what() << '\n';
    return 2;
  }
}
