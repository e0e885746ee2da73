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
#include "simulators/comau/comau_device_pendant.hpp"
#include "simulators/comau/comau_device_set_point.hpp"
#include "simulators/faults/common_faults.hpp"

namespace motionlab::comau {

inline constexpr double kDegree = std::numbers::pi / 180.0;

/// The defaults are the limits of the laboratory's settings file.
struct DeviceConfig {
  /// False: `faithful`, the published program with its defects. True: the same bytes with age, finite,
  /// length, key and peer checks.
  bool hardened = false;
  bool long_answers = false;  ///< 124 bytes with the limits below, as the PLC expects; else 52
  Endpoint peer{};  ///< hardened: commands are taken from there alone (address 0: anybody, port 0: any port)
  Joints q_min_rad{-45 * kDegree, -30 * kDegree, -135 * kDegree, -10 * kDegree, -10 * kDegree, -10 * kDegree};
  Joints q_max_rad{45 * kDegree, 30 * kDegree, -45 * kDegree, 10 * kDegree, 10 * kDegree, 10 * kDegree};
  Joints qd_max_radps{30 * kDegree, 30 * kDegree, 30 * kDegree, 3 * kDegree, 3 * kDegree, 3 * kDegree};
  double deceleration_radps2 = 1.0;                        ///< of the bound on the way to the edge of the box
  double command_age_max_s = 0.020;                        ///< hardened: an older command is not followed
  Joints acceleration_max_radps2{10, 10, 10, 10, 10, 10};  ///< hardened: how fast it follows
  Joints stop_deceleration_radps2{1.0, 1.0, 1.0, 3.0, 3.0, 3.0};  ///< hardened: how it comes to rest
  double remote_enabled_after_s = 1.0;    ///< after the program began the operator selects remote mode
  Pendant::Config pendant{};              ///< what happens at the robot controller meanwhile
  std::uint32_t frame_counter_start = 0;  ///< before the first cycle
  std::uint64_t seed = 1;                 ///< of garbage
};

/// The robot program: answers datagrams at once, and moves the set point in a cycle of 0.4 ms that the
/// controller calls while POWERLINK is active.
///
/// With modality POS_ABSOLUTE, remote mode on, key 32 and mode 1 the set point is the bounded integral of the
/// wanted velocity, times the pendant's override. In modality LISTEN the controller holds the arm itself.
///
/// Faithful, i.e. as the published program does:
///   1. no time-out: the last velocity is integrated until the edge of the box
///   2. no length or sequence check, and no lock while reading: a short, old or doubled datagram is executed,
///      a short one together with the end of the one before it; with fault `torn` each new command is first
///      read half written
///   3. NaN becomes full speed towards the lower edge
///   4. remote mode before the first datagram ends the program (`crashed`)
///   5. no limit of acceleration, and when mode 1 ends the set point is taken from the measured position at
///      once: a step in speed
///   6. hold follows the measured position: it creeps if the arm does
///   7. one mutex between the cycle and the receiving thread: a flood of datagrams makes cycles miss
///   8. anybody may command, and everybody is answered
/// Hardened, on the same bytes: what fails a check is counted and not answered; a command that is too old and
/// mode 0 are ramped to rest first, and then the last set point is held; speeds change within a limit;
/// commands are handed over whole and without a lock. What these bytes cannot cure: they carry no sequence
/// number, so an old command that is sent again by the peer is as good as a new one.
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
  [[nodiscard]] bool drives_on() const noexcept {
    return !faults_.off() && !crashed_ && pendant_.drives() == Pendant::Drives::on;
  }
  /// The program has ended on its fourth defect: no cycle, no answer any more, until it is switched off and
  /// on.
  [[nodiscard]] bool crashed() const noexcept { return crashed_; }
  /// The set point follows commands in this cycle.
  [[nodiscard]] bool following() const noexcept { return following_; }
  [[nodiscard]] std::uint32_t frame_counter() const noexcept { return frame_counter_; }
  [[nodiscard]] const Pendant& pendant() const noexcept { return pendant_; }
  /// Commands taken and refused, by reason.
  [[nodiscard]] const LinkHealth& health() const noexcept { return health_; }
  /// Cycles in which the command was too old (hardened).
  [[nodiscard]] std::uint64_t stale_cycles() const noexcept { return stale_cycles_; }
  /// Cycles that waited for the mutex until it was too late (faithful).
  [[nodiscard]] std::uint64_t missed_cycles() const noexcept { return missed_cycles_; }

