/// @file  `motionlab export`
#pragma once

#include <string>
#include <vector>

#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct ExportCommand {
  std::string file;
  bool csv = false;                 ///< the one form that there is
  std::vector<std::string> topics;  ///< "mru" for short; empty: all
  std::string folder;               ///< empty: named like the file, beside it
};

/// One CSV a topic, "motionlab_mru.csv": the time it was heard, the time it was written, and the fields with
/// their names, and with them their units, from the IDL. One sample a line, in the order of the file. Topics
/// that are none of the house are named and left out.
/// @throws StartupError  no such file, no such topic; a CSV of that name exists already
int run_export(const ExportCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
