/// @file  Laboratory time in real time.
#pragma once

#include <atomic>
#include <cstdint>

#include "drivers/core/latest.hpp"
#include "drivers/core/time.hpp"

namespace motionlab {

/// An offset that walks to where it should be, at a bounded rate. The mathematics of `RealClock`, on given
/// times.
///
/// From `start` on, the offset moves from `offset` by `slew` at 500 ppm and then stays.
struct SlewedOffset {
  static constexpr double kPpmMax = 500.0;

  Nanoseconds start{0};  ///< monotonic time
  Nanoseconds offset{0};
  Nanoseconds slew{0};

  /// The laboratory time at this monotonic time.
  [[nodiscard]] LabTime at(Nanoseconds monotonic) const noexcept;
  /// The walk that follows this one, when UTC is found to be `utc` at `monotonic`. Continuous with this one.
  [[nodiscard]] SlewedOffset next(Nanoseconds monotonic, Nanoseconds utc) const noexcept;
};

/// CLOCK_MONOTONIC plus an offset to UTC that is taken at construction and then only slewed, never stepped.
///
/// So the time never goes backwards and never jumps, yet follows UTC (and with it the machine's NTP or PTP)
/// at up to 500 ppm: 1 ms of error is gone after two seconds. A step of UTC by an hour is followed for as
/// long as it takes.
class RealClock final : public Clock {
 public:
  RealClock();

  /// Any thread. Never earlier than what any thread was told before.
  [[nodiscard]] LabTime now() const noexcept override;

  /// Looks how far UTC is away and begins to slew towards it. About once a second, from one thread.
  void discipline() noexcept;

  /// UTC minus laboratory time at the last `discipline`; 0 before the first. Any thread.
  [[nodiscard]] Nanoseconds error() const noexcept {
    return Nanoseconds{error_ns_.load(std::memory_order_relaxed)};
  }

 private:
  Latest<SlewedOffset> offset_;
  SlewedOffset written_;  ///< the newest, for the thread that disciplines
  std::atomic<std::int64_t> error_ns_{0};
  mutable std::atomic<std::int64_t> newest_ns_{0};  ///< told so far
};

}  // namespace motionlab
