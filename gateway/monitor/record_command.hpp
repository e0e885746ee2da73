/// @file  `motionlab record`
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct RecordCommand {
  std::string to;                   ///< a file or a folder; empty: a dated file here
  std::vector<std::string> topics;  ///< names of the house, "mru" for short; empty: all
  std::optional<double> seconds;    ///< nothing: until it is interrupted
  std::string config;               ///< the gateway's: attached, with its overlays as gateway.toml too
  std::vector<std::string> overlays;
  std::vector<std::string> attachments;  ///< any other files
  std::uint64_t split_mb = 1024;
  std::uint64_t disk_mb = 0;          ///< 0: no limit
  std::vector<std::string> on_event;  ///< severities or codes; empty: everything is recorded
  double before_s = 10, after_s = 10;
  bool json = false;
};

/// Records until the time is over, until it is interrupted or until the disk takes no more. Tells systemd,
/// where that started it, that it is ready, that it lives, and how far it is.
/// @throws StartupError  no such topic, no DDS, a file that cannot be read or made
int run_record(const Connection& connection, const RecordCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
