/// @file  motionlab-controller: the controller of the house on another host than the drivers.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "drivers/core/config_path.hpp"
#include "drivers/core/error.hpp"
#include "gateway/service/controller_program/seat.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/log/log.hpp"

namespace {

using namespace motionlab;

std::string own_name() {
  std::array<char, 24> host{};
  return "controller@" + std::string(gethostname(host.data(), host.size() - 1) == 0 ? host.data() : "");
}

}  // namespace

int main(int argc, char** argv) {
  std::string config, name = own_name();
  std::vector<std::string> overlays;
  bool engage = false;
  CLI::App app{
      "Estimator and controller on another host than the gateway with the drivers. It hears by DDS what they "
      "measure and commands as an external controller; modes, guard and deadman stay where the drivers are. "
      "Ends with 1 when the gateway lets it go, and never engages a second time."};
  app.add_option("--config", config,
                 "the gateway's lab.toml; default: found in deploy/config or /etc/motionlab");
  app.add_option("--overlay", overlays, "laid over the configuration, in order: [bus] of this host");
  app.add_option("--name", name, "as which it commands (" + name + ")")->check([](const std::string& wanted) {
    return wanted.empty() || wanted.size() > Text<32>::kCapacity ? std::string{"a name has 1 to 32 letters"}
                                                                 : "";
  });
  app.add_flag("--engage", engage,
               "ask to be engaged as soon as the gateway is ready; else it only says what it would do");
  CLI11_PARSE(app, argc, argv);
  service::open_log();
  try {
    const auto file = config.empty() ? find_config("lab.toml") : std::filesystem::path(config);
    auto gateway = service::load_gateway_config(file, {overlays.begin(), overlays.end()});
    gateway.bus.participant = "motionlab-controller";
    service::Seat seat(gateway, Text<32>{name});
    return seat.run(engage) ? 0 : 1;
  } catch (const StartupError& error) {
    std::cerr << "motionlab-controller: " << error.what() << '\n';
    return 2;
  }
}
