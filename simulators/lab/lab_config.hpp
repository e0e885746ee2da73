/// @file  The simulated laboratory's configuration: world.toml.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/endpoint.hpp"
#include "drivers/core/toml_reader.hpp"
#include "simulators/comau/comau_device.hpp"
#include "simulators/lab/fault_plan.hpp"
#include "simulators/mru/mru_device.hpp"
#include "simulators/plant/platform_limits.hpp"
#include "simulators/plant/sea.hpp"
#include "simulators/plant/world_config.hpp"
#include "simulators/plc_reply/plc_reply_device.hpp"
#include "simulators/qualisys/qualisys_device.hpp"
#include "simulators/winch/winch_device.hpp"

namespace motionlab::lab {

/// Names of the devices, as on the topics.
inline constexpr std::string_view kMru1 = "mru1";
inline constexpr std::string_view kMru2 = "mru2";
inline constexpr std::string_view kQualisys = "qualisys";
inline constexpr std::string_view kArm = "arm";
inline constexpr std::string_view kWinch = "winch";
/// The PLC's remote interface, where it is served.
inline constexpr std::string_view kPlc = "plc";
/// In their place where a fault belongs to no device.
inline constexpr std::string_view kWorld = "world";

/// Names of the rigid bodies in the camera system.
inline constexpr std::string_view kLoadBody = "load";
inline constexpr std::string_view kPlatformBody = "platform";

struct LabConfig {
  LabConfig();

  plant::WorldConfig world;
  plant::Scenario scenario;
  std::uint64_t seed = 1;

  /// How a random sea shall differ from the one that its name stands for.
  struct SeaWish {
    std::optional<double> significant_height_m, peak_period_s, peak_enhancement;
    std::optional<plant::WaveDirection> direction;
  };
  SeaWish sea;
  double second_ship_height_m = 0.25;  ///< significant height of its random seas

  /// One simulated unit: where its datagrams come from, and the rest. Period and latency come from the world.
  struct Mru {
    Endpoint from;
    mru::DeviceConfig device;
  };
  Mru mru1, mru2;
  Endpoint qualisys_listen;
  std::optional<Endpoint> qualisys_big_endian_listen;  ///< empty: that port is not served
  std::optional<Endpoint> qualisys_discovery_listen;   ///< likewise
  double hook_marker_spacing_m = 0.062;                ///< of two markers at the hook; 0: there are none
  qualisys::DeviceConfig qualisys;                     ///< rate, latency and bodies come from the world
  Endpoint arm_listen;
  comau::DeviceConfig arm;
  Endpoint winch_listen;
  winch::DeviceConfig winch;
  bool plc_reply_enabled = false;  ///< false: nobody listens there
  Endpoint plc_reply_listen;
  plc_reply::DeviceConfig plc_reply;

  std::vector<PlannedFault> faults;  ///< of every run, before those of the command line

  int bus_domain = 42;
  std::vector<std::string> bus_interfaces{"127.0.0.1"};

  /// Reads a file with others laid over it, then texts. What is absent keeps its default.
  /// @throws StartupError with file, line, column and advice: unknown key, wrong kind, out of range
  static LabConfig load(const std::filesystem::path& file,
                        const std::vector<std::filesystem::path>& overlays = {},
                        const std::vector<TomlText>& texts = {});

  /// A scenario by name, a random sea as `sea` wishes it; or `csv:FILE`, a recording (see read_motion_csv).
  /// @throws StartupError that lists the names, or says what is wrong in the file
  void set_scenario(std::string_view name);
  /// How EM1500 moves, a random sea as high as `second_ship_height_m` and drawn apart from the first ship's.
  /// @throws StartupError that lists the names
  void set_second_ship(std::string_view name);
  /// @throws StartupError when the ship's motion of the next `seconds` is more than the platform can do:
  /// which limit is exceeded by how much, and what would fit
  void refuse_beyond(const plant::PlatformLimits& limits, double seconds) const;
  void set_platform_tracked(bool tracked) { world.camera.platform_tracked = tracked; }
  void use_perfect_sensors() { world = world.with_perfect_sensors(); }
  void use_belief_as_world() { world = world.as_believed(); }
};

}  // namespace motionlab::lab
