/// @file  `motionlab replay`
#pragma once

#include <string>
#include <vector>

#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct ReplayCommand {
  std::string file;
  std::vector<std::string> topics;  ///< "mru" for short; empty: all that ask nobody for anything
  double speed = 1;
};

/// Says the recorded samples again, byte for byte, at the pace at which they were heard.
///
/// Nothing recorded may move a robot. So nothing at all is said in a domain in which a gateway lives, and the
/// replay ends at once when one appears; and what asks for something (commands, requests, references) is said
/// only when it is named in `topics`.
/// @throws StartupError  no such file, no such topic, no DDS
int run_replay(const Connection& connection, const ReplayCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
