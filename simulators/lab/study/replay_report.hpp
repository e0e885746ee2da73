/// @file  The report of a replay.
#pragma once

#include <string>

#include "gateway/service/replay.hpp"

namespace motionlab::study {

/// As JSON: steps, outputs_compared, equal, cut_off, version, and the first difference or null.
[[nodiscard]] std::string replay_json(const service::ReplayOutcome& outcome);

}  // namespace motionlab::study