  /// Every name that `set_fault` knows, separated by blanks.
  [[nodiscard]] static std::string_view fault_names() noexcept;

  /// Switches a fault on or off. The common ones (see CommonFaults; `slow` and `intermittent` concern the
  /// answers, `off` ends the program, which begins anew after it), and, with `value` where it takes one and 0
  /// for its default:
  ///   - silent: hears nothing, says nothing; the cycle goes on
  ///   - freeze_counter: the cycle goes on, its counter does not
  ///   - wrong_size: so many bytes too many in the answer, negative: too few (-1)
  ///   - nan_answer: the first position is no number
  ///   - powerlink_drop: no cycle, brakes on
  ///   - drive_off, drive_fault: the drives drop, in order or at once; brakes on
  ///   - hold: the PDL2 program is held, the controller holds the arm
  ///   - local: the console switch is turned from remote to stop
  ///   - override: the pendant's, in percent (20)
  ///   - torn: so many bytes of a new command are there when it is first read (20); faithful alone
  /// @returns refused, with the list of names, for a name that is not known
  Status set_fault(std::string_view name, bool active, double value = 0.0);

 private:
  static constexpr int kMaxExtraBytes = 64;
  struct Late {
    LabTime t_due{};
    Endpoint to{};
    std::size_t size = 0;
    std::array<std::uint8_t, kLongAnswerSize + kMaxExtraBytes> bytes{};
  };
  using Command32 = std::array<std::uint8_t, kCommandSize>;

  void boot() noexcept;
  void take_faithful(Bytes datagram) noexcept;
  [[nodiscard]] bool take_hardened(Bytes datagram, Endpoint from);
  void answer(Endpoint to, LabTime t);
  [[nodiscard]] Answer what_it_says() const noexcept;
  void send_late(LabTime t);
  [[nodiscard]] bool misses_cycle() noexcept;
  void move(LabTime t, const Joints& q_measured_rad);
  void move_faithful(const Joints& q_measured_rad, bool remote);
  void move_hardened(LabTime t, bool remote);
  [[nodiscard]] Command command_as_read() noexcept;
  [[nodiscard]] Joints wanted(const Command& command) const noexcept;

  DeviceConfig config_;
  DatagramOut& out_;
  Random random_;
  SetPoint set_point_;
  Pendant pendant_;
  LinkHealth health_;

  Command32 buffer_{};  ///< the last datagram, as the program keeps it
  Command32 before_{};  ///< what the buffer held before
  bool unread_ = false;
  std::optional<LabTime> t_command_;
  std::optional<LabTime> t_first_cycle_;
  Answer measured_{};
  std::uint32_t frame_counter_ = 0;
  double lock_owed_s_ = 0.0;  ///< how long the receiving thread holds the mutex in this cycle
  std::uint64_t stale_cycles_ = 0;
  std::uint64_t missed_cycles_ = 0;
  bool listening_ = false;
  bool following_ = false;
  bool crashed_ = false;

  faults::CommonFaults faults_;
  std::optional<Answer> stuck_;
  double unanswered_ = 0.0;
  bool silent_ = false;
  bool freeze_counter_ = false;
  bool nan_answer_ = false;
  bool local_ = false;
  std::size_t torn_after_bytes_ = kCommandSize;
  int extra_bytes_ = 0;
  std::vector<Late> late_;
};

}  // namespace motionlab::comau
