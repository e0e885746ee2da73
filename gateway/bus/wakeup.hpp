/// @file  `Wakeup`: one thread sleeps, others ring. Ringing costs a system call only when the sleeper has
/// slept.
#pragma once

#include <semaphore.h>

#include <atomic>

#include "drivers/core/time.hpp"

namespace motionlab::bus {

/// Rings that come while one is pending are one ring. What was written before `ring` is seen after `wait`.
class Wakeup {
 public:
  Wakeup() noexcept { sem_init(&semaphore_, 0, 0); }
  ~Wakeup() { sem_destroy(&semaphore_); }
  Wakeup(const Wakeup&) = delete;
  Wakeup& operator=(const Wakeup&) = delete;

  /// Any thread. Never blocks.
  void ring() noexcept {
    if (!rung_.exchange(true, std::memory_order_acq_rel)) sem_post(&semaphore_);
  }

  /// Sleeps until somebody rings or the time is over. One thread. True when somebody rang.
  bool wait(Nanoseconds timeout) noexcept;

 private:
  sem_t semaphore_;
  std::atomic<bool> rung_{false};
};

}  // namespace motionlab::bus
