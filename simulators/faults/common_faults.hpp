/// @file  The faults that every simulated device has, in one vocabulary. What a network does to bytes is not
/// here but in wire_faults.hpp.
#pragma once

#include <string_view>

#include "drivers/core/time.hpp"

namespace motionlab::faults {

/// Which of the common faults are on. A device asks before it measures and before it speaks; what each fault
/// does to its own bytes only the device knows.
class CommonFaults {
 public:
  static constexpr std::string_view kNames = "off stuck garbage wrong slow delayed intermittent";

  /// Switches a fault. `value` where the fault takes one; 0 is its default.
  ///  - off: without power. No byte leaves and none is heard; when it ends, the device boots.
  ///  - stuck: it goes on speaking, counters and clocks run, but the measured values stand still.
  ///  - garbage: random bytes instead of its own, of the same lengths.
  ///  - wrong: well-formed and plausible, but every measured value is off by `value` in SI (0.1).
  ///  - slow: speaks `value` times more rarely (4).
  ///  - delayed: everything leaves `value` s later than it should (0.05).
  ///  - intermittent: speaks for `value` s, then is silent for `value` s, in turn (0.2).
  /// @returns false for any other name
  bool set(std::string_view name, bool active, double value = 0.0) noexcept {
    if (name == "off")
      off_ = active;
    else if (name == "stuck")
      stuck_ = active;
    else if (name == "garbage")
      garbage_ = active;
    else if (name == "wrong")
      wrong_by_ = active ? or_default(value, 0.1) : 0.0;
    else if (name == "slow")
      slow_by_ = active ? or_default(value, 4.0) : 1.0;
    else if (name == "delayed")
      delay_ = active ? from_seconds(or_default(value, 0.05)) : Nanoseconds{0};
    else if (name == "intermittent")
      intermittent_ = active ? from_seconds(or_default(value, 0.2)) : Nanoseconds{0};
    else
      return false;
    return true;
  }

  [[nodiscard]] bool off() const noexcept { return off_; }
  [[nodiscard]] bool stuck() const noexcept { return stuck_; }
  [[nodiscard]] bool garbage() const noexcept { return garbage_; }
  /// Added to every measured value; 0 when the fault is off.
  [[nodiscard]] double wrong_by() const noexcept { return wrong_by_; }
  /// The device's own period times this; 1 when the fault is off.
  [[nodiscard]] double slow_by() const noexcept { return slow_by_; }
  [[nodiscard]] Nanoseconds delay() const noexcept { return delay_; }
  /// False while it is off, or in the silent half of `intermittent`, whose halves begin at whole multiples.
  [[nodiscard]] bool speaks(LabTime now) const noexcept {
    if (off_) return false;
    return intermittent_ <= Nanoseconds{0} || (now.time_since_epoch() / intermittent_) % 2 == 0;
  }

 private:
  static double or_default(double value, double otherwise) noexcept { return value > 0 ? value : otherwise; }

  bool off_ = false, stuck_ = false, garbage_ = false;
  double wrong_by_ = 0.0, slow_by_ = 1.0;
  Nanoseconds delay_{0}, intermittent_{0};
};

}  // namespace motionlab::faults
