/// @file  How a program reaches DDS.
#pragma once

#include <string>
#include <vector>

namespace motionlab::bus {

struct DdsConfig {
  int domain = 42;                               ///< 0…232
  std::vector<std::string> interface_whitelist;  ///< addresses of this host to use; empty: all of them
  std::string participant = "motionlab";         ///< the name that DDS tools show
  bool join_truth = false;                       ///< simulator and viewers only; the gateway never does
};

}  // namespace motionlab::bus
