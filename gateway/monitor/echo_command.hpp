/// @file  `motionlab echo`: the samples of one topic, as text, JSON lines or CSV.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct EchoCommand {
  enum class Format { text, json, csv };

  std::string topic;
  std::vector<std::string> fields;     ///< paths; empty: all
  std::optional<std::string> device;   ///< only samples whose field `device` is so
  std::optional<std::uint64_t> count;  ///< end after so many
  Format format = Format::text;
};

/// The quality of service is what all writers offer, so a best-effort writer is heard and a kept sample is
/// got. Samples that are no sample of the type are told on standard error, once for each reason.
///
/// Ends after `count`, or when interrupted, or when nothing came within the connection's timeout; once
/// something came it waits for more as long as it takes.
/// @returns kExitGood when something was shown; kExitNobody when nothing came; kExitWrong when `count` is not
/// complete
///          because it was interrupted; kExitInterrupted when that was before the first sample
/// @throws StartupError  no such topic, field or device; no connection
int run_echo(const Connection& connection, const EchoCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
