/// @file  The command line of `motionlab`.
#pragma once

#include <functional>
#include <vector>

#include "gateway/monitor/session.hpp"

namespace CLI {
class App;
}

namespace motionlab::monitor {

/// What stands before or after the name of any command.
struct Common {
  Connection connection;
  bool json = false;
};

/// Runs the command that was chosen; returns the exit code.
using Run = std::function<int(const Terminal&)>;

/// Adds a command of a room above this one, which when it is chosen sets what is run. What it is given
/// outlives the reading of the command line.
using FurtherCommand = std::function<void(CLI::App& app, const Common& common, Run& run)>;

/// Reads the command line, runs one command and returns the exit code. Unknown words are errors.
int run_command_line(int argc, const char* const* argv, const Terminal& terminal,
                     const std::vector<FurtherCommand>& further = {});

}  // namespace motionlab::monitor
