/// @file  When the winch may be enabled: the edges that the PLC wants, and the rule that nothing resumes by
/// itself.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/core/time.hpp"
#include "drivers/winch/winch_wire.hpp"

namespace motionlab::winch {

/// Turns the caller's levels into the PLC's bEnable and bReset.
///
/// A rising edge of the caller's enable arms. Whatever takes the winch away from us disarms until the next
/// rising edge: a lost link, a latched PLC (fault or communication lost), a PLC that switched off by itself.
/// A rising edge of the caller's reset, while the PLC is latched, holds enable low until the PLC has seen
/// that, then holds reset until the latch is gone or 0.5 s have passed. An enable edge that comes with the
/// reset, or while it is under way, takes effect after it; one that comes to a latched PLC without a reset is
/// lost. bEnable rises only after the PLC has echoed a command with bEnable low.
class Arming {
 public:
  struct Bits {
    bool enable = false;
    bool reset = false;
  };

  /// The link was lost or is new: an enable that is held high no longer counts.
  void disarm() noexcept { *this = Arming{last_enable_, last_reset_}; }

  /// What the caller wants. `in_touch`: the PLC is listening to us now.
  void wish(bool enable, bool reset, bool in_touch, LabTime t) noexcept {
    const bool enable_edge = enable && !last_enable_;
    const bool reset_edge = reset && !last_reset_;
    last_enable_ = enable;
    last_reset_ = reset;
    if (reset_edge && in_touch && latched_) {
      armed_ = false;
      t_reset_ = t;
    }
    if (!enable) {
      armed_ = false;
    } else if (enable_edge && in_touch && (!latched_ || t_reset_)) {
      armed_ = true;
      was_enabled_ = false;
    }
  }

  /// What the PLC says.
  void heard(const PlcStatus& status, LabTime t) noexcept {
    const auto reached = [&](std::uint32_t heartbeat) {
      return static_cast<std::int32_t>(status.heartbeat_echo - heartbeat) >= 0;
    };
    latched_ = status.state == PlcState::fault || status.state == PlcState::communication_lost;
    if (low_since_ && reached(*low_since_)) low_seen_ = true;
    if (t_reset_ && !latched_) t_reset_.reset();
    if (t_reset_ && t - *t_reset_ > kResetPatience) {
      t_reset_.reset();
      armed_ = false;
    }
    const bool dropped = was_enabled_ && status.state == PlcState::off && !status.enabled;
    if ((latched_ && !t_reset_) || dropped) {
      armed_ = false;
      was_enabled_ = false;
    }
    if (status.enabled) was_enabled_ = true;
  }

  /// The bits of the next command.
  [[nodiscard]] Bits bits() const noexcept {
    const bool enable = armed_ && !latched_ && !t_reset_ && (low_seen_ || high_written_);
    return {enable, t_reset_.has_value() && latched_ && low_seen_};
  }

  /// The next command was written with these bits and this heartbeat.
  void written(Bits bits, std::uint32_t heartbeat) noexcept {
    high_written_ = bits.enable;
    if (bits.enable) {
      low_since_.reset();
      low_seen_ = false;
    } else if (!low_since_) {
      low_since_ = heartbeat;
    }
  }

  [[nodiscard]] bool armed() const noexcept { return armed_; }

  Arming() = default;

 private:
  static constexpr Nanoseconds kResetPatience = 500ms;

  Arming(bool last_enable, bool last_reset) noexcept : last_enable_(last_enable), last_reset_(last_reset) {}

  bool last_enable_ = false;  ///< the caller's
  bool last_reset_ = false;
  bool armed_ = false;
  bool latched_ = false;
  bool was_enabled_ = false;
  std::optional<LabTime> t_reset_;  ///< a reset is under way since
  std::optional<std::uint32_t> low_since_;
  bool low_seen_ = false;
  bool high_written_ = false;
};

}  // namespace motionlab::winch
