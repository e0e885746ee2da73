/// @file  The other end of the arm's wire: the program on the robot computer, with its real defects or
/// without.
#pragma once

#include <array>
#include <cstdint>
#include <numbers>
#include <optional>
#include <string_view>
#include <vector>

#include "drivers/comau/comau_wire.hpp"
#include "drivers/core/bytes.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/link_health.hpp"
#include "drivers/core/network.hpp"
#include "drivers/core/random.hpp"
#include "drivers/core/time.hpp"
#include "simulators/comau/comau_device_set_point.hpp"

namespace motionlab::comau {

inline constexpr double kDegree = std::numbers::pi / 180.0;

/// The defaults are the limits of the laboratory's settings file.
struct DeviceConfig {
  /// False: `faithful`, the published program with its defects. True: the same bytes with age, finite,
  /// length, key and peer checks.
  bool hardened = false;
  Endpoint peer{};  ///< hardened: commands are taken from there alone (address 0: anybody, port 0: any port)
  Joints q_min_rad{-45 * kDegree, -30 * kDegree, -135 * kDegree, -10 * kDegree, -10 * kDegree, -10 * kDegree};
  Joints q_max_rad{45 * kDegree, 30 * kDegree, -45 * kDegree, 10 * kDegree, 10 * kDegree, 10 * kDegree};
  Joints qd_max_radps{30 * kDegree, 30 * kDegree, 30 * kDegree, 3 * kDegree, 3 * kDegree, 3 * kDegree};
  double deceleration_radps2 = 1.0;  ///< of the bound on the way to the edge of the box
  double command_age_max_s = 0.020;  ///< hardened: an older command is not followed
  Joints stop_deceleration_radps2{1.0, 1.0, 1.0, 3.0, 3.0, 3.0};  ///< hardened: how it comes to rest then
  double remote_enabled_after_s = 1.0;    ///< after the first cycle the operator selects remote mode
  std::uint32_t frame_counter_start = 0;  ///< before the first cycle
  std::uint64_t seed = 1;                 ///< of the losses
};

/// The robot program: answers datagrams at once, and moves the set point in a cycle of 0.4 ms.
///
/// With remote mode on, key 32 and mode 1 the set point is the bounded integral of the wanted velocity. In
/// any other case it is taken from the measured position in every cycle.
///
/// Faithful, i.e. as the published program does:
///   1. no time-out: the last velocity is integrated until the edge of the box
///   2. no length or sequence check: a short datagram overwrites the beginning of the one before it, and is
///   executed
///   3. NaN becomes full speed towards the lower edge
///   4. remote mode before the first datagram ends the program (`crashed`)
///   5. mode 1 → 0 takes the set point from the measured position at once: a step in speed
///   6. hold follows the measured position: it creeps if the arm does
///   and anybody may command, and everybody is answered.
/// Hardened: what fails a check is counted and not answered; a command that is too old, and mode 1 → 0, are
/// ramped to rest first; after a command that is too old the last set point is held.
class ComauDevice {
 public:
  ComauDevice(DeviceConfig config, DatagramOut& out);

  void on_datagram(Bytes datagram, Endpoint from, LabTime t_received);
  /// The control callback: call every 0.4 ms with the joints as they are.
  void cycle(LabTime t, const Joints& q_measured_rad, const Joints& qd_measured_radps);

  /// The position target of the arm's servos. Before the first cycle it is zero and means nothing.
  [[nodiscard]] const Joints& set_point_rad() const noexcept { return set_point_.q_rad(); }
  [[nodiscard]] const Joints& set_point_velocity_radps() const noexcept { return set_point_.qd_radps(); }
  /// False: brakes are on, whatever the set point says.
  [[nodiscard]] bool drives_on() const noexcept { return !drives_off_ && !crashed_; }
  /// The program has ended on its fourth defect: no cycle, no answer any more.
  [[nodiscard]] bool crashed() const noexcept { return crashed_; }
  /// The set point follows commands in this cycle.
  [[nodiscard]] bool following() const noexcept { return following_; }
  [[nodiscard]] std::uint32_t frame_counter() const noexcept { return frame_counter_; }
  /// Commands taken and refused, by reason.
  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  /// Cycles in which the command was too old (hardened).
  [[nodiscard]] std::uint64_t stale_cycles() const noexcept { return stale_cycles_; }

  /// Switches a fault on or off. `value` where the fault takes one, 0 for its default:
  ///   silent (the cable is cut: hears nothing, says nothing; the cycle goes on) · freeze_counter · late
  ///   (answers are late by so many seconds, 0.05) · loss (share of commands lost, 0.1) · wrong_size (bytes
  ///   too many in the answer, negative: too few, -1) · nan_answer · drive_off (the drives drop, brakes on)
  /// @returns refused, with the list of names, for a name that is not known.
  Status set_fault(std::string_view name, bool active, double value = 0.0);

 private:
  struct Late {
    LabTime t_due{};
    Endpoint to{};
    std::size_t size = 0;
    std::array<std::uint8_t, kAnswerSize + 64> bytes{};
  };

  [[nodiscard]] bool take_faithful(Bytes datagram) noexcept;
  [[nodiscard]] bool take_hardened(Bytes datagram, Endpoint from);
  void answer(Endpoint to, LabTime t);
  void send_late(LabTime t);
  void move_faithful(const Joints& q_measured_rad);
  void move_hardened(LabTime t, const Joints& q_measured_rad);

  DeviceConfig config_;
  DatagramOut& out_;
  Random random_;
  SetPoint set_point_;
  LinkHealth health_;

  std::array<std::uint8_t, kCommandSize> buffer_{};  ///< the last datagram, as the program keeps it
  std::optional<LabTime> t_command_;
  std::optional<LabTime> t_first_cycle_;
  Answer measured_{};
  std::uint32_t frame_counter_ = 0;
  std::uint64_t stale_cycles_ = 0;
  bool following_ = false;
  bool crashed_ = false;

  bool silent_ = false;
  bool freeze_counter_ = false;
  bool nan_answer_ = false;
  bool drives_off_ = false;
  double late_s_ = 0.0;
  double loss_share_ = 0.0;
  int extra_bytes_ = 0;
  std::vector<Late> late_;
};

}  // namespace motionlab::comau
