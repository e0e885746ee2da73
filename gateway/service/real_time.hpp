/// @file  What a control thread asks of the kernel, and what it gets.
#pragma once

#include <string>
#include <thread>
#include <vector>

#include "drivers/core/time.hpp"

namespace motionlab::service {

/// Locks the process' memory as it is touched. @returns what was refused, as a sentence; empty when granted
[[nodiscard]] std::string lock_memory();

/// Names the calling thread, asks for SCHED_FIFO and for prompt timers, for one processor if `cpu` is not
/// negative, and touches its stack. @returns as above
[[nodiscard]] std::string become_real_time(const char* name, int priority, int cpu);

/// Keeps a processor from falling asleep for as long as this lives: a thread named "awake" turns on it while
/// nobody else wants it (SCHED_IDLE). A processor that idles is given up by a virtual machine, or sleeps
/// deeply: it wakes late, and its caches have been another's. Costs the power of a busy one.
class AwakeProcessor {
 public:
  explicit AwakeProcessor(int cpu);
  /// @returns as above; it then lets the processor sleep
  [[nodiscard]] const std::string& refused() const { return refused_; }

 private:
  std::string refused_;
  std::jthread thread_;
};

/// Leaves processor `cpu` to the threads that ask for it by number: takes it from the calling thread and from
/// those it will start. Does nothing if `cpu` is negative or there is no other.
void leave_processor(int cpu);

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
