/// @file  The other end of an MRU's wire: a simulated unit that turns readings into datagrams, faults
/// included.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/endpoint.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/random.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"
#include "drivers/mru/mru_wire_formats.hpp"
#include "simulators/faults/common_faults.hpp"

namespace motionlab::mru {

/// What the unit measures at one instant, after its own filters; SI. Frames: body = the unit's axes (forward,
/// starboard, down); heading = horizontal, turned with the heading; origin = the platform's origin.
struct Reading {
  std::array<double, 3> euler_heading_mru_rad{};  ///< roll, pitch, yaw
  std::array<double, 3> omega_mru_radps{};        ///< body
  double omega_down_radps = 0.0;
  std::array<double, 3> v_mru_mps{};              ///< at the unit, body
  std::array<double, 3> a_mru_mps2{};             ///< at the unit, body, gravity removed
  std::array<double, 3> p_heading_origin_m{};     ///< high-passed; forward, starboard, down
  std::array<double, 3> v_heading_origin_mps{};   ///< high-passed
  std::array<double, 3> a_heading_origin_mps2{};  ///< not filtered
  double sensor_temperature_degc = 31.5;
};

struct DeviceConfig {
  Endpoint to{};  ///< where the datagrams go
  Format format = Format::mrubin;
  Layout layout{};  ///< variables and token of MRUBIN and NMEAP; its limits are not used
  ChecksumRule checksum_rule = ChecksumRule::ones_complement;  ///< of MRUBIN
  double output_latency_s =
      0.005;                     ///< from measurement to departure (assumption; not published by the maker)
  double output_jitter_s = 0.0;  ///< added, uniform in [0, jitter)
  double settling_s = 0.0;       ///< after the first measurement the unit says for so long that it settles
  std::uint32_t system_time_start_ms = 0;  ///< SystemTime of the first measurement
  double clock_drift_ppm = 0.0;            ///< how much faster than laboratory time the unit's clock runs
  std::uint64_t seed = 1;
  std::string name = "mru1";  ///< makes the random stream its own
};

/// A simulated unit. `measure` is called whenever the world has sampled a reading, `step` about every
/// millisecond.
///
/// The unit's own clock drifts. SystemTime (MRUBIN, NMEAP) is the time since the first measurement on it, cut
/// to whole milliseconds and sent modulo 2^32; the formats with UTC begin at laboratory time. Nothing leaves
/// before the first measurement.
class MruDevice {
 public:
  MruDevice(DeviceConfig config, DatagramOut& out);

  void measure(const Reading& reading, LabTime t_measured);
  /// Sends what is due, oldest first.
  void step(LabTime now);
  /// From now on the unit's own clock shows so much more; 0: right again.
  void set_clock_jump(Nanoseconds jump) noexcept { clock_jump_ = jump; }
  /// When the next datagram is due; nothing when none waits.
  [[nodiscard]] std::optional<LabTime> next_send() const noexcept;

  /// Switches a fault on or off. Besides the common ones:
  ///   silent (its output alone; the clock runs on) · unstable (it says that it settles, or that its attitude
  ///   is invalid) · reduced (it says so) · freeze_time (its time stands) · nan (roll is no number, or as
  ///   near to that as the format comes) · wrong_token · bad_checksum · oversize (bytes added, `value` or 1)
  ///   · restart (once, on switching on: SystemTime and settling begin anew)
  /// @returns refused: with the list of names for one that is not known; with the reason when the format has
  ///          no status, time, token or checksum that could be false
  Status set_fault(std::string_view name, bool active, double value = 0.0);
  /// Every name that `set_fault` knows, separated by blanks.
  [[nodiscard]] static std::string_view fault_names() noexcept;

  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_; }
  /// Datagrams that the transport refused.
  [[nodiscard]] std::uint64_t send_faults() const noexcept { return send_faults_; }

 private:
  static constexpr std::size_t kMaxExtraBytes = 64;

  struct Faults {
    bool silent = false, unstable = false, reduced = false, freeze_time = false, nan = false,
         wrong_token = false, bad_checksum = false;
    std::size_t oversize_bytes = 0;
  };
  struct Waiting {
    LabTime t_due{};
    std::size_t size = 0;
    std::array<std::uint8_t, kRoomForAny + kMaxExtraBytes> bytes{};
  };

  [[nodiscard]] Motion motion_of(const Reading& reading, LabTime t_measured);
  [[nodiscard]] Nanoseconds unit_time(LabTime t_measured);
  [[nodiscard]] bool can_have(std::string_view fault) const noexcept;
  void spoil(Waiting& waiting);
  void enqueue(const Waiting& waiting);

  DeviceConfig config_;
  DatagramOut& out_;
  Random jitter_, garbage_;
  faults::CommonFaults common_;
  Faults faults_;
  std::vector<Waiting> waiting_;
  std::optional<LabTime> t_first_;
  Nanoseconds clock_jump_{0};
  std::optional<Reading> stuck_at_;
  Nanoseconds t_unit_{0};
  std::uint64_t measured_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t send_faults_ = 0;
};

}  // namespace motionlab::mru
