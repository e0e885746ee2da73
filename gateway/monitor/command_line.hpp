/// @file  The command line of `motionlab`.
#pragma once

#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

/// Reads the command line, runs one command and returns the exit code. Unknown words are errors.
int run_command_line(int argc, const char* const* argv, const Terminal& terminal);

}  // namespace motionlab::monitor
