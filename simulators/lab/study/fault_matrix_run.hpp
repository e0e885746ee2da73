/// @file  Runs every fault of every device in every state of the gateway, in lockstep.
#pragma once

#include <string>

#include "simulators/lab/fault_matrix/report.hpp"
#include "simulators/lab/study/lab_run.hpp"

namespace motionlab::study {

/// Files, seed and settings are `base`'s. `only`: DEVICE or DEVICE:FAULT; empty: everything.
/// @throws StartupError when `only` names nothing that there is
[[nodiscard]] matrix::Matrix run_fault_matrix(const LabRun& base, const std::string& only);

}  // namespace motionlab::study
