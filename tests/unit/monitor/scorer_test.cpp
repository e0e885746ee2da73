#include "gateway/monitor/scorer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/unit/monitor/samples.hpp"

namespace motionlab::monitor {
namespace {

using Json = nlohmann::ordered_json;
using topic::ModeState;

/// A run of 60 s at 1 kHz: engaged at 10 s, a big swing before and a small one after, each with whole periods
/// in the window.
void feed_run(Scorer& scorer, Nanoseconds offset = {}) {
  topic::Mode engaged = mode(ModeState::engaged, 10);
  engaged.t_changed_ns += offset.count();
  for (int ms = 0; ms <= 60'000; ++ms) {
    const double t_s = 1e-3 * ms;
    const double s = std::sin(2 * std::numbers::pi * t_s / 4);
    topic::TruthWorld truth = still(t_s);
    truth.t_ns += offset.count();
    truth.swing_rad[0] = (ms < 15'000 ? 4.0 : 0.04) * kRadPerDeg * s;
    truth.p_world_load_m[1] += (ms < 20'000 ? 5.0 : 0.005) * s;
    truth.p_world_tool_m[2] += 0.002 * s;
    truth.twin_swing_rad = {3 * kRadPerDeg * s, 4 * kRadPerDeg * s};
    truth.p_world_twin_load_m[0] += 0.5 * s;
    truth.p_world_twin_tool_m[2] += 0.1 * s;
    scorer.take(truth);
    if (ms == 10'000) scorer.take(engaged);
    topic::Control step = control(t_s, 0.1);
    step.t_snapshot_ns += offset.count();
    step.age_mru_s = 1e-6 * (2000 + ms % 100);
    step.step_time_us = 10 + 0.1 * (ms % 10);
    step.guard_changed = ms % 1000 == 0 ? 1u << 10 : 0;  // acceleration of joint 3
    scorer.take(step);
    topic::ArmState arm;
    arm.t_measured_ns = truth.t_ns;
    arm.qd_radps[4] = -0.5 * s;
    scorer.take(arm);
    topic::WinchState winch;
    winch.t_measured_ns = truth.t_ns;
    winch.wire_speed_mps = 0.02 * s;
    scorer.take(winch);
  }
}

TEST(Scorer, ScoresTheWindowByClosedForms) {
  Scorer scorer{{}};
  feed_run(scorer);
  const Report report = scorer.report();
  ASSERT_TRUE(report.motion && report.baseline);
  // The window has both its ends, so one sample more than whole periods: the last is zero.
  EXPECT_EQ(report.motion->samples, 40'001u);
  EXPECT_NEAR(report.motion->swing_rms_deg, 0.04 / std::sqrt(2), 1e-6);
  EXPECT_NEAR(report.motion->swing_max_deg, 0.04, 1e-9);
  EXPECT_NEAR(report.motion->load_error_rms_norm_m, 0.005 / std::sqrt(2), 1e-7);
  EXPECT_NEAR(report.motion->tool_error_rms_m[2], 0.002 / std::sqrt(2), 1e-7);
  EXPECT_NEAR(report.baseline->swing_rms_deg, 5 / std::sqrt(2), 1e-4);
  EXPECT_NEAR(report.baseline->load_error_rms_m[0], 0.5 / std::sqrt(2), 1e-5);
  EXPECT_NEAR(report.baseline->tool_error_rms_m[2], 0.1 / std::sqrt(2), 1e-5);
  EXPECT_NEAR((*report.joint_speed_max_degps)[4], degrees(0.5), 1e-9);
  EXPECT_EQ((*report.joint_speed_max_degps)[0], 0);
  EXPECT_NEAR(*report.winch_speed_max_mps, 0.02, 1e-9);
  EXPECT_EQ(report.limited, (std::array<std::uint64_t, 6>{0, 0, 41, 0, 0, 0}));
  EXPECT_EQ(report.duration_s, 60);
}

TEST(Scorer, CountsTheSettlingTimeFromTheEngagement) {
  Scorer scorer{{}};
  feed_run(scorer);
  // The big swing ends just before 15 s, on its way from -4 deg: the last sample is outside.
  EXPECT_NEAR(*scorer.report().settling_time_s, 4.999, 1e-9);
  EXPECT_FALSE(scorer.report().baseline_settling_time_s);
}

TEST(Scorer, CountsTheSettlingTimeFromTheStartWhenNeverEngaged) {
  Scorer scorer{{}};
  for (int ms = 0; ms <= 10'000; ++ms) {
    topic::TruthWorld truth = still(1e-3 * ms);
    truth.swing_rad[1] = (ms <= 3000 ? 2 : 0) * kRadPerDeg;
    scorer.take(truth);
  }
  EXPECT_EQ(scorer.report().settling_time_s, 3.0);
}

TEST(Scorer, TellsAgesAndStepTimesAsQuantiles) {
  Scorer scorer{{}};
  feed_run(scorer);
  const Report report = scorer.report();
  ASSERT_TRUE(report.age_at_actuation_us && report.step_time_us);
  EXPECT_EQ(report.age_at_actuation_us->p50, 2049);
  EXPECT_EQ(report.age_at_actuation_us->p99, 2098);
  EXPECT_EQ(report.age_at_actuation_us->max, 2099);
  EXPECT_EQ(report.step_time_us->p50, 10.4);
  EXPECT_EQ(report.step_time_us->max, 10.9);
}

TEST(Scorer, CountsAgesOnlyWhenTheRobotFollows) {
  Scorer scorer{{.score_from_s = 0}};
  scorer.take(still(0));
  topic::Control step = control(1, 0);
  step.following = false;
  step.age_mru_s = 0.5;
  scorer.take(step);
  EXPECT_FALSE(scorer.report().age_at_actuation_us);
  EXPECT_TRUE(scorer.report().step_time_us);
}

TEST(Scorer, IsSilentAboutStepTimesWithoutTiming) {
  ScorerConfig config;
  config.timing = false;
  Scorer scorer{config};
  feed_run(scorer);
  EXPECT_FALSE(scorer.report().step_time_us);
  EXPECT_TRUE(scorer.report().age_at_actuation_us);
}

TEST(Scorer, GivesTheSameBytesWheneverTheRunBegan) {
  Scorer here{{}}, there{{}}, again{{}};
  feed_run(here);
  feed_run(again);
  feed_run(there, Nanoseconds{1'790'000'000'123'456'789});
  EXPECT_EQ(to_json(here.report()), to_json(again.report()));
  EXPECT_EQ(to_json(here.report()), to_json(there.report()));
}

TEST(Scorer, TakesTheStartThatItIsTold) {
  ScorerConfig config;
  config.t_start = at(-5);
  config.score_from_s = 5;
  Scorer scorer{config};
  scorer.take(still(0));
  EXPECT_EQ(scorer.elapsed_s(), 5);
  EXPECT_EQ(scorer.report().motion->samples, 1u);
}

TEST(Scorer, LeavesOutWhatCameBeforeTheStart) {
  ScorerConfig config;
  config.t_start = at(10);
  config.score_from_s = 0;
  Scorer scorer{config};
  scorer.take(still(9));
  EXPECT_FALSE(scorer.report().motion);
}

TEST(Scorer, LeavesOutWhatLiesBehindTheWindow) {
  ScorerConfig config;
  config.score_from_s = 1;
  config.score_to_s = 2;
  Scorer scorer{config};
  for (int tenth = 0; tenth <= 50; ++tenth) scorer.take(still(0.1 * tenth));
  EXPECT_EQ(scorer.report().motion->samples, 11u);
  EXPECT_EQ(scorer.report().duration_s, 2);
}

TEST(Scorer, LeavesOutASampleThatIsNotNewer) {
  Scorer scorer{{.score_from_s = 0}};
  scorer.take(still(1));
  scorer.take(still(1));
  scorer.take(still(0.5));
  EXPECT_EQ(scorer.report().motion->samples, 1u);
}

TEST(Scorer, FollowsTheReferenceButNotForTheTwin) {
  Scorer scorer{{.score_from_s = 0}};
  topic::Reference reference;
  reference.p_world_load_m = {kLoadSet[0] + 0.3, kLoadSet[1], kLoadSet[2] + 0.1};
  scorer.take(reference);
  topic::TruthWorld truth = still(0);
  truth.p_world_load_m = reference.p_world_load_m;
  truth.p_world_tool_m = {kToolSet[0] + 0.3, kToolSet[1], kToolSet[2] + 0.1};
  scorer.take(truth);
  const Report report = scorer.report();
  EXPECT_NEAR(report.motion->load_error_max_m, 0, 1e-15);
  EXPECT_NEAR(report.motion->tool_error_rms_m[0], 0, 1e-15);
  EXPECT_NEAR(report.motion->tool_error_rms_m[2], 0, 1e-14);
  EXPECT_EQ(report.baseline->load_error_max_m, 0);
}

TEST(Scorer, ScoresByValidEstimatesWhereThereIsNoTruth) {
  ScorerConfig config;
  config.source = Source::estimate;
  config.score_from_s = 0;
  Scorer scorer{config};
  scorer.take(still(0));
  topic::Estimate estimate;
  estimate.t_estimated_ns = to_ns(at(1));
  estimate.swing_rad = {0, 1 * kRadPerDeg};
  estimate.p_world_load_m = kLoadSet;
  estimate.p_world_tool_m = kToolSet;
  scorer.take(estimate);
  EXPECT_FALSE(scorer.t_start());
  estimate.valid = true;
  scorer.take(estimate);
  const Report report = scorer.report();
  EXPECT_EQ(report.source, Source::estimate);
  EXPECT_EQ(report.motion->samples, 1u);
  EXPECT_NEAR(report.motion->swing_rms_deg, 1, 1e-12);
  EXPECT_FALSE(report.baseline);
  EXPECT_TRUE(std::isnan(scorer.live(at(1)).baseline_swing_now_deg));
}

TEST(Scorer, TellsLiveWhatIsNowAndWhatWas) {
  Scorer scorer{{}};
  topic::Score before = scorer.live(at(0));
  EXPECT_EQ(before.swing_now_deg, 0);
  EXPECT_TRUE(std::isnan(before.baseline_swing_now_deg));
  feed_run(scorer);
  topic::TruthWorld last = still(61);
  last.swing_rad = {3 * kRadPerDeg, 4 * kRadPerDeg};
  last.p_world_twin_load_m[2] += 0.25;
  scorer.take(last);
  const topic::Score score = scorer.live(at(62));
  EXPECT_TRUE(score.from_truth);
  EXPECT_EQ(score.t_ns, to_ns(at(62)));
  EXPECT_EQ(score.duration_s, 41);
  EXPECT_NEAR(score.swing_now_deg, 5, 1e-12);
  EXPECT_NEAR(score.baseline_load_error_now_m, 0.25, 1e-12);
  EXPECT_NEAR(score.baseline_swing_rms_deg, 5 / std::sqrt(2), 1e-3);
}

TEST(Scorer, TellsHowSoonAFaultWasNoticedAndAtRest) {
  Scorer scorer{{}};
  scorer.take(mode(ModeState::fault, -100, "older_than_the_run"));
  scorer.take(still(0));
  scorer.note_fault(at(30), "mru1:silent");
  scorer.take(mode(ModeState::fault, 30.025, "mru1_stale"));
  scorer.take(control(30.05, 0.1));
  scorer.take(control(30.25, 0));
  scorer.take(mode(ModeState::fault, 40, "arm_stale"));
  const auto faults = scorer.report().faults;
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0].t_s, 30);
  EXPECT_EQ(faults[0].fault, "mru1:silent");
  EXPECT_EQ(faults[0].code, "mru1_stale");
  EXPECT_EQ(faults[0].detected_after_s, 0.025);
  EXPECT_EQ(faults[0].at_rest_after_s, 0.25);
  EXPECT_EQ(faults[1].fault, "arm_stale");
  EXPECT_FALSE(faults[1].detected_after_s);
  EXPECT_FALSE(faults[1].at_rest_after_s);
}

TEST(Scorer, KeepsTheNewestFreshnessOfEachDevice) {
  Scorer scorer{{}};
  topic::Health health;
  health.stale_after_s = 0.03;
  for (const char* device : {"winch", "arm", "winch"}) {
    health.device = device;
    health.age_max_s += 0.001;
    scorer.take(health);
  }
  const auto freshness = scorer.report().freshness;
  ASSERT_EQ(freshness.size(), 2u);
  EXPECT_EQ(freshness[0].device, "arm");
  EXPECT_EQ(freshness[1].device, "winch");
  EXPECT_NEAR(freshness[1].age_max_s, 0.003, 1e-15);
}

std::vector<std::string> keys(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

const std::vector<std::string> kReportKeys{"scenario",
                                           "controller",
                                           "estimator",
                                           "sensors",
                                           "seed",
                                           "duration_s",
                                           "score_from_s",
                                           "source",
                                           "world",
                                           "frame",
                                           "gains",
                                           "platform",
                                           "reference_frame",
                                           "limits",
                                           "samples",
                                           "swing_rms_deg",
                                           "swing_axis_rms_deg",
                                           "swing_max_deg",
                                           "swing_axis_max_deg",
                                           "load_error_rms_m",
                                           "load_error_rms_norm_m",
                                           "load_error_max_m",
                                           "tool_error_rms_m",
                                           "tool_error_rms_norm_m",
                                           "settling_time_s",
                                           "joint_speed_max_degps",
                                           "winch_speed_max_mps",
                                           "limited",
                                           "baseline",
                                           "reduction",
                                           "age_at_actuation_us",
                                           "step_time_us",
                                           "faults",
                                           "freshness"};

TEST(Report, HasEveryKeyInItsPlaceWithAndWithoutARun) {
  Scorer empty{{}}, full{{}};
  feed_run(full);
  EXPECT_EQ(keys(Json::parse(to_json(empty.report()))), kReportKeys);
  EXPECT_EQ(keys(Json::parse(to_json(full.report()))), kReportKeys);
}

TEST(Report, SaysNullOfWhatWasNotSeen) {
  const Json json = Json::parse(to_json(Scorer{{}}.report()));
  for (const char* key :
       {"scenario", "seed", "swing_rms_deg", "load_error_rms_m", "settling_time_s", "joint_speed_max_degps",
        "winch_speed_max_mps", "baseline", "age_at_actuation_us", "step_time_us"}) {
    EXPECT_TRUE(json[key].is_null()) << key;
  }
  EXPECT_TRUE(json["reduction"]["swing_rms"].is_null());
  EXPECT_EQ(json["faults"], Json::array());
}

TEST(Report, SaysWhatWasSeen) {
  ScorerConfig config;
  config.labels.scenario = "thesis-wave";
  config.labels.seed = 18'446'744'073'709'551'615u;
  Scorer scorer{config};
  feed_run(scorer);
  scorer.note_fault(at(50), "mru1:silent");
  const Report report = scorer.report();
  const Json json = Json::parse(to_json(report));
  EXPECT_EQ(json["scenario"], "thesis-wave");
  EXPECT_EQ(json["controller"], "ours");
  EXPECT_EQ(json["seed"], 18'446'744'073'709'551'615u);
  EXPECT_EQ(json["source"], "truth");
  EXPECT_EQ(json["swing_rms_deg"].get<double>(), report.motion->swing_rms_deg);  // the same bits
  EXPECT_EQ(json["load_error_rms_m"].size(), 3u);
  EXPECT_EQ(json["joint_speed_max_degps"].size(), 6u);
  EXPECT_NEAR(json["reduction"]["swing_rms"], 1 - 0.04 / 5, 1e-6);
  EXPECT_NEAR(json["reduction"]["load_error_rms"], 1 - 0.005 / 0.5, 1e-6);
  EXPECT_EQ(keys(json["baseline"]),
            (std::vector<std::string>{"swing_rms_deg", "swing_axis_rms_deg", "swing_max_deg",
                                      "swing_axis_max_deg", "load_error_rms_m", "load_error_rms_norm_m",
                                      "load_error_max_m", "tool_error_rms_m", "tool_error_rms_norm_m",
                                      "settling_time_s", "joint_speed_max_degps", "winch_speed_max_mps"}));
  EXPECT_EQ(keys(json["step_time_us"]), (std::vector<std::string>{"p50", "p99", "max"}));
  ASSERT_EQ(json["faults"].size(), 1u);
  EXPECT_EQ(keys(json["faults"][0]),
            (std::vector<std::string>{"t_s", "fault", "code", "detected_after_s", "at_rest_after_s"}));
  EXPECT_TRUE(json["faults"][0]["detected_after_s"].is_null());
}

TEST(Report, SurvivesALabelThatIsNoText) {
  ScorerConfig config;
  config.labels.scenario = "\xff\xfe";
  EXPECT_NO_THROW((void)to_json(Scorer{config}.report()));
}

TEST(Reduction, NeedsABaselineThatMoves) {
  EXPECT_EQ(reduction(1, 4), 0.75);
  EXPECT_FALSE(reduction(1, 0));
}

}  // namespace
}  // namespace motionlab::monitor
