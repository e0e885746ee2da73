#include "drivers/core/real_clock.hpp"

#include <time.h>

#include <algorithm>
#include <cmath>

namespace motionlab {
namespace {

Nanoseconds read_clock(clockid_t id) noexcept {
  timespec t{};
  clock_gettime(id, &t);
  return std::chrono::seconds{t.tv_sec} + Nanoseconds{t.tv_nsec};
}

struct Reading {
  Nanoseconds monotonic;
  Nanoseconds utc;
};

/// Both clocks at one instant: the closest of several attempts, because a thread may be held up between them.
Reading read_both() noexcept {
  Reading best{};
  Nanoseconds narrowest = Nanoseconds::max();
  for (int i = 0; i < 5; ++i) {
    const Nanoseconds before = read_clock(CLOCK_MONOTONIC);
    const Nanoseconds utc = read_clock(CLOCK_REALTIME);
    const Nanoseconds after = read_clock(CLOCK_MONOTONIC);
    if (after - before < narrowest) {
      narrowest = after - before;
      best = {before + (after - before) / 2, utc};
    }
  }
  return best;
}

}  // namespace

LabTime SlewedOffset::at(Nanoseconds monotonic) const noexcept {
  const auto reach = std::max(
      Nanoseconds{0},
      Nanoseconds{std::llround(static_cast<double>((monotonic - start).count()) * (1e-6 * kPpmMax))});
  return LabTime{monotonic + offset + std::clamp(slew, -reach, reach)};
}

SlewedOffset SlewedOffset::next(Nanoseconds monotonic, Nanoseconds utc) const noexcept {
  const Nanoseconds now = at(monotonic).time_since_epoch();
  return {monotonic, now - monotonic, utc - now};
}

RealClock::RealClock() {
  const Reading reading = read_both();
  written_ = {reading.monotonic, reading.utc - reading.monotonic, Nanoseconds{0}};
  offset_.write(written_);
}

LabTime RealClock::now() const noexcept {
  auto offset = offset_.read();
  while (!offset) offset = offset_.read();
  const std::int64_t now_ns = to_ns(offset->value.at(read_clock(CLOCK_MONOTONIC)));
  // A thread that is held up in here uses an offset of the past: the newest time told to anyone is the floor.
  std::int64_t newest_ns = newest_ns_.load(std::memory_order_relaxed);
  while (now_ns > newest_ns &&
         !newest_ns_.compare_exchange_weak(newest_ns, now_ns, std::memory_order_relaxed)) {
  }
  return from_ns(std::max(now_ns, newest_ns));
}

void RealClock::discipline() noexcept {
  const Reading reading = read_both();
  written_ = written_.next(reading.monotonic, reading.utc);
  error_ns_.store(written_.slew.count(), std::memory_order_relaxed);
  offset_.write(written_);
}

}  // namespace motionlab
