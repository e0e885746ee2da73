/// @file  Listens to one motion reference unit and tells what it says, raw, on the laboratory's time line.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/core/bytes.hpp"
#include "drivers/core/device_clock.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/link_health.hpp"
#include "drivers/core/sink.hpp"
#include "drivers/core/time.hpp"
#include "drivers/core/wrapping_counter.hpp"
#include "drivers/mru/mru_driver_checksum.hpp"
#include "drivers/mru/mru_driver_stillness.hpp"
#include "drivers/mru/mru_wire_formats.hpp"
#include "idl/mru.hpp"

namespace motionlab::mru {

struct DriverConfig {
  std::string device = "mru1";  ///< name on the topic
  std::uint32_t source_address =
      0;  ///< host byte order, 0: any. The unit's source port is not known: not checked
  Format format = Format::mrubin;
  Layout layout{};             ///< variables and token of MRUBIN and NMEAP; its limits hold for every format
  double period_s = 0.005;     ///< interval set in the unit; only for counting what was lost
  double latency_s = 0.005;    ///< from measurement to arrival, constant part: no clock filter can see it
  double restart_gap_s = 1.0;  ///< the unit's time jumps by more than this: the unit was restarted
  double silent_after_s = 0.100;  ///< without a good datagram for this long the link is down
  /// Values that stay the same to the last bit for so long are not measured any more: the sample is told as
  /// not stable. 0: never. Only for formats that send measurements as floating-point numbers with noise.
  double stuck_after_s = 0.0;
  double drift_ppm_max = 200.0;  ///< fastest drift of the unit's clock that is followed
  ChecksumJudge::Config checksum{};
};

/// Our end of an MRU's UDP channel. The unit sends by itself; nothing is ever sent back.
///
/// Each good datagram becomes one sample, at once. A datagram that repeats or precedes the last accepted one
/// is dropped and counted; a gap in the unit's time is counted as lost datagrams. Before the first datagram
/// there is no sample; when the unit falls silent samples stop, the phase goes down and the advice says so.
/// What the format or the layout lacks is NaN in the sample, and so is what the unit calls invalid; where
/// that is the attitude or the heave, the sample is not stable. Without a time in the datagram the stamp is
/// arrival minus latency, and neither repetition nor loss can be seen.
class MruDriver {
 public:
  MruDriver(DriverConfig config, Sink<topic::Mru> sink);

  void on_datagram(Bytes datagram, Endpoint from, LabTime t_received);
  /// Watches for silence. Call about every millisecond.
  void step(LabTime now);

  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  [[nodiscard]] const ChecksumJudge& checksum() const noexcept { return judge_; }
  /// Laboratory time minus the unit's time in use; 0 before the first datagram.
  [[nodiscard]] double clock_offset_s() const noexcept { return clock_.offset_s(); }
  [[nodiscard]] double clock_drift_ppm() const noexcept { return clock_.drift_ppm(); }

 private:
  void refuse(Fault fault, LabTime t_received) noexcept;
  [[nodiscard]] ChecksumJudge::Verdict judge(const Check& check) noexcept;
  [[nodiscard]] Result<LabTime> place_in_time(const Motion& motion, LabTime t_received) noexcept;
  void tell(const Motion& motion, bool suspect, LabTime t_measured, LabTime t_received);
  [[nodiscard]] std::string_view advice(LabTime now) const noexcept;

  DriverConfig config_;
  Sink<topic::Mru> sink_;
  LinkHealth health_;
  Decoder decoder_;
  ChecksumJudge judge_;
  Stillness stillness_;
  DeviceClock clock_;
  WrappingCounter unit_time_ms_;
  std::optional<LabTime> t_started_;
  std::optional<LabTime> t_refused_;                      ///< arrival of the newest datagram that was refused
  bool stable_ = true, reduced_ = false, stuck_ = false;  ///< of the newest sample
  topic::Mru sample_{};
};

}  // namespace motionlab::mru
