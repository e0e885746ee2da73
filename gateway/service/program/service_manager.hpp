/// @file  What the service tells systemd. Without systemd it is told nothing, and nothing changes.
#pragma once

#include <string>

#include "drivers/core/time.hpp"

namespace motionlab::service {

class ServiceManager {
 public:
  ServiceManager();

  /// How long systemd waits for a stroke before it kills us; zero when it does not watch us.
  [[nodiscard]] Nanoseconds watchdog() const { return watchdog_; }

  /// Not ready yet, for this reason; do not give up on us within `patience`.
  void waiting(const std::string& status, Nanoseconds patience) const;
  void ready() const;
  void status(const std::string& status) const;
  void stroke() const;
  /// Reading the configuration again; ends with `ready`.
  void reloading() const;
  void stopping() const;

 private:
  Nanoseconds watchdog_{0};
};

}  // namespace motionlab::service
