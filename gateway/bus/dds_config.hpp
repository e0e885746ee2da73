/// @file  How a program reaches DDS.
#pragma once

#include <string>
#include <vector>

namespace motionlab::bus {

/// Others are found by multicast, unless `peers` or `server` says another way.
struct DdsConfig {
  int domain = 42;                               ///< 0…232
  std::vector<std::string> interface_whitelist;  ///< addresses of this host to use; empty: all of them
  std::string participant = "motionlab";         ///< the name that DDS tools show
  bool join_truth = false;                       ///< simulator and viewers only; the gateway never does
  std::vector<std::string> peers{};  ///< addresses of the other hosts, where the network carries no multicast
  std::string server{};              ///< address:port of a discovery server that knows everybody; empty: none
  std::string security{};            ///< folder with an identity of DDS Security; empty: nothing is protected
};

}  // namespace motionlab::bus
