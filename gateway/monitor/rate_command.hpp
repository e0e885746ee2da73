/// @file  `motionlab rate`: how fast a topic is, how evenly, and what is missing of it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "gateway/monitor/rate_meter.hpp"
#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct RateCommand {
  std::string topic;
  double window_s = 5;                 ///< end of the measurement, counted from the first sample
  std::optional<std::uint64_t> count;  ///< or after so many samples, whichever comes first
  std::optional<double> at_least_hz;   ///< on the bus; slower or unmeasurable is a failure
  bool json = false;
};

[[nodiscard]] std::string rate_text(const std::string& topic, const TopicDescription& description,
                                    const RateMeter& meter, const RateReport& report);
[[nodiscard]] nlohmann::ordered_json rate_json(const std::string& topic, const TopicDescription& description,
                                               const RateMeter& meter, const RateReport& report);

/// An interruption ends the measurement early; what was heard until then is told.
/// @returns kExitGood; kExitWrong when an instance is slower than `at_least_hz`; kExitNobody when nothing
/// came within
///          the connection's timeout
/// @throws StartupError  no such topic; no connection
int run_rate(const Connection& connection, const RateCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
