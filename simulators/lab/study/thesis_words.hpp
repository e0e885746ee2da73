/// @file  The command line where the laboratory's world and the thesis' part.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "simulators/lab/study/lab_run.hpp"
#include "simulators/lab/thesis/scenario.hpp"

namespace motionlab::study {

/// Words that only the world of the thesis has a use for.
struct ThesisWords {
  std::string world = "lab";
  std::string frame = "world";
  std::string gains;

  [[nodiscard]] bool wanted() const { return world == "thesis"; }
  /// Adds their options.
  void add_to(CLI::App& app);
};

/// What the command line asks of the world of the thesis; options that were not given are the scenario's own.
/// @throws StartupError for options that only the laboratory's world has a use for
[[nodiscard]] thesis::Request thesis_request(const CLI::App& app, const LabRun& lab,
                                             const ThesisWords& words);

/// @throws StartupError when the laboratory's world is asked for what only the thesis' has
void refuse_thesis_words(const LabRun& lab, const ThesisWords& words);

}  // namespace motionlab::study
