/// @file  The robot controller as the program on the robot computer meets it, and who stands at its pendant.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/core/time.hpp"

namespace motionlab::comau {

/// POWERLINK, drives, the PDL2 program that opens the arm to the robot computer, the speed override; and an
/// operator who switches everything on, in order, as soon as nothing speaks against it:
///
///     POWERLINK active → DRIVE ON → drives on, modality LISTEN → START → modality POS_ABSOLUTE
///
/// Numbers of drive status and modality are the controller's own, as published.
class Pendant {
 public:
  /// Each time counts from the step before it. All zero: everything is on in the first cycle.
  struct Config {
    double powerlink_after_s = 0.0;  ///< since the program began, or since the line is whole again
    double drive_on_after_s = 0.0;   ///< until the operator presses DRIVE ON
    double driving_on_s = 0.0;       ///< how long that takes
    double start_after_s = 0.0;      ///< until the operator presses START
    double driving_off_s = 0.0;      ///< how long DRIVE OFF takes; the brakes hold from its beginning
    double override_percent = 100.0;

    bool operator==(const Config&) const = default;
  };
  enum class Drives : std::uint8_t { off = 1, driving_on = 2, driving_off = 3, on = 4 };
  enum class Modality : std::uint8_t { listen = 0, pos_absolute = 4 };

  explicit Pendant(const Config& config) noexcept : config_(config) {}

  /// The operator does what is due, all of it when no time lies between.
  void step(LabTime t) noexcept;

  [[nodiscard]] bool powerlink() const noexcept { return phase_ != Phase::powerlink_down; }
  [[nodiscard]] Drives drives() const noexcept;
  [[nodiscard]] Modality modality() const noexcept {
    return phase_ == Phase::open ? Modality::pos_absolute : Modality::listen;
  }
  /// Share of the asked speed that the arm is given, 0…1.
  [[nodiscard]] double speed_share() const noexcept {
    return 0.01 * override_percent_.value_or(config_.override_percent);
  }

  // What goes wrong, or what somebody does who is not the operator. Each lasts until it is taken back; then
  // the operator begins again from there.
  void drop_powerlink(bool active) noexcept;
  void press_drive_off(bool active) noexcept;  ///< passes through `driving_off`
  void fail_drives(bool active) noexcept;      ///< off at once
  void press_hold(bool active) noexcept;       ///< the program is held: back to LISTEN
  /// Nothing: as configured.
  void set_override(std::optional<double> percent) noexcept { override_percent_ = percent; }

 private:
  enum class Phase : std::uint8_t { powerlink_down, drives_off, driving_on, listen, open, driving_off };

  void enter(Phase phase) noexcept {
    phase_ = phase;
    since_.reset();
  }
  [[nodiscard]] std::optional<Phase> next(double waited_s) const noexcept;

  Config config_;
  Phase phase_ = Phase::powerlink_down;
  std::optional<LabTime> since_;  ///< when the phase began; nothing until it was seen
  bool line_cut_ = false, off_pressed_ = false, drives_failed_ = false, held_ = false;
  std::optional<double> override_percent_;
};

}  // namespace motionlab::comau
