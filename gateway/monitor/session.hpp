/// @file  What the commands of `motionlab` have in common: how to reach the gateway, where to write, how to
/// end.
#pragma once

#include <atomic>
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/bus/wakeup.hpp"

namespace motionlab::monitor {

/// How the process ends; scripts rely on it.
enum ExitCode : int {
  kExitGood = 0,
  kExitWrong = 1,   ///< somebody answered, but something is wrong or the gateway said no
  kExitNobody = 2,  ///< nobody answered
  kExitUsage = 64,  ///< the command line or the connection makes no sense
  kExitInterrupted = 130,
};

/// How to reach the gateway.
struct Connection {
  int domain = 42;
  std::vector<std::string> interfaces;  ///< addresses of this host; empty: all of them
  std::vector<std::string> peers;       ///< addresses of other hosts; empty: they are found by multicast
  std::string server;                   ///< address:port of a discovery server; empty: none
  std::string security;  ///< folder with an identity of DDS Security; empty: nothing is protected
  double timeout_s = 5;  ///< how long to wait for an answer
};

/// Where a command writes and how it learns that the user has had enough.
struct Terminal {
  std::ostream& out;
  std::ostream& err;
  bool colour;
  const std::atomic<bool>& interrupted;
  bool progress = false;  ///< `err` is a terminal: long work may show there how far it is
};

/// As every command reaches DDS.
[[nodiscard]] bus::DdsConfig dds_config(const Connection& connection, bool join_truth = false);

/// One participant with a bus of its own. Choose topics of `dds`, then `dds.start()`.
struct Session {
  /// @throws StartupError  unknown interface, bad domain
  explicit Session(const Connection& connection, bool join_truth = false);

  RealClock clock;
  bus::LocalBus local;
  bus::DdsBus dds;
  std::shared_ptr<bus::Wakeup> wakeup = std::make_shared<bus::Wakeup>();
};

/// "nobody answers …", with what to look at.
[[nodiscard]] std::string nobody_answers(const Connection& connection, double waited_s);

/// user@host, for requests. Longer names are cut where they enter a topic.
[[nodiscard]] std::string requester_name();

}  // namespace motionlab::monitor
