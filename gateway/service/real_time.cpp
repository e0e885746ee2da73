#include "gateway/service/real_time.hpp"

#include <pthread.h>
#include <sched.h>
#include <strings.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <time.h>

#include <array>
#include <cerrno>
#include <cstring>

namespace motionlab::service {
namespace {

Nanoseconds monotonic() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::chrono::seconds{now.tv_sec} + Nanoseconds{now.tv_nsec};
}

/// The stack grows by page faults; they shall come before the first step.
void touch_stack() {
  std::array<char, 128 * 1024> pages;
  explicit_bzero(pages.data(), pages.size());
}

}  // namespace

std::string lock_memory() {
  if (mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  return std::string("memory is not locked (") + std::strerror(errno) +
         "): page faults can delay control; grant CAP_IPC_LOCK or LimitMEMLOCK=infinity";
}

std::uint64_t page_faults() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return static_cast<std::uint64_t>(usage.ru_minflt + usage.ru_majflt);
}

std::string become_real_time(const char* name, int priority, int cpu) {
  pthread_setname_np(pthread_self(), name);
  prctl(PR_SET_TIMERSLACK, 1UL);
  touch_stack();
  if (cpu >= 0) {
    cpu_set_t only;
    CPU_ZERO(&only);
    CPU_SET(static_cast<std::size_t>(cpu), &only);
    if (const int refused = pthread_setaffinity_np(pthread_self(), sizeof only, &only); refused != 0) {
      return std::string("thread ") + name + " was not given processor " + std::to_string(cpu) + " (" +
             std::strerror(refused) + "): choose one that this machine has, or -1";
    }
  }
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  if (refused == 0) return {};
  return std::string("thread ") + name + " runs without SCHED_FIFO (" + std::strerror(refused) +
         "): other processes can delay it; grant CAP_SYS_NICE";
}

Metronome::Metronome(Nanoseconds period) : period_(period), next_(monotonic() + period) {}

Metronome::Woken Metronome::wait() {
  const timespec until{static_cast<time_t>(next_ / std::chrono::seconds{1}),
                       static_cast<long>((next_ % std::chrono::seconds{1}).count())};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
  Woken woken{.late = monotonic() - next_};
  next_ += period_;
  if (woken.late < period_) return woken;
  woken.missed = static_cast<std::uint64_t>(woken.late / period_);
  next_ += period_ * static_cast<std::int64_t>(woken.missed);
  return woken;
}

}  // namespace motionlab::service
