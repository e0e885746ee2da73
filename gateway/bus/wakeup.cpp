#include "gateway/bus/wakeup.hpp"

#include <cerrno>
#include <ctime>

namespace motionlab::bus {

bool Wakeup::wait(Nanoseconds timeout) noexcept {
  constexpr long kNanosecondsPerSecond = 1'000'000'000;
  timespec until{};
  clock_gettime(CLOCK_MONOTONIC, &until);
  const long sum = until.tv_nsec + timeout.count() % kNanosecondsPerSecond;
  until.tv_sec += timeout.count() / kNanosecondsPerSecond + sum / kNanosecondsPerSecond;
  until.tv_nsec = sum % kNanosecondsPerSecond;
  while (sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &until) != 0) {
    if (errno != EINTR) return false;
  }
  rung_.exchange(false, std::memory_order_acq_rel);
  return true;
}

}  // namespace motionlab::bus
