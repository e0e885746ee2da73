/// @file  What a control thread asks of the kernel, and what it gets.
#pragma once

#include <string>
#include <vector>

#include "drivers/core/time.hpp"

namespace motionlab::service {

/// Locks the process' memory as it is touched. @returns what was refused, as a sentence; empty when granted
[[nodiscard]] std::string lock_memory();

/// Names the calling thread, asks for SCHED_FIFO and for prompt timers, for one processor if `cpu` is not
/// negative, and touches its stack. @returns as above
[[nodiscard]] std::string become_real_time(const char* name, int priority, int cpu);

/// Of the calling thread since it began, minor and major.
[[nodiscard]] std::uint64_t page_faults();

/// Wakes once per period on an absolute schedule of the monotonic clock. A period that was slept through is
/// skipped.
class Metronome {
 public:
  explicit Metronome(Nanoseconds period);
  struct Woken {
    Nanoseconds late{};        ///< after the beat that was waited for
    std::uint64_t missed = 0;  ///< further beats that were slept through
  };
  /// Sleeps until the next beat.
  Woken wait();

 private:
  Nanoseconds period_;
  Nanoseconds next_;
};

}  // namespace motionlab::service
