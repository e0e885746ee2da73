/// @file  `motionlab delay`: percentiles of the time from a device's measurement to a reader on the bus, hop
/// by hop.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gateway/monitor/delay_meter.hpp"
#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct DelayCommand {
  double window_s = 5;  ///< how long to measure, from the first sample on
  bool json = false;
};

/// @param far  hosts other than this one that write what was measured; empty when everything is on this host
[[nodiscard]] std::string delay_text(const std::vector<HopDelay>& hops, const std::vector<std::string>& far);
[[nodiscard]] nlohmann::ordered_json delay_json(const std::vector<HopDelay>& hops,
                                                const std::vector<std::string>& far);

/// Listens to every topic that is written in a rhythm.
/// @returns kExitGood; kExitNobody when nothing with a stamp came within the connection's timeout
int run_delay(const Connection& connection, const DelayCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
