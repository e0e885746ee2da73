/// @file  Time is a parameter: `LabTime` is a time point of a clock that cannot be asked.
#pragma once

#include <chrono>
#include <cstdint>

namespace motionlab {

using Nanoseconds = std::chrono::nanoseconds;
using namespace std::chrono_literals;

/// The laboratory's time line. It has no `now()`: only a `Clock&` knows, and only the service or the lockstep
/// runner holds one. Zero is 1970-01-01 UTC in real time and the start of the run in lockstep.
struct LabClock {
  using duration = Nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<LabClock>;
  static constexpr bool is_steady = true;
};

using LabTime = LabClock::time_point;

/// Seconds as a double, for mathematics.
[[nodiscard]] constexpr double seconds(Nanoseconds d) noexcept {
  return 1e-9 * static_cast<double>(d.count());
}
/// A duration from seconds, rounded to the nearest nanosecond.
[[nodiscard]] constexpr Nanoseconds from_seconds(double s) noexcept {
  return Nanoseconds{static_cast<std::int64_t>(s * 1e9 + (s < 0 ? -0.5 : 0.5))};
}
/// The integer that travels on topics as `t_*_ns`.
[[nodiscard]] constexpr std::int64_t to_ns(LabTime t) noexcept {
  return t.time_since_epoch().count();
}
[[nodiscard]] constexpr LabTime from_ns(std::int64_t ns) noexcept {
  return LabTime{Nanoseconds{ns}};
}

/// The one thing that knows the time.
class Clock {
 public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual LabTime now() const noexcept = 0;
};

/// A clock that stands still until somebody moves it: lockstep and tests. Starts at 0.
class SteppedClock final : public Clock {
 public:
  [[nodiscard]] LabTime now() const noexcept override { return now_; }
  void advance(Nanoseconds by) noexcept { now_ += by; }
  void set(LabTime t) noexcept { now_ = t; }

 private:
  LabTime now_{};
};

}  // namespace motionlab
