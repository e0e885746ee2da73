/// @file  The house thread: signals, log, service manager, configuration while the gateway runs.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "drivers/core/real_clock.hpp"
#include "gateway/service/gateway.hpp"
#include "gateway/service/live_settings.hpp"
#include "gateway/service/program/service_manager.hpp"
#include "gateway/service/roll_call.hpp"
#include "gateway/service/rounds.hpp"

namespace motionlab::service {

/// Runs the gateway on the calling thread until SIGTERM or SIGINT, then brings arm and winch to rest.
///
/// Ready means: every required device is connected or its absence is declared. SIGHUP reads the configuration
/// again. The watchdog is stroked only when io, control and bus have each come round since the last stroke.
class House {
 public:
  /// @param read_again  the configuration as its files are now; throws StartupError
  /// @param lifeline  to the deadman; outlives this
  /// @throws StartupError when a socket or DDS cannot be opened
  House(const GatewayConfig& config, std::function<GatewayConfig()> read_again, deadman::Lifeline& lifeline);

  void run();

 private:
  void look_at_links();
  void look_at_threads(LabTime now);
  void look_at_deadman_and_recording();
  void tell_status();
  void reload();
  void settle();

  std::function<GatewayConfig()> read_again_;
  LiveSettings settings_;
  RealClock clock_;
  Gateway gateway_;
  ServiceManager manager_;
  RoundsCheck rounds_;
  LabTime next_stroke_ = LabTime::min();
  std::string silent_told_;
  bool deadman_lost_told_ = false;
  std::string recording_trouble_told_;
  std::map<std::string, std::string> link_told_;  ///< by device
  std::string waiting_told_;
  std::string reload_note_;  ///< what the last reload refused
  bool ready_ = false;
};

}  // namespace motionlab::service
