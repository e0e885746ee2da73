/// @file  `motionlab settle|engage|reset|authority`: asks the gateway for a mode and waits until it is so.
#pragma once

#include <cstdint>
#include <optional>

#include "gateway/monitor/session.hpp"
#include "idl/mode_request.hpp"

namespace motionlab::monitor {

struct ModeCommand {
  topic::ModeAction action = topic::ModeAction::settle;
  topic::Authority authority{};       ///< authority only: the wanted one
  double wait_ready_s = 0;            ///< engage only: how long to wait for `ready` before asking
  std::optional<std::int64_t> at_ns;  ///< engage only: laboratory time before which is not asked
  bool json = false;
};

/// Sends the request again and again until the mode shows its effect, because a request that is written
/// before the gateway has matched the writer is lost. The repetitions carry one sequence number.
///
/// A reset goes on asking for two seconds when it is refused, because that is so while the arm still brakes.
/// A settle leaves at once and every 20 ms, also to a gateway whose mode was not heard yet. The others wait
/// for the mode first.
/// @returns kExitGood when granted, kExitWrong with the gateway's reason, kExitNobody without any mode
int run_mode(const Connection& connection, const ModeCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
