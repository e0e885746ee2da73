/// @file  The report of a run: what it holds, and the one text that it has.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gateway/monitor/motion_score.hpp"

namespace motionlab::monitor {

/// Where the positions and angles of a score come from.
enum class Source { truth, estimate };

/// What was run, in words. An empty text is null in the report: not known or without meaning for this run.
struct RunLabels {
  std::string scenario;
  std::string controller = "ours";
  std::string estimator = "ours";
  std::string sensors = "real";
  std::optional<std::uint64_t> seed;
  std::string world = "lab";
  std::string frame = "world";
  std::string gains;
  std::string platform;
  std::string reference_frame;
  std::string limits;
};

/// Three numbers of a distribution.
struct Spread {
  double p50 = 0;
  double p99 = 0;
  double max = 0;
};

/// One fault, in seconds of the run.
struct FaultReport {
  double t_s = 0;
  std::string fault;
  std::string code;  ///< that the gateway latched; empty: it did not notice
  std::optional<double> detected_after_s;
  std::optional<double> at_rest_after_s;  ///< since t_s
};

/// How near the samples of a device came to being stale, since the gateway's start.
struct Freshness {
  std::string device;
  double age_max_s = 0;
  double stale_after_s = 0;
};

/// Everything that was found out about a run. Nothing where nothing was seen.
struct Report {
  RunLabels labels;
  double duration_s = 0;
  double score_from_s = 0;
  Source source = Source::truth;
  std::optional<MotionScore> motion;
  std::optional<double> settling_time_s;
  std::optional<std::array<double, 6>> joint_speed_max_degps;
  std::optional<double> winch_speed_max_mps;
  std::array<std::uint64_t, 6>
      limited{};  ///< control samples of the window in which the guard held a joint back
  std::optional<MotionScore> baseline;  ///< the uncontrolled twin
  std::optional<double> baseline_settling_time_s;
  std::optional<Spread> age_at_actuation_us;
  std::optional<Spread> step_time_us;
  std::vector<FaultReport> faults;
  std::vector<Freshness> freshness;
};

/// 1 - value / baseline; nothing without a baseline that moves.
[[nodiscard]] std::optional<double> reduction(double value, double baseline);

/// The report as JSON: always the same keys in the same order, null where nothing is known, every number with
/// as many digits as bring the same bits back. The same report is the same bytes.
[[nodiscard]] std::string to_json(const Report& report);

}  // namespace motionlab::monitor
