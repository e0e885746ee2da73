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
#include "drivers/mru/mru_wire.hpp"

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
  Endpoint to{};    ///< where the datagrams go
  Layout layout{};  ///< variables and token; its limits are not used
  ChecksumRule checksum_rule = ChecksumRule::ones_complement;
  double period_s = 0.005;  ///< how often `measure` is called; for faults that count in periods
  double output_latency_s =
      0.005;                     ///< from measurement to departure (assumption; not published by the maker)
  double output_jitter_s = 0.0;  ///< added, uniform in [0, jitter)
  double settling_s = 0.0;       ///< after the first measurement the header says `Q` for so long
  std::uint32_t system_time_start_ms = 0;  ///< SystemTime of the first measurement
  double clock_drift_ppm = 0.0;            ///< how much faster than laboratory time the unit's clock runs
  std::uint64_t seed = 1;
  std::string name = "mru1";  ///< makes the random stream its own
};

/// A simulated unit. `measure` is called whenever the world has sampled a reading, `step` about every
/// millisecond.
///
/// SystemTime is the time since the first measurement on the unit's own (drifting) clock, cut to whole
/// milliseconds and sent modulo 2^32. Nothing leaves before the first measurement.
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

  /// Switches a fault on or off. `value` where the fault takes one, 0 for its default:
  ///   silent · unstable (header Q) · truncate (bytes cut off, 1) · oversize (bytes added, 1) · corrupt (one
  ///   bit flipped, in this share of the datagrams, 1) · repeat (each is sent twice) · freeze_time
  ///   (SystemTime stands) · nan (roll is NaN) · wrong_token · loss (share that is lost, 0.1) · late (seconds
  ///   added, 0.05) · reorder (every second one leaves 1.5 periods later) · restart (once, on switching on:
  ///   SystemTime and settling begin anew)
  /// @returns refused, with the list of names, for a name that is not known.
  Status set_fault(std::string_view name, bool active, double value = 0.0);

  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_; }
  /// Datagrams that the transport refused.
  [[nodiscard]] std::uint64_t send_faults() const noexcept { return send_faults_; }

 private:
  struct Faults {
    bool silent = false, unstable = false, repeat = false, freeze_time = false, nan = false,
         wrong_token = false, reorder = false;
    std::size_t truncate_bytes = 0, oversize_bytes = 0;
    double corrupt_share = 0.0, loss_share = 0.0, late_s = 0.0;
  };
  struct Waiting {
    LabTime t_due{};
    std::uint64_t order = 0;
    std::size_t size = 0;
    std::array<std::uint8_t, kMaxDatagram + 64> bytes{};
  };

  [[nodiscard]] Frame frame_of(const Reading& reading, LabTime t_measured);
  [[nodiscard]] std::uint32_t system_time_ms(LabTime t_measured);
  void enqueue(const Waiting& waiting);

  DeviceConfig config_;
  DatagramOut& out_;
  Random random_;
  Faults faults_;
  std::vector<Waiting> waiting_;
  std::optional<LabTime> t_first_;
  std::uint32_t last_system_time_ms_ = 0;
  Nanoseconds clock_jump_{0};
  std::uint64_t measured_ = 0;
  std::uint64_t sent_ = 0;
  std::uint64_t send_faults_ = 0;
};

}  // namespace motionlab::mru
