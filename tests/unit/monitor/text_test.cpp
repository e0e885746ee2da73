#include "gateway/monitor/text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace motionlab::monitor {
namespace {

using testing::HasSubstr;
using testing::Not;

const Paint kPlain{false};

topic::Health healthy(const char* device) {
  topic::Health health;
  health.device = device;
  health.link = topic::LinkState::up;
  health.required = true;
  health.rate_hz = 200;
  health.age_s = 0.0021;
  health.age_max_s = 0.008;
  health.stale_after_s = 0.03;
  return health;
}

TEST(DeviceLine, TellsLinkRateAgeLossAndRejects) {
  topic::Health health = healthy("mru1");
  health.lost = 2;
  health.rejected[3] = 1;
  health.rejected[5] = 4;
  EXPECT_EQ(device_line(health, kPlain),
            "mru1       up           200.0 Hz  age     2.1 ms (max 8.0 of 30.0)  lost 2  rejected 5 "
            "(bad_checksum 1, "
            "foreign 4)");
}

TEST(DeviceLine, TellsAdviceAndThatADeviceIsOptional) {
  topic::Health health = healthy("mru2");
  health.link = topic::LinkState::down;
  health.required = false;
  health.age_s = -1;
  health.advice = "see whether the unit has power";
  const std::string line = device_line(health, kPlain);
  EXPECT_THAT(line, HasSubstr("down"));
  EXPECT_THAT(line, HasSubstr("age       - ms"));
  EXPECT_THAT(line, HasSubstr("optional  see whether the unit has power"));
}

TEST(ModeLine, TellsStateAuthorityOwnerCodeAndReason) {
  topic::Mode mode;
  mode.state = topic::ModeState::fault;
  mode.authority = topic::Authority::full;
  mode.owner = "alice@lab";
  mode.fault_code = "mru1_stale";
  mode.reason = "mru1 fell silent";
  EXPECT_EQ(mode_line(mode, kPlain), "fault, authority full, owner alice@lab, mru1_stale: mru1 fell silent");
}

TEST(Paint, ColoursOnlyATerminal) {
  EXPECT_EQ(kPlain(Ink::bad, "fault"), "fault");
  EXPECT_EQ(Paint{true}(Ink::bad, "fault"), "\033[31mfault\033[0m");
}

TEST(LiveLine, ShowsBothLoadsAgesAndHealth) {
  LiveFacts facts;
  facts.t_s = 23;
  facts.score.swing_now_deg = 0.041;
  facts.score.baseline_swing_now_deg = 5.12;
  facts.score.load_error_now_m = 0.0032;
  facts.score.baseline_load_error_now_m = 0.612;
  facts.mode.emplace().state = topic::ModeState::engaged;
  topic::Control& control = facts.control.emplace();
  control.age_mru_s = 0.0024;
  control.age_bodies_s = -1;
  facts.health.add(healthy("mru1"));
  facts.health.add(healthy("arm"));
  EXPECT_EQ(
      live_line(facts, kPlain),
      "  23 s  engaged   swing  0.04 deg (without:  5.12)  load    3.2 mm (without:  612.0)  ages mru 2.4 "
      "bodies - arm 0.0 winch 0.0 ms  2/2 up");
}

TEST(LiveLine, LeavesOutWhatIsNotKnown) {
  LiveFacts facts;
  facts.score.baseline_swing_now_deg = std::numeric_limits<double>::quiet_NaN();
  facts.score.baseline_load_error_now_m = std::numeric_limits<double>::quiet_NaN();
  const std::string line = live_line(facts, kPlain);
  EXPECT_THAT(line, HasSubstr("no mode"));
  EXPECT_THAT(line, Not(HasSubstr("without")));
  EXPECT_THAT(line, Not(HasSubstr("ages")));
}

TEST(LiveLine, NamesTheFirstTroubleAndSilence) {
  LiveFacts facts;
  facts.silent_s = 3;
  topic::Health stale = healthy("mru1");
  stale.link = topic::LinkState::stale;
  facts.health.add(healthy("arm"));
  facts.health.add(stale);
  const std::string line = live_line(facts, kPlain);
  EXPECT_THAT(line, HasSubstr("silent for 3 s"));
  EXPECT_THAT(line, HasSubstr("1/2 up (mru1 stale)"));
}

TEST(Summary, SaysThatNothingWasScored) {
  Report report;
  report.duration_s = 5;
  report.score_from_s = 20;
  EXPECT_EQ(summary(report), "scored nothing: the run ended after 5.0 s, the window begins at 20.0 s\n");
}

TEST(Summary, ComparesWithTheTwin) {
  Report report;
  report.duration_s = 60;
  report.score_from_s = 20;
  report.motion.emplace().swing_rms_deg = 0.05;
  report.baseline.emplace().swing_rms_deg = 5;
  report.age_at_actuation_us = Spread{2100, 4000, 9000};
  report.freshness.push_back({"mru1", 0.012, 0.06});
  report.faults.push_back({30, "mru1_stale", "mru1_stale", std::nullopt, std::nullopt});
  const std::string text = summary(report);
  EXPECT_THAT(text, HasSubstr("40.0 s, from 20.0 s on, by the truth"));
  EXPECT_THAT(text, HasSubstr("swing rms 0.050 deg"));
  EXPECT_THAT(text, HasSubstr("swing 99.0 %, load - %"));
  EXPECT_THAT(text, HasSubstr("p50 2.1, p99 4.0, max 9.0 ms"));
  EXPECT_THAT(text, HasSubstr("greatest age 12.0 of the allowed 60.0 ms"));
  EXPECT_THAT(text, HasSubstr("at 30.00 s: mru1_stale"));
}

}  // namespace
}  // namespace motionlab::monitor
