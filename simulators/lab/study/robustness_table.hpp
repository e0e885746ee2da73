/// @file  What becomes of the load when the laboratory is not what the gateway believes, or things fail.
#pragma once

#include <string>

#include "simulators/lab/study/lab_run.hpp"

namespace motionlab::study {

/// Runs every disturbance alone, on top of the default world, for the thesis wave and the sea, with the
/// platform body tracked and not; one block for each. Seed, length, files and settings are `base`'s.
[[nodiscard]] std::string robustness_table(const LabRun& base);

}  // namespace motionlab::study
