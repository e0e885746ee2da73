/// @file  Brings the winch to rest through its driver and tells whether it rests.
#pragma once

#include <optional>

#include "drivers/core/network.hpp"
#include "drivers/core/time.hpp"
#include "drivers/winch/winch_driver.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::deadman {

/// Connects, waits for the first status, stops in the driver's order (quick stop, rest, disable), closes.
///
/// Only for when nobody else speaks to the PLC: it keeps one connection per client address and drops the
/// older. Where the configuration lets us only listen there is nothing to settle, and nothing is opened.
class WinchSettler {
 public:
  enum class End {
    not_yet,
    at_rest,
    nothing_to_settle,  ///< this PLC project is only listened to
    unreachable,        ///< no status within patience; the PLC's own watchdog has to stop it
    moving,             ///< it answered, and was not seen at rest
  };

  static constexpr Nanoseconds kContactPatience = 3s;
  static constexpr Nanoseconds kStopPatience = 6s;

  /// @param out  outlives this
  WinchSettler(const winch::DriverConfig& config, StreamOut& out, LabTime now);

  /// What happens on the stream has to go there.
  [[nodiscard]] StreamEvents* events() noexcept { return &driver_; }
  /// Call about every millisecond until it has ended.
  void step(LabTime now);
  [[nodiscard]] End end() const noexcept { return end_; }

 private:
  [[nodiscard]] End judged() const noexcept;

  winch::WinchDriver driver_;
  std::optional<topic::WinchState> newest_;
  LabTime give_up_;
  bool stopping_ = false;
  End end_;
};

}  // namespace motionlab::deadman
