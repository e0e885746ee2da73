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
#include <future>
#include <utility>

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

/// The calling thread gets what nobody else wants. @returns what was refused
std::string yield_to_all() {
  const sched_param none{};
  const int refused = pthread_setschedparam(pthread_self(), SCHED_IDLE, &none);
  if (refused == 0) return {};
  return std::string("SCHED_IDLE is refused (") + std::strerror(refused) +
         "): the control thread's processor sleeps between two steps";
}

/// One turn of a loop, with regard to the other half of the core.
void be_gentle() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("isb");
#endif
}

/// Names the calling thread, and binds it unless `cpu` is negative. @returns what was refused
std::string settle_on(const char* name, int cpu) {
  pthread_setname_np(pthread_self(), name);
  if (cpu < 0) return {};
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(static_cast<std::size_t>(cpu), &only);
  const int refused = pthread_setaffinity_np(pthread_self(), sizeof only, &only);
  if (refused == 0) return {};
  return std::string("thread ") + name + " was not given processor " + std::to_string(cpu) + " (" +
         std::strerror(refused) + "): choose one that this machine has, or -1";
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
  prctl(PR_SET_TIMERSLACK, 1UL);
  touch_stack();
  if (auto refused = settle_on(name, cpu); !refused.empty()) return refused;
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int refused = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  if (refused == 0) return {};
  return std::string("thread ") + name + " runs without SCHED_FIFO (" + std::strerror(refused) +
         "): other processes can delay it; grant CAP_SYS_NICE";
}

AwakeProcessor::AwakeProcessor(int cpu) {
  std::promise<std::string> told;
  auto refused = told.get_future();
  thread_ = std::jthread(
      [cpu](const std::stop_token& stop, std::promise<std::string> told_here) {
        std::string no = settle_on("awake", cpu);
        if (no.empty()) no = yield_to_all();
        const bool may = no.empty();
        told_here.set_value(std::move(no));
        while (may && !stop.stop_requested()) be_gentle();
      },
      std::move(told));
  refused_ = refused.get();
}

void leave_processor(int cpu) {
  cpu_set_t ours;
  if (cpu < 0 || cpu >= CPU_SETSIZE || pthread_getaffinity_np(pthread_self(), sizeof ours, &ours) != 0)
    return;
  CPU_CLR(static_cast<std::size_t>(cpu), &ours);
  if (CPU_COUNT(&ours) > 0) pthread_setaffinity_np(pthread_self(), sizeof ours, &ours);
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
