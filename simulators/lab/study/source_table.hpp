/// @file  What remains of the load's motion, and which error it comes from.
#pragma once

#include <string>

#include "simulators/lab/study/lab_run.hpp"

namespace motionlab::study {

/// Makes one source of error after the other ideal in the default world ("without it"), and lets each act
/// alone in a world without any ("alone"); one block for the thesis wave and the sea, with the
/// platform body tracked and not. Seed, length, files and settings are `base`'s.
[[nodiscard]] std::string source_table(const LabRun& base);

}  // namespace motionlab::study
