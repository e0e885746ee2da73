/// @file  `motionlab score`: watches a run, one line a second, and ends with the report.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "gateway/monitor/report.hpp"
#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

struct ScoreCommand {
  RunLabels labels;                      ///< what is not known here is said by whoever started the run
  std::optional<double> seconds;         ///< end of the run; nothing: until interrupted
  double from_s = 20;                    ///< start of the scored window
  std::optional<std::int64_t> start_ns;  ///< laboratory time of second 0; nothing: the first sample seen
  std::string report_path;               ///< empty: no file
  bool json = false;  ///< the report on standard output as JSON, live lines on standard error
};

/// Scores by the simulated truth, which it joins read-only; when there is none but an estimate, by that.
/// Also publishes `motionlab/score` once a second.
///
/// Ends after `seconds` of the run, or when its time source has been silent for the connection's timeout at a
/// time when the run should be over, or when interrupted: then with the report so far.
/// @returns kExitGood with a report; kExitWrong when nothing fell into the window or the file cannot be
///          written; kExitNobody when neither truth nor a valid estimate was heard
int run_score(const Connection& connection, const ScoreCommand& command, const Terminal& terminal);

}  // namespace motionlab::monitor
