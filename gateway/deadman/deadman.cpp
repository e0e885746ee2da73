#include "gateway/deadman/deadman.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <new>
#include <utility>

extern "C" {  // glibc 2.36 forgot to say so itself
#include <sys/pidfd.h>
}

#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"
#include "gateway/deadman/deadman_watch.hpp"

namespace motionlab::deadman {
namespace {

/// Above the gateway's threads: who is late by them must not be late itself.
constexpr int kPriority = 90;
/// How long the gateway's port may stay taken after its end before we speak from another.
constexpr auto kPortPatience = std::chrono::milliseconds{200};
/// A process whose pipe is closed and that still holds the port after this is ended.
constexpr auto kLeavingPatience = std::chrono::milliseconds{100};

using Monotonic = std::chrono::steady_clock;

[[noreturn]] void refuse(const char* what) {
  throw StartupError(std::string("no deadman can be started, and without one nothing may move: ") + what +
                     " is refused (" + std::strerror(errno) + "); raise the limit of processes or files");
}

/// Everything the child has of its gateway.
class Watcher {
 public:
  Watcher(const Config& config, Page& page, File pipe, File gateway)
      : config_(config),
        page_(page),
        pipe_(std::move(pipe)),
        gateway_(std::move(gateway)),
        look_period_(std::clamp<Nanoseconds>(config.io_silent_after / 10, 1ms, 10ms)),
        settlement_(config.wires, clock_) {}

  /// Until the gateway has ended, one way or the other. @returns why, and what was done about it
  std::string run() {
    DeadmanWatch watch({.look_period = look_period_,
                        .io_silent_after = config_.io_silent_after,
                        .control_silent_after = config_.control_silent_after});
    for (;;) {
      const bool gone = wait();
      page_.deadman_ticks.fetch_add(1, std::memory_order_relaxed);
      switch (watch.look(monotonic(), sight(gone))) {
        case Verdict::alive:
          break;
        case Verdict::ended:
          return {};
        case Verdict::gone:
          return take_over("the gateway is gone");
        case Verdict::io_silent:
          kill_gateway();
          return take_over("the gateway's io thread was silent, the gateway was ended");
        case Verdict::control_silent:
          kill_gateway();
          return take_over("the gateway's control thread was silent, the gateway was ended");
      }
    }
  }

 private:
  static LabTime monotonic() { return LabTime{Monotonic::now().time_since_epoch()}; }

  /// Sleeps for one look, or until the gateway is gone. @returns whether it is
  bool wait() const {
    std::array<pollfd, 2> ends{{{pipe_.fd(), 0, 0}, {gateway_.fd(), POLLIN, 0}}};
    const timespec period{0, static_cast<long>(look_period_.count())};
    (void)::ppoll(ends.data(), ends.size(), &period, nullptr);
    return ends[0].revents != 0 || ends[1].revents != 0;
  }

  [[nodiscard]] Sight sight(bool gone) const {
    return {.phase = page_.phase.load(std::memory_order_acquire),
            .io_beats = page_.io_beats.load(std::memory_order_relaxed),
            .control_beats = page_.control_beats.load(std::memory_order_relaxed),
            .gone = gone};
  }

  /// By its pidfd: never the one who has got its number meanwhile. Stopped or not, it does not come back.
  void kill_gateway() const { (void)::pidfd_send_signal(gateway_.fd(), SIGKILL, nullptr, 0); }

  std::string take_over(const std::string& why) {
    const auto last = page_.sent.read();
    if (!last) return {};  // nobody was ever told to move
    take_port();
    settlement_.begin(Said{last->value.command, Nanoseconds{Monotonic::now().time_since_epoch()} -
                                                    Nanoseconds{last->value.t_monotonic_ns}});
    return why + "; " + settlement_.finish().text(config_.wires);
  }

  /// The gateway's port as soon as the kernel has taken it back; any other if that does not come.
  void take_port() {
    const auto begun = Monotonic::now();
    for (;;) {
      const auto waited = Monotonic::now() - begun;
      if (waited > kLeavingPatience) kill_gateway();
      try {
        const Endpoint port = config_.wires.listen;
        settlement_.open(waited < kPortPatience ? port : Endpoint{});
        return;
      } catch (const StartupError&) {
        const timespec pause{0, 200'000};
        ::nanosleep(&pause, nullptr);
      }
    }
  }

  const Config& config_;
  Page& page_;
  File pipe_;
  File gateway_;
  Nanoseconds look_period_;
  RealClock clock_;
  Settlement settlement_;
};

/// What ends services and terminals' programs does not end us, nor a log that nobody reads, nor the watchdog
/// of systemd that ends a hanging gateway: it sends SIGABRT to every process of the service. An abort() of
/// our own still ends us.
void ignore_signals() {
  for (const int signal : {SIGABRT, SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE, SIGTSTP, SIGUSR1, SIGUSR2}) {
    std::signal(signal, SIG_IGN);
  }
}

/// Where the kernel grants it; the gateway says what it refused, and it refuses both alike.
void become_urgent() {
  ::prctl(PR_SET_NAME, "deadman");
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  sched_param wanted{};
  wanted.sched_priority = kPriority;
  (void)::sched_setscheduler(0, SCHED_FIFO, &wanted);
  (void)::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT);
}

[[noreturn]] void live(const Config& config, Page& page, File pipe, File gateway,
                       const std::function<void(const std::string&)>& say) {
  int code = 0;
  try {
    ::setsid();
    ignore_signals();
    become_urgent();
    const std::string done = Watcher(config, page, std::move(pipe), std::move(gateway)).run();
    if (!done.empty()) say(done);
  } catch (const std::exception& error) {
    code = 1;
    say(std::string("the deadman has ended by itself: ") + error.what());
  }
  ::_exit(code);  // what the gateway's libraries want to do at an exit is not ours to do
}

Page& shared_page() {
  void* const memory =
      ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS | MAP_POPULATE, -1, 0);
  if (memory == MAP_FAILED) refuse("a page of shared memory");
  return *new (memory) Page;  // given back by the kernel when both processes have ended
}

}  // namespace

std::unique_ptr<Lifeline> fork_deadman(const Config& config,
                                       const std::function<void(const std::string&)>& say) {
  Page& page = shared_page();
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) refuse("a pipe");
  File watched(ends[0]);
  File held(ends[1]);
  File gateway(::pidfd_open(::getpid(), 0));
  if (gateway.fd() < 0) refuse("a pidfd");
  const pid_t pid = ::fork();
  if (pid < 0) refuse("a process");
  if (pid == 0) {
    { const File closed = std::move(held); }
    live(config, page, std::move(watched), std::move(gateway), say);
  }
  File deadman(::pidfd_open(pid, 0));
  if (deadman.fd() < 0) refuse("a pidfd");
  return std::make_unique<Lifeline>(page, std::move(held), std::move(deadman));
}

}  // namespace motionlab::deadman
