/// @file  `Scorer`: watches a run on its topics and says how still the load was.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "drivers/core/time.hpp"
#include "gateway/monitor/fault_log.hpp"
#include "gateway/monitor/motion_score.hpp"
#include "gateway/monitor/quantiles.hpp"
#include "gateway/monitor/report.hpp"
#include "idl/arm_state.hpp"
#include "idl/control.hpp"
#include "idl/estimate.hpp"
#include "idl/health.hpp"
#include "idl/mode.hpp"
#include "idl/reference.hpp"
#include "idl/score.hpp"
#include "idl/truth_world.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::monitor {

struct ScorerConfig {
  RunLabels labels{};
  Source source = Source::truth;
  /// The set points, in world: tool at home with the platform at neutral, and 2 m of wire below it.
  std::array<double, 3> p_world_load_m{0.847625, -0.407825, 3.919269};
  std::array<double, 3> p_world_tool_m{0.847625, -0.407825, 5.919269};
  /// When the run began. Nothing: with the first sample of the source.
  std::optional<LabTime> t_start{};
  double score_from_s = 20;            ///< start of the scored window, in seconds of the run
  std::optional<double> score_to_s{};  ///< its end; nothing: it stays open
  bool timing = true;  ///< false: `step_time_us` is null, so that lockstep reports are repeatable
};

/// Collects samples in any order of topics, each topic in the order of its time, and tells the score so far.
///
/// Samples whose stamp lies in the window [score_from_s, score_to_s] are scored. Before the first sample of
/// the source there is no time base, and everything but `Mode`, `Reference` and `Health` is left out. The
/// memory is bounded (about 4 MiB). One thread.
///
/// What each number means:
/// * swing and errors: from the source, means over samples (see `MotionStatistics`). The load's set point
///   follows `Reference`, and the tool's moves along; the uncontrolled twin is told nothing, so its set point
///   stays.
/// * settling time: since the last engagement, or since the start when there was none (see `Settling`), over
///   the whole run.
/// * joint and winch speeds: what the devices report.
/// * age at actuation: of the MRU data, at the control steps whose command asks the robot to follow; to 1 µs.
/// * step time: of all control steps in the window, to 0.1 µs. Over DDS these are a fifth of the steps.
/// * faults: see `FaultLog`, over the whole run.
class Scorer {
 public:
  explicit Scorer(const ScorerConfig& config);

  void take(const topic::TruthWorld& truth);   ///< left out unless the source is `truth`
  void take(const topic::Estimate& estimate);  ///< left out unless the source is `estimate`, or not valid
  void take(const topic::Control& control);
  void take(const topic::ArmState& arm);
  void take(const topic::WinchState& winch);
  void take(const topic::Mode& mode);
  void take(const topic::Reference& reference);
  void take(const topic::Health& health);

  /// A fault was caused at `t`. What the gateway latches next is taken for its consequence.
  void note_fault(LabTime t, std::string_view name) { faults_.caused(t, name); }
  /// The run lasted until `t`, even if no sample says so.
  void run_until(LabTime t);

  /// When the run began; nothing before the first sample unless it was configured.
  [[nodiscard]] std::optional<LabTime> t_start() const { return t_start_; }
  /// Seconds from the start to the newest sample of the source (or `run_until`), not beyond `score_to_s`.
  [[nodiscard]] double elapsed_s() const;
  /// When the newest sample of the source was; nothing before the first.
  [[nodiscard]] std::optional<LabTime> t_newest() const { return t_newest_; }

  /// How still it is. Numbers without a sample are 0, of the baseline NaN.
  [[nodiscard]] topic::Score live(LabTime now) const;
  [[nodiscard]] Report report() const;

 private:
  /// Whether a sample of this time is scored.
  [[nodiscard]] bool in_window(std::int64_t t_ns) const;
  /// Moves the time of the source on; false for a sample that is not newer than the last.
  bool moves_on(LabTime t);

  ScorerConfig config_;
  std::array<double, 3> p_WL_set_, p_WT_set_;
  std::optional<LabTime> t_start_, t_end_, t_newest_, t_engaged_;
  MotionStatistics motion_, baseline_;
  std::optional<MotionSample> newest_, newest_baseline_;
  Settling settling_, baseline_settling_;
  std::optional<std::array<double, 6>> qd_max_radps_;
  std::optional<double> wire_speed_max_mps_;
  std::array<std::uint64_t, 6> limited_{};
  Quantiles age_us_, step_us_;
  FaultLog faults_;
  std::vector<Freshness> freshness_;
};

}  // namespace motionlab::monitor
