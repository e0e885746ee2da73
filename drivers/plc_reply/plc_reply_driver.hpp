/// @file  Asks the PLC what it knows and tells where the platforms are by their own encoders.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/link_health.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/sink.hpp"
#include "drivers/core/time.hpp"
#include "drivers/plc_reply/plc_reply_wire.hpp"
#include "idl/bodies.hpp"
#include "idl/mru.hpp"

namespace motionlab::plc_reply {

/// How roll, pitch and yaw of the platforms' pose build a rotation.
enum class EulerOrder : std::uint8_t {
  xyz,  ///< R = Rx(roll) Ry(pitch) Rz(yaw): the laboratory's code for its platforms
  zyx,  ///< R = Rz(yaw) Ry(pitch) Rx(roll)
};

/// The unit quaternion w, x, y, z of roll, pitch, yaw in rad.
[[nodiscard]] std::array<double, 4> quaternion(double roll, double pitch, double yaw,
                                               EulerOrder order) noexcept;

struct DriverConfig {
  std::string device = "plc";  ///< name on the topics; the units are called `plc_mru1` and `plc_mru2`
  Endpoint plc{};  ///< requests go there; replies are taken from there alone (port 0: any of its ports)
  double period_s = 0.005;       ///< from request to request; the PLC's own cycle, nothing is new sooner
  double latency_s = 0.005;      ///< from the platforms' pose to the arrival of the reply, constant part
  double mru_latency_s = 0.010;  ///< likewise from the motion that a unit measured
  EulerOrder euler_order = EulerOrder::xyz;
  double silent_after_s = 0.100;  ///< without a new reply for this long the link is down
  double restart_gap_s = 0.1;     ///< the PLC's time goes back by more than this: its program was restarted
};

/// Reads along at the PLC's remote interface. It cannot take control: all that it ever sends is `kRequest`.
///
/// A request leaves in each period, from the first step on; one that was missed is not made up. Each reply
/// that says something new becomes one sample of each platform (bodies `em8000`, `em1500`), in the frame N of
/// its own neutral pose, z down, and one of each unit whose values have changed. A unit's values come without
/// its time and its status, twelve of 24: the samples never claim to be stable, what is missing is NaN, and a
/// unit that the PLC does not hear any more ends like one that is silent. Stamps are arrival minus latency:
/// the PLC's own time counts in 32-bit floating point and stands still after a day and a half.
///
/// Refused and counted: other senders, other sizes, values that are not finite or implausible, a reply that
/// is older than the last (out_of_order). The same reply again, as two requests within one cycle of the PLC
/// bring it, says nothing and is no fault. More than two requests without a reply count as lost. Before the
/// first reply there is no sample; when the PLC falls silent samples stop, the phase goes down and the advice
/// says so.
class PlcReplyDriver {
 public:
  PlcReplyDriver(DriverConfig config, DatagramOut& out, Sink<topic::Bodies> on_body, Sink<topic::Mru> on_mru);

  void on_datagram(Bytes datagram, Endpoint from, LabTime t_received);
  /// Asks when it is time to, and watches for silence. Call about every millisecond.
  void step(LabTime now);

  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  /// Requests that really left.
  [[nodiscard]] std::uint64_t sent() const noexcept { return sent_; }

 private:
  void ask(LabTime now);
  void count_reply() noexcept;
  void refuse(Fault fault, LabTime t_received) noexcept;
  [[nodiscard]] Status judge_time(const Reply& reply) noexcept;
  void tell_platform(std::size_t ship, const PlatformFeedback& platform, LabTime t_received);
  void tell_unit(std::size_t ship, const MruFeedback& unit, LabTime t_received);
  [[nodiscard]] bool quiet(LabTime since, LabTime now) const noexcept;
  [[nodiscard]] std::string_view advice(LabTime now) const noexcept;

  DriverConfig config_;
  DatagramOut& out_;
  Sink<topic::Bodies> on_body_;
  Sink<topic::Mru> on_mru_;
  LinkHealth health_;
  LabTime next_request_ = LabTime::min();
  std::optional<LabTime> t_started_;
  std::optional<LabTime> t_refused_;  ///< arrival of the newest datagram that was refused
  std::uint64_t sent_ = 0;
  std::uint64_t owed_ = 0;  ///< requests that have no reply yet
  std::optional<Reply> last_;
  std::array<LabTime, 2> t_unit_{};  ///< when the values of each unit last changed
  std::array<topic::Bodies, 2> bodies_{};
  std::array<topic::Mru, 2> units_{};
};

}  // namespace motionlab::plc_reply
