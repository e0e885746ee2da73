/// @file  The other end of the PLC's remote interface: one reply for each request, from what the PLC has
/// heard.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <optional>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/link_health.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/random.hpp"
#include "drivers/core/time.hpp"
#include "drivers/plc_reply/plc_reply_wire.hpp"
#include "simulators/faults/common_faults.hpp"

namespace motionlab::plc_reply {

struct DeviceConfig {
  Endpoint to{};  ///< replies go there, whoever asks: the program has it written down
  double task_period_s = 0.005;
  std::uint64_t seed = 1;  ///< of garbage
};

/// The remote interface of the published PLC program, as far as it can be read from.
///
/// Requests of exactly 136 bytes wait for the PLC's next cycle, and each gets one reply there, whatever its
/// key. A reply has the platforms as their motion computers said them in the cycle before (assumption), the
/// units as last heard, the PLC's time, and zeros for mode, joints and winch. Who sends the key with a
/// heartbeat that changes has control until it has not changed for 500 ms; of what he commands nothing is
/// simulated, only that he has it.
class PlcReplyDevice {
 public:
  PlcReplyDevice(DeviceConfig config, DatagramOut& out);

  void on_datagram(Bytes datagram, Endpoint from, LabTime t_received);
  /// What a motion reference unit says to the PLC, and when it arrives there. In the order of arrival.
  /// @param unit  0 or 1: that on EM8000, that on EM1500
  void hear(std::size_t unit, const MruFeedback& said, LabTime t_arrives);
  /// The PLC's task. Call every `task_period_s`, with the platforms as they are now.
  void cycle(LabTime t, const std::array<PlatformFeedback, 2>& platforms);
  /// Sends what a fault has held back.
  void step(LabTime now);
  /// From now on the PLC's time shows so much more; 0: right again.
  void set_clock_jump(Nanoseconds jump) noexcept { clock_jump_ = jump; }

  /// Somebody has taken control.
  [[nodiscard]] bool controlled(LabTime now) const noexcept;
  /// Requests taken and refused, by reason.
  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_; }

  /// Every name that `set_fault` knows, separated by blanks.
  [[nodiscard]] static std::string_view fault_names() noexcept;
  /// Switches a fault on or off. Besides the common ones (`slow` counts replies; after `off` the PLC's time
  /// begins anew):
  ///   silent (hears no request; the task goes on) · nan (the heave of EM8000 is no number) · wrong_size (so
  ///   many bytes too many, negative: too few; -1)
  /// @returns refused, with the list of names, for a name that is not known
  Status set_fault(std::string_view name, bool active, double value = 0.0);

 private:
  static constexpr std::size_t kMaxExtraBytes = 64;
  struct Heard {
    MruFeedback said;
    LabTime t_arrives;
  };
  struct Late {
    LabTime t_due{};
    std::size_t size = 0;
    std::array<std::uint8_t, kReplySize + kMaxExtraBytes> bytes{};
  };

  void answer(LabTime t);
  [[nodiscard]] Reply what_it_says() const noexcept;

  DeviceConfig config_;
  DatagramOut& out_;
  Random garbage_;
  faults::CommonFaults common_;
  bool silent_ = false, nan_ = false;
  int extra_bytes_ = 0;
  LinkHealth health_;
  std::uint64_t waiting_ = 0;     ///< requests since the last cycle
  std::uint64_t unanswered_ = 0;  ///< since the last reply
  std::uint64_t sent_ = 0;
  std::uint64_t cycles_ = 0;  ///< since it was switched on
  Nanoseconds clock_jump_{0};
  Reply known_{};  ///< as of the last cycle
  std::array<std::deque<Heard>, 2> inbox_;
  std::deque<Late> late_;
  std::optional<std::uint32_t> heartbeat_;  ///< of who sends the key
  std::optional<LabTime> t_heartbeat_;      ///< when it last changed
};

}  // namespace motionlab::plc_reply
