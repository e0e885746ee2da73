/// @file  `motionlab-study --fault-matrix`: its options, and what it does with them.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "simulators/lab/study/lab_run.hpp"

namespace motionlab::study {

/// The options that only the fault matrix has.
struct FaultMatrixWords {
  bool run = false;
  std::string only;      ///< DEVICE or DEVICE:FAULT; empty: everything
  std::string recorded;  ///< a report that is taken instead of a run; empty: it is run
  std::string bounds;    ///< a report that it must not be worse than; empty: none
  bool markdown = false;

  void add_to(CLI::App& app);
  [[nodiscard]] bool wanted() const { return run; }
};

/// Runs the matrix or reads it, writes it to `report` (empty: standard output) as JSON or Markdown, and
/// tells on standard error what is wrong with it.
/// @returns what the program returns: 0, or 1 when something is wrong. @throws StartupError
[[nodiscard]] int fault_matrix(const CLI::App& app, const LabRun& base, const FaultMatrixWords& words,
                               const std::string& report);

}  // namespace motionlab::study
