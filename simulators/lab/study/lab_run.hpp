/// @file  One scored run of the whole line in the simulated laboratory.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "gateway/monitor/report.hpp"
#include "idl/estimate.hpp"
#include "idl/mode.hpp"
#include "idl/truth_world.hpp"
#include "simulators/lab/lockstep/lockstep.hpp"

namespace motionlab::study {

/// What is to be run, in the words of the command line. Empty paths: the files that are found.
struct LabRun {
  std::string config;
  std::string world_config;
  std::string scenario = "thesis-wave";
  std::string controller = "ours";
  std::string estimator = "ours";
  std::string sensors = "real";
  std::string platform = "tracked";
  std::string differences = "on";
  std::string limits;              ///< which the sea has to keep, mechanical or plc; empty: as configured
  std::string reference = "hold";  ///< see ReferencePlan
  double reference_from_s = 30;    ///< when it begins to move
  std::string reference_frame = "world";  ///< what carries the reference; or em1500
  std::string second_ship;  ///< scenario of the second ship; empty: sea if it carries the reference, else as
                            ///< configured
  std::vector<std::string> faults;    ///< as PlannedFault::parse takes them
  std::vector<std::string> settings;  ///< as Settings::parse takes them
  std::string record;                 ///< file for the control thread's inputs; empty: as configured
  std::uint64_t seed = 1;
  double seconds = 60;
  double engage_at_s = 10;
  double score_from_s = 20;
  bool timing = false;
};

/// What came of it.
struct LabOutcome {
  monitor::Report report;
  bool engaged_at_end = false;
  /// The farthest that it went from engaged after it was; engaged if it stayed.
  topic::ModeState worst_mode = topic::ModeState::engaged;
  std::string fault_code;             ///< the first that was latched; empty: none
  double beyond_angle_limit_rad = 0;  ///< how far a joint truly went past the guard's limits; 0: never
  double share_of_speed_limit =
      0;  ///< largest true joint speed over the guard's limit, of the crane's joints
  double last_load_error_max_m = 0;  ///< in the last 15 s
};

/// Files, names and differences put together. @throws StartupError with what to write instead
[[nodiscard]] lockstep::Config configure(const LabRun& run);

/// Sees a run go by: the truth of every millisecond, and the newest estimate, null before the first.
using LabObserver = std::function<void(const topic::TruthWorld&, const topic::Estimate*)>;

/// Runs it on a virtual clock: the same run gives the same bytes. @throws StartupError
[[nodiscard]] LabOutcome run_lab(const LabRun& run, const LabObserver& observer = {});

/// Runs many, two at a time; the outcomes are those of `run_lab`, in order.
[[nodiscard]] std::vector<LabOutcome> run_labs(const std::vector<LabRun>& runs);

}  // namespace motionlab::study
