#include "gateway/service/real_time.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <time.h>

#include <cerrno>
#include <cstring>

namespace motionlab::service {
namespace {

Nanoseconds monotonic() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::chrono::seconds{now.tv_sec} + Nanoseconds{now.tv_nsec};
}

}  // namespace

std::string lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  return std::string("memory is not locked (") + std::strerror(errno) +
         "): page faults can delay control; grant CAP_IPC_LOCK or LimitMEMLOCK=infinity";
}

std::string become_real_time(const char* name, int priority) {
  pthread_setname_np(pthread_self(), name);
  prctl(PR_SET_TIMERSLACK, 1UL);
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  if (refused == 0) return {};
  return std::string("thread ") + name + " runs without SCHED_FIFO (" + std::strerror(refused) +
         "): other processes can delay it; grant CAP_SYS_NICE";
}

Metronome::Metronome(Nanoseconds period) : period_(period), next_(monotonic() + period) {}

std::uint64_t Metronome::wait() {
  const timespec until{static_cast<time_t>(next_ / std::chrono::seconds{1}),
                       static_cast<long>((next_ % std::chrono::seconds{1}).count())};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
  next_ += period_;
  const Nanoseconds late = monotonic() - next_;
  if (late < Nanoseconds{0}) return 0;
  const auto missed = static_cast<std::uint64_t>(late / period_) + 1;
  next_ += period_ * static_cast<std::int64_t>(missed);
  return missed;
}

}  // namespace motionlab::service
