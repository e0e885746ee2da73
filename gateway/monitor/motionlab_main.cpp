/// @file  `motionlab`: the user's hand.
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <iostream>

#include "gateway/monitor/command_line.hpp"

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may write it");

}  // namespace

int main(int argc, char** argv) {
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second Ctrl-C ends it at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  const bool colour = isatty(STDOUT_FILENO) == 1;
  return motionlab::monitor::run_command_line(argc, argv, {std::cout, std::cerr, colour, interrupted});
}
