/// @file  The fault matrix as a file: written, read, and held against what was recorded before.
#pragma once

#include <string>
#include <vector>

#include "simulators/lab/fault_matrix/cell.hpp"
#include "simulators/lab/fault_matrix/outcome.hpp"

namespace motionlab::matrix {

struct Entry {
  Cell cell;
  Outcome outcome;
};
using Matrix = std::vector<Entry>;

/// One line for each cell, null where nothing is known. The same matrix is the same bytes.
[[nodiscard]] std::string to_json(const Matrix& matrix);
/// @throws StartupError when the text is not what `to_json` writes
[[nodiscard]] Matrix from_json(const std::string& text);

/// What must not be in any matrix, one sentence for each offence: a gateway that was not in the cell's state,
/// a limit exceeded, something that moved by itself, an arm that nobody could stop. Excepted is what a robot
/// computer with the published program does and nobody on our side can help: it runs on when it hears
/// nothing, and moves as fast as bytes tell it that we did not send.
[[nodiscard]] std::vector<std::string> offences(const Matrix& matrix);

/// Where `now` is worse than `recorded`, one sentence for each cell: it ends otherwise, is not there or not
/// recorded, or is worse by more than a margin: detected later by a quarter and 50 ms, at rest later by a
/// quarter and 100 ms, joints faster by a quarter and 5 % of the
/// limit, swing larger by a quarter and half a degree at most, a quarter and 0.05° rms where it
/// was ridden through.
[[nodiscard]] std::vector<std::string> worse(const Matrix& now, const Matrix& recorded);

}  // namespace motionlab::matrix
