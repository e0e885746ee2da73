/// @file  The fault matrix for people.
#pragma once

#include <string>

#include "simulators/lab/fault_matrix/report.hpp"

namespace motionlab::matrix {

/// Markdown: how to read it, one table for each device (the arm's for each program), what follows from it.
[[nodiscard]] std::string to_markdown(const Matrix& matrix);

}  // namespace motionlab::matrix
