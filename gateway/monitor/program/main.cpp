/// @file  `motionlab`: the user's hand.
#include <signal.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <iostream>
#include <string_view>

#include "gateway/doctor/doctor_command.hpp"
#include "gateway/monitor/command_line.hpp"

namespace {

/// Whether the environment says anything under this name.
bool said(const char* name) {
  const char* const value = std::getenv(name);
  return value && *value != '\0';
}

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may write it");

}  // namespace

int main(int argc, char** argv) {
  struct sigaction action {};
  action.sa_handler = [](int) { interrupted = true; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second Ctrl-C ends it at once
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  const char* const term = std::getenv("TERM");
  const bool dumb = term && std::string_view{term} == "dumb";
  const bool colour = isatty(STDOUT_FILENO) == 1 && !dumb && !said("NO_COLOR");
  const bool progress = isatty(STDERR_FILENO) == 1 && !dumb;
  return motionlab::monitor::run_command_line(argc, argv,
                                              {std::cout, std::cerr, colour, interrupted, progress},
                                              {motionlab::doctor::doctor_command()});
}
