/// @file  From the caller's newest command to the PLC's.
#pragma once

#include <optional>
#include <string_view>

#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"
#include "drivers/winch/winch_driver_axis.hpp"
#include "drivers/winch/winch_wire.hpp"
#include "idl/winch_command.hpp"

namespace motionlab::winch {

/// Holds the newest good command of the caller and says what the PLC shall do with the set points.
///
/// Without a command the mode is off; a stale one is a quick stop that holds. Enable, reset, heartbeat and
/// sequence are not decided here.
class CommandSource {
 public:
  CommandSource(AxisMap axis, Nanoseconds stale_after) noexcept : axis_(axis), stale_after_(stale_after) {}

  /// Its age counts from t_created_ns, or from now when that lies ahead. Faults: bad_value (not finite),
  /// out_of_order (created before the one in use), foreign (another device's name).
  Status set(const topic::WinchCommand& command, std::string_view device, LabTime now);

  /// @param hold_at_m  axis position to hold where the command names none
  [[nodiscard]] PlcCommand at(LabTime now, double hold_at_m);
  /// Times that a command became stale.
  [[nodiscard]] std::uint64_t became_stale() const noexcept { return became_stale_; }

 private:
  AxisMap axis_;
  Nanoseconds stale_after_;
  topic::WinchCommand command_{};
  std::optional<LabTime> t_command_;
  bool stale_ = false;
  std::uint64_t became_stale_ = 0;
};

/// What is left of a command in the laboratory's published project: a velocity no faster than the limit.
/// Position mode does not exist there: it holds.
[[nodiscard]] LegacyCommand to_legacy(const PlcCommand& command, double speed_max_mps) noexcept;

}  // namespace motionlab::winch
