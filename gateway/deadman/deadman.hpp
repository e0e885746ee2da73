/// @file  The deadman: a process that brings arm and winch to rest when the gateway cannot any more.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/core/time.hpp"
#include "gateway/deadman/page/lifeline.hpp"
#include "gateway/deadman/settlement.hpp"

namespace motionlab::deadman {

struct Config {
  WireConfig wires;
  Nanoseconds io_silent_after = 20ms;
  Nanoseconds control_silent_after = 200ms;
};

/// Forks the deadman. Call it while the process has one thread and no socket: the child gets a copy of all
/// that is open, and of this thread alone.
///
/// The child never returns from here. It watches (see DeadmanWatch) until the gateway says that all is at
/// rest and it may go. A gateway that is silent is killed, so that it never wakes up again; then, and when it
/// is gone for any other reason, the arm is braked from its port and the winch is settled. It ignores every
/// signal that ends a service or a terminal's programs, is its own session, and asks for a priority above the
/// gateway's and for locked memory. Before a gateway has sent anything its end needs nobody.
/// @param say  the log: called in the child, and not before the arm has been braked; in the parent never
/// @returns the gateway's end
/// @throws StartupError when the kernel refuses a process, a pipe, a page or a pidfd
[[nodiscard]] std::unique_ptr<Lifeline> fork_deadman(const Config& config,
                                                     const std::function<void(const std::string&)>& say);

}  // namespace motionlab::deadman
