/// @file  Runs a recorded run again and looks whether it comes out the same.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "drivers/core/time.hpp"

namespace motionlab::service {

/// Where a replay first went another way than its recording.
struct Difference {
  std::uint64_t step = 0;
  LabTime t{};
  std::string topic;     ///< empty: only the checksum of that step's outputs tells, no later sample was kept
  std::string field;     ///< "qd_command_radps[2]"; empty when a whole sample is missing, or one too many
  std::string recorded;  ///< its value in the recording
  std::string replayed;
  std::uint64_t since_step = 0;  ///< the first step that differs; before `step` if only few samples are kept
};

struct ReplayOutcome {
  std::uint64_t steps = 0;             ///< taken
  std::uint64_t outputs_compared = 0;  ///< whole samples, besides the checksum of each step
  /// The recording ends early, as when its writer died: replayed up to there. Not told beside a difference,
  /// which ends the reading.
  bool cut_off = false;
  std::string version;  ///< which wrote it
  std::optional<Difference> difference;
};

/// Takes the snapshots of a recording through estimator, controller and guard, built from the configuration
/// in the file, and compares what they publish bit by bit. Stops at the first difference that it can name; a
/// step of which no sample was kept is known by its checksum.
///
/// @throws StartupError when the file is no recording of a run, is damaged, has gaps or does not begin at the
/// first step, with the reason
[[nodiscard]] ReplayOutcome replay(const std::filesystem::path& file);

/// As a sentence or two for people.
[[nodiscard]] std::string describe(const ReplayOutcome& outcome);

}  // namespace motionlab::service
