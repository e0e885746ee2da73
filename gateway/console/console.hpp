/// @file  `Console`: the web server between DDS and browsers.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "drivers/core/endpoint.hpp"
#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/console/assets.hpp"
#include "gateway/console/http.hpp"

namespace motionlab::console {

struct ConsoleConfig {
  Endpoint listen{0x7F000001, 8080};  ///< port 0: the system chooses
  bus::DdsConfig dds;                 ///< with join_truth: the simulated truth is shown where there is one
  bool control = false;               ///< whether a client with the token may ask for more than rest
  std::string token;                  ///< needed for control
  Neighbours neighbours;
  std::string requester;  ///< who asks, for the gateway's log
};

/// One thread, the caller's: every 10 ms it takes what has arrived and hands it to the clients. Everything is
/// bounded: connections, requests, what waits for a client.
class Console {
 public:
  /// @throws StartupError  the address is in use or not ours; as DdsBus
  Console(ConsoleConfig config, Assets assets, RealClock& clock);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  /// Where it listens, with the port that was chosen.
  [[nodiscard]] Endpoint endpoint() const;

  /// Serves until SIGINT or SIGTERM. @param alive  called about once a second
  void run(const std::function<void(const std::string& status)>& alive);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::console
