/// @file  The gateway's whole configuration as one value, read from lab.toml and its overlays.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "drivers/comau/comau_driver.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/toml_reader.hpp"
#include "drivers/mru/mru_driver.hpp"
#include "drivers/plc_reply/plc_reply_driver.hpp"
#include "drivers/qualisys/qualisys_driver.hpp"
#include "drivers/winch/winch_driver.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/controller/guard.hpp"
#include "gateway/controller/load_keeper.hpp"
#include "gateway/estimator/belief.hpp"
#include "idl/mode.hpp"

namespace motionlab::service {

/// How fresh one device has to be, and whether the gateway can be engaged without it.
struct LinkRule {
  double stale_after_s = 0.025;  ///< since the arrival of the newest sample
  bool required = false;
};

struct MruLink {
  Endpoint listen;
  mru::DriverConfig driver;
  LinkRule rule;
};

struct QualisysLink {
  Endpoint server;
  Endpoint listen;
  std::string load_body;
  std::string platform_body;
  double coast_s =
      3.0;  ///< the load may be unseen for this long; then horizontal compensation is taken back …
  double rest_by_s = 10.0;  ///< … until this, and the gateway rests
  qualisys::DriverConfig driver;
  LinkRule rule;
};

struct ComauLink {
  Endpoint listen;
  comau::DriverConfig driver;
  /// After so long without a command the robot computer brakes by itself; nothing: it has no watchdog.
  std::optional<double> watchdog_s;
  LinkRule rule;
};

struct WinchLink {
  Endpoint plc;
  winch::DriverConfig driver;
  LinkRule rule;
};

/// The PLC's remote reply: told on the bus, used by nothing that moves.
struct PlcReplyLink {
  Endpoint listen;
  plc_reply::DriverConfig driver;
  LinkRule rule;
};

/// What is written down of the control thread, see gateway/record.
struct RecordRule {
  std::string inputs;               ///< the file; empty: nothing is written
  std::uint32_t outputs_every = 1;  ///< of what is published, every so many steps are kept
  int zstd_level = 3;               ///< 0: not compressed
};

/// How long a thread of the gateway may be silent before the deadman ends the gateway.
struct DeadmanRule {
  double heartbeat_s = 0.020;  ///< the io thread, which steps the drivers
  double control_s = 0.200;    ///< the control thread; meanwhile the driver brakes the arm by itself
};

/// Which controller moves the crane.
enum class ControlLaw {
  ours,      ///< keeps the load still in the world (LoadKeeper)
  integral,  ///< the thesis' integral controller (ThesisKeeper), to compare with
};

/// What has to be there before the gateway may be engaged, and while it is.
struct ModeRules {
  std::vector<std::string> to_engage;  ///< devices that must be fresh
  std::vector<std::string> engaged;    ///< devices whose silence ends a motion at once
  double cross_check_tilt_deg = 1.0;   ///< mru1 against the cameras' body on the platform
  double cross_check_load_m = 0.4;     ///< the load seen against the tool's plumb line
};

/// What the log tells.
enum class LogLevel { info, warning, error };

struct GatewayConfig {
  double control_period_s = 0.001;
  int control_cpu = -1;  ///< the processor that the control thread has; -1: any. Likewise the io thread
  int io_cpu = -1;
  bool control_awake = false;  ///< control's processor never sleeps between two steps, and costs its power
  topic::Authority authority = topic::Authority::full;
  bus::DdsConfig bus;
  std::vector<MruLink> mrus;  ///< the first on the crane's ship, the last on the second ship
  QualisysLink qualisys;
  ComauLink comau;
  WinchLink winch;
  std::optional<PlcReplyLink> plc_reply;  ///< nothing: the PLC is not asked
  DeadmanRule deadman;
  estimator::Belief belief;
  ControlLaw law = ControlLaw::ours;
  controller::LoadKeeperConfig keeper;
  controller::GuardLimits limits;
  ModeRules modes;
  RecordRule record;
  std::array<double, 3> p_world_load_reference_m{};
  /// Which limits the ship's platform keeps: "plc", the laboratory's operating limits, or "mechanical". Seas
  /// are checked against them before they are run.
  std::string platform_limits = "plc";
  std::vector<std::string>
      absent;  ///< devices that are known not to be there; the service does not wait for them
  LogLevel log_level = LogLevel::info;
  std::string effective;           ///< the merged text
  std::vector<std::string> notes;  ///< what a reader of the log should know about it

  /// Whether the cameras see a body on the platform, or the load alone.
  void set_platform_tracked(bool tracked);
};

/// Reads and checks; texts are laid over the files. @throws StartupError with file, line, column and what to
/// write instead
GatewayConfig load_gateway_config(const std::filesystem::path& file,
                                  const std::vector<std::filesystem::path>& overlays = {},
                                  const std::vector<TomlText>& texts = {});

/// Reads one whole text, such as the effective configuration of a recording. @throws StartupError likewise
GatewayConfig parse_gateway_config(const TomlText& text);

}  // namespace motionlab::service
