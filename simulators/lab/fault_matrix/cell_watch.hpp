/// @file  Watches the run of one cell and says what happened.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/core/time.hpp"
#include "gateway/controller/guard.hpp"
#include "gateway/service/gateway_config.hpp"
#include "idl/health.hpp"
#include "idl/mode.hpp"
#include "idl/winch_command.hpp"
#include "simulators/lab/fault_matrix/cell.hpp"
#include "simulators/lab/fault_matrix/outcome.hpp"

namespace motionlab::matrix {

/// What is really so, as far as a cell asks.
struct Truth {
  std::array<double, 6> q_rad{}, qd_radps{};
  double wire_length_m = 0, wire_speed_mps = 0;
  double swing_deg = 0, twin_swing_deg = 0;
};

/// Fed with everything that can be seen from outside, in the order of time.
///
/// Detected is a fault with the first of: a mode that changes unasked, or a latch ("mode CODE") · the link in
/// the device's health ("link STATE") · an advice ("advice") · a sample that says of itself that it is not to
/// be used ("quality"). When none of these comes, a counter of the health that moves for the first time will
/// do ("counted"). Health is told ten times a second, which is the resolution of all that is read from it.
///
/// Arm and winch move while a joint is truly faster than 1 mrad/s, or the wire faster than 1 mm/s, or either
/// creeps by 2 mrad or 2 mm. They have come to rest when they do not for longer than half a period of the
/// servos' ringing: a joint that turns round stands for an instant, too. What moves after that moves by
/// itself.
class CellWatch {
 public:
  /// Limits are those in force, the cap for a robot computer without a watchdog included.
  CellWatch(const Cell& cell, const service::GatewayConfig& gateway, const lab::LabConfig& lab);

  /// The arm's command as it left on the wire. A mode other than "follow" asks for no speed.
  void sent(LabTime t, bool follow, const std::array<double, 6>& qd_radps);
  void take(LabTime t, const topic::Mode& mode);
  void take(LabTime t, const topic::WinchCommand& command);
  /// Of the cell's device.
  void take(LabTime t, const topic::Health& health);
  /// Whether the newest samples of the cell's device call themselves good.
  void quality(LabTime t, bool good);
  /// Once per control step.
  void take(LabTime t, const Truth& truth);

  [[nodiscard]] Outcome outcome() const;

 private:
  [[nodiscard]] bool during_fault(LabTime t) const { return t >= fault_ && t < fault_ends_; }
  /// Whether all has come to rest.
  [[nodiscard]] bool rests(LabTime t) const;
  void detect(LabTime t, std::string by);
  void watch_limits(const Truth& truth);
  void watch_swing(LabTime t, const Truth& truth);
  void watch_motion(LabTime t, const Truth& truth);

  State state_;
  controller::GuardLimits limits_;
  std::array<double, 6> qdd_max_radps2_;
  std::array<double, 6> servo_qd_max_radps_;  ///< see Overshoot
  double servo_wire_speed_max_mps_;
  Nanoseconds command_period_;
  LabTime fault_, fault_ends_;
  LabTime asked_;  ///< when somebody asked to engage

  Outcome outcome_;
  std::optional<LabTime> detected_, counted_;
  topic::Mode mode_;
  topic::Health health_before_;
  bool good_before_ = true;
  bool was_engaged_ = false;       ///< since the fault
  LabTime engaged_{};              ///< since when it is
  std::optional<LabTime> ended_;   ///< when the engagement ended
  std::optional<LabTime> let_go_;  ///< since when the arm's wire says anything but "follow"
  std::optional<LabTime> sent_;
  std::array<double, 6> qd_sent_radps_{};
  std::optional<LabTime> winch_told_;
  double wire_speed_told_mps_ = 0;
  struct Rest {
    LabTime since;
    Truth where;
  };
  std::optional<Rest> rest_;  ///< since when nothing moves
  LabTime watched_{};         ///< the newest truth
  LabTime moved_{};           ///< last seen moving after the engagement ended
  double squares_deg2_ = 0;
  std::uint64_t samples_ = 0;
};

}  // namespace motionlab::matrix
