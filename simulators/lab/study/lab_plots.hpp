/// @file  Ours beside the thesis' figures: the whole line in the simulated laboratory.
#pragma once

#include <array>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "simulators/lab/study/lab_run.hpp"
#include "simulators/lab/study/plot.hpp"

namespace motionlab::study {

/// One moment of a run in the laboratory.
struct LabMoment {
  topic::TruthWorld truth;
  topic::Estimate estimate;  ///< not valid before the first
};

/// A run in the laboratory, thinned.
struct LabRecording {
  std::vector<double> t_s;
  std::vector<LabMoment> moments;
  LabOutcome outcome;
  std::array<double, 3> p_world_load_set_m{};
};

/// Runs of which several figures show something. Each is made when it is first asked for.
class LabRecordings {
 public:
  explicit LabRecordings(const LabRun& base) : base_(base) {}

  /// The scenario with a camera body on the platform (`tracked`) or not (`untracked`). @throws StartupError
  [[nodiscard]] const LabRecording& of(std::string_view scenario, std::string_view platform,
                                       std::string_view controller = "ours");
  [[nodiscard]] const LabRun& base() const { return base_; }

 private:
  LabRun base_;
  std::map<std::string, LabRecording> made_;
};

/// Swing angles and the load's distance from its place, with and without control.
[[nodiscard]] Plot lab_load(LabRecordings& lab, std::string_view scenario);
/// What is left of both, on logarithmic axes, tracked and untracked, the thesis' integral control beside.
[[nodiscard]] Plot lab_rest(LabRecordings& lab, std::string_view scenario);
/// The error of the estimated load and what the estimator thinks of it.
[[nodiscard]] Plot lab_estimate(LabRecordings& lab, std::string_view scenario);
/// How arm and winch move for it.
[[nodiscard]] Plot lab_effort(LabRecordings& lab, std::string_view scenario);

}  // namespace motionlab::study
