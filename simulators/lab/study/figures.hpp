/// @file  The thesis' result figures (4.20–4.40, 5.1–5.13) computed anew, ours beside them, and a page about
/// them.
#pragma once

#include <filesystem>
#include <string>

#include "simulators/lab/study/lab_run.hpp"

namespace motionlab::study {

/// Writes NAME.svg and NAME.gp of every figure and index.html. Files of these names are replaced; the same
/// options give the same bytes.
///
/// Seed, length, files and settings of the figures of the laboratory are `lab`'s; those of the thesis have
/// their own.
/// @throws StartupError when the folder cannot be made or written to, or gnuplot is missing or fails
void write_figures(const std::filesystem::path& folder, const LabRun& lab);

/// Names and titles, for `--list`.
[[nodiscard]] std::string describe_figures();

}  // namespace motionlab::study
