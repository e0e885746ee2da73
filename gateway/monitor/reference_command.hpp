/// @file  `motionlab reference`: tells the gateway where the load shall be, or shows where it is told to be.
#pragma once

#include <array>
#include <optional>

#include "gateway/monitor/session.hpp"
#include "idl/reference.hpp"

namespace motionlab::monitor {

struct ReferenceCommand {
  std::optional<std::array<double, 3>> p_world_load_m;  ///< nothing: only show
  bool by = false;  ///< the place is relative to where the load is estimated to be now, world axes
  topic::ReferenceFrame frame = topic::ReferenceFrame::world;
  double wait_s = 0;       ///< then wait so long until the load is there
  double within_m = 0.02;  ///< what "there" means
  bool json = false;
};

/// A place that stands still. It is sent until the gateway has it; a gateway that is not engaged takes it as
/// well and uses it when it is. The guard of the gateway has the last word.
/// @returns kExitGood; kExitWrong when the load did not arrive within `wait_s`; kExitNobody when no gateway
/// listens, or
///          the estimate that `by` and `wait_s` need is not there
int run_reference(const Connection& connection, const ReferenceCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
