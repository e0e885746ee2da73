/// @file  motionlab-console: the page, and the bridge for Foxglove clients.

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <systemd/sd-daemon.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "drivers/core/config_path.hpp"
#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"
#include "gateway/console/console.hpp"
#include "gateway/console/program/lab_json.hpp"
#include "gateway/console/token.hpp"
#include "gateway/service/gateway_config.hpp"

namespace {

using namespace motionlab;

constexpr const char* kFooter = R"(
Examples:
  motionlab-console --overlay loopback.toml      look at a laboratory on this machine: http://127.0.0.1:8080/
  motionlab-console --control                    engage, reset, authority, reference for who has the printed token
  motionlab-console --listen 192.168.90.70:8080  for the tablets of the laboratory's network, to look at only

Foxglove and Lichtblick connect to the same address, ws://127.0.0.1:8080 ("Foxglove WebSocket").
Settle is always on the page, and `curl -X POST http://127.0.0.1:8080/settle`.)";

struct Options {
  std::string listen = "127.0.0.1:8080";
  std::string config;
  std::vector<std::string> overlays;
  bool control = false;
  std::string token_file;
  std::vector<std::string> host_names, origins;
};

std::string own_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "localhost";
}

bool is_loopback(const Endpoint& endpoint) {
  return (endpoint.address >> 24) == 127;
}

/// The token for control, from its file, or a new one that is printed where only the user sees it.
std::string token_for(const Options& options, const Endpoint& listen) {
  if (!options.control) {
    if (!options.token_file.empty())
      throw StartupError{"--token-file is for --control; say both, or neither"};
    return {};
  }
  if (!options.token_file.empty()) return console::read_token(options.token_file);
  if (!is_loopback(listen)) {
    throw StartupError{
        "control from other machines needs a token of yours: --token-file, or --listen 127.0.0.1:8080"};
  }
  if (isatty(STDOUT_FILENO) != 1) {
    throw StartupError{
        "there is no terminal to print the token on, and it shall not stand in a log: give --token-file"};
  }
  return console::make_token();
}

void serve(const Options& options) {
  const auto file = options.config.empty() ? find_config("lab.toml") : std::filesystem::path(options.config);
  const auto lab = service::load_gateway_config(file, {options.overlays.begin(), options.overlays.end()});
  console::ConsoleConfig config;
  config.listen = Endpoint::parse(options.listen);
  config.dds = lab.bus;
  config.dds.participant = "motionlab-console";
  config.dds.join_truth = true;
  config.control = options.control;
  config.token = token_for(options, config.listen);
  config.neighbours = {options.host_names, options.origins};
  config.neighbours.host_names.push_back(own_name());
  config.neighbours.host_names.push_back(own_name() + ".local");
  config.requester = "console@" + own_name();
  console::Assets assets{console::find_page()};
  assets.add("/config.json", "application/json", console::lab_json(lab, options.control));

  RealClock clock;
  console::Console console{config, std::move(assets), clock};
  std::cout << "motionlab-console: http://" << to_string(console.endpoint()) << "/\n";
  if (options.control && options.token_file.empty()) std::cout << "control token: " << config.token << "\n";
  std::cout << std::flush;
  if (!is_loopback(config.listen)) {
    spdlog::warn("whoever reaches {} can look on, and settle", to_string(console.endpoint()));
    if (options.control) spdlog::warn("the token travels unencrypted: use this in a network that you trust");
  }
  sd_notify(0, "READY=1");
  console.run([](const std::string& status) { sd_notifyf(0, "WATCHDOG=1\nSTATUS=%s", status.c_str()); });
  sd_notify(0, "STOPPING=1");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "A live page of the laboratory for browsers, and a bridge for Foxglove clients. Looks on; moves "
      "nothing "
      "unless it is started with --control."};
  app.footer(kFooter);
  app.add_option("--listen", options.listen,
                 "address:port to serve on (127.0.0.1:8080); port 0: any that is free");
  app.add_option("--config", options.config, "lab.toml; default: found in deploy/config or /etc/motionlab");
  app.add_option("--overlay", options.overlays, "laid over the configuration, in order; e.g. loopback.toml");
  app.add_flag("--control", options.control,
               "whoever shows the token may engage, reset, set authority and reference");
  app.add_option("--token-file", options.token_file, "the token for --control, in a file of mode 0600");
  app.add_option("--host-name", options.host_names, "another name of this machine that browsers may use");
  app.add_option("--allow-origin", options.origins,
                 "a page from elsewhere that may look on, e.g. https://app.foxglove.dev");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 64;
  }
  spdlog::set_default_logger(spdlog::stderr_color_mt("motionlab-console"));
  spdlog::set_pattern("%Y-%m-%d %H:%M:%S.%e %^%l%$ %v");
  try {
    serve(options);
    return 0;
  } catch (const StartupError& error) {
    std::cerr << "motionlab-console: " << error.what() << '\n';
    return 2;
  }
}
