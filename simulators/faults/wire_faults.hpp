/// @file  What a network does to bytes between a device and whoever listens to it, in one vocabulary. What a
/// device itself does wrong is in common_faults.hpp.
#pragma once

#include <algorithm>
#include <string_view>

#include "drivers/core/time.hpp"

namespace motionlab::faults {

/// Which faults of the wire are on. Plain values; faulty_wire.hpp acts on them.
///
/// Of a stream only `cut` and `jitter` can be seen from outside: TCP repeats what is lost or damaged, drops
/// what comes twice and puts in order what overtook.
struct WireFaults {
  static constexpr std::string_view kNames =
      "cut loss burst jitter reorder duplicate corrupt truncate foreign clock-jump";

  bool cut = false;           ///< nothing passes; a connection neither speaks nor closes
  double loss = 0;            ///< share of the datagrams that never arrive
  double burst = 0;           ///< every tenth datagram is lost on average, in runs of so many
  Nanoseconds jitter{0};      ///< delay, uniform in [0, jitter); a queue: nothing overtakes
  double reorder = 0;         ///< share of the datagrams that the next one overtakes
  double duplicate = 0;       ///< share that arrives twice
  double corrupt = 0;         ///< share of which one bit is flipped
  double truncate = 0;        ///< share that ends too early, anywhere
  double foreign = 0;         ///< share that a changed copy follows, from an address that is not the sender's
  Nanoseconds clock_jump{0};  ///< what the device's own clock shows too much

  /// Switches a fault. `value` is a share (0.1), a number of datagrams (`burst`: 5) or seconds (`jitter`:
  /// 0.01, `clock-jump`: 1, either sign); 0 is the default in parentheses.
  /// @returns false for any other name
  bool set(std::string_view name, bool active, double value = 0) noexcept {
    const auto or_default = [&](double otherwise) { return !active ? 0.0 : value > 0 ? value : otherwise; };
    const double share = std::min(or_default(0.1), 1.0);
    if (name == "cut")
      cut = active;
    else if (name == "loss")
      loss = share;
    else if (name == "burst")
      burst = or_default(5);
    else if (name == "jitter")
      jitter = from_seconds(or_default(0.01));
    else if (name == "reorder")
      reorder = share;
    else if (name == "duplicate")
      duplicate = share;
    else if (name == "corrupt")
      corrupt = share;
    else if (name == "truncate")
      truncate = share;
    else if (name == "foreign")
      foreign = share;
    else if (name == "clock-jump")
      clock_jump = from_seconds(!active ? 0.0 : value != 0 ? value : 1.0);
    else
      return false;
    return true;
  }

  [[nodiscard]] static bool knows(std::string_view name) noexcept { return WireFaults{}.set(name, false); }
  /// Whether a stream shows it.
  [[nodiscard]] static bool passes_tcp(std::string_view name) noexcept {
    return name == "cut" || name == "jitter" || name == "clock-jump";
  }
  /// Whether a datagram passes untouched.
  [[nodiscard]] bool spare_datagrams() const noexcept {
    return !cut && jitter == Nanoseconds{0} &&
           loss + burst + reorder + duplicate + corrupt + truncate + foreign == 0;
  }
  [[nodiscard]] bool spare_streams() const noexcept { return !cut && jitter == Nanoseconds{0}; }
};

}  // namespace motionlab::faults
