#include "gateway/monitor/motion_score.hpp"

#include <gtest/gtest.h>

#include "tests/unit/monitor/samples.hpp"

namespace motionlab::monitor {
namespace {

TEST(MotionStatistics, HasNoScoreBeforeTheFirstSample) {
  EXPECT_FALSE(MotionStatistics{}.score());
}

TEST(MotionStatistics, GivesASineItsAmplitudeOverRootTwo) {
  MotionStatistics statistics;
  constexpr int kPeriod = 1000;
  for (int i = 0; i < 20 * kPeriod; ++i) {
    const double s = std::sin(2 * std::numbers::pi * i / kPeriod);
    statistics.add(
        {{3 * kRadPerDeg * s, 4 * kRadPerDeg * s}, {0.2 * s, 0.3 * s, 0.6 * s}, {0.1 * s, 0, 0.05 * s}});
  }
  const MotionScore score = *statistics.score();
  EXPECT_EQ(score.samples, 20'000u);
  EXPECT_NEAR(score.swing_axis_rms_deg[0], 3 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(score.swing_axis_rms_deg[1], 4 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(score.swing_rms_deg, 5 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(score.swing_axis_max_deg[0], 3, 1e-12);
  EXPECT_NEAR(score.swing_axis_max_deg[1], 4, 1e-12);
  EXPECT_NEAR(score.swing_max_deg, 5, 1e-12);
  EXPECT_NEAR(score.load_error_rms_m[0], 0.2 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(score.load_error_rms_m[2], 0.6 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(score.load_error_rms_norm_m, 0.7 / std::sqrt(2), 1e-12);
  EXPECT_NEAR(score.load_error_max_m, 0.7, 1e-12);
  EXPECT_NEAR(score.tool_error_rms_m[0], 0.1 / std::sqrt(2), 1e-12);
  EXPECT_EQ(score.tool_error_rms_m[1], 0);
  EXPECT_NEAR(score.tool_error_rms_norm_m, std::hypot(0.1, 0.05) / std::sqrt(2), 1e-12);
  EXPECT_NEAR(score.heave_residual_rms_m, 0.6 / std::sqrt(2), 1e-12);
}

TEST(MotionStatistics, LeavesAConstantHeightErrorOutOfTheHeaveResidual) {
  MotionStatistics statistics;
  for (int i = 0; i < 1000; ++i) {
    statistics.add({{}, {0, 0, 100.0 + 1e-6 * std::cos(2 * std::numbers::pi * i / 100)}, {}});
  }
  EXPECT_NEAR(statistics.score()->load_error_rms_m[2], 100.0, 1e-9);
  EXPECT_NEAR(statistics.score()->heave_residual_rms_m, 1e-6 / std::sqrt(2), 1e-12);
}

/// A swing that decays from `start_deg` with this time constant, sampled at 1 kHz.
Settling decaying(double start_deg, double tau_s, double from_s, double to_s) {
  Settling settling;
  for (int ms = static_cast<int>(1000 * from_s); ms <= static_cast<int>(1000 * to_s); ++ms) {
    const double t_s = 1e-3 * ms;
    settling.add(at(t_s), start_deg * std::exp(-(t_s - from_s) / tau_s));
  }
  return settling;
}

TEST(Settling, IsWhenADecayingSwingCrossesOneDegree) {
  const auto time_s = decaying(5, 2, 0, 30).time_s(at(0));
  ASSERT_TRUE(time_s);
  EXPECT_NEAR(*time_s, 2 * std::log(5.0), 1.001e-3);
}

TEST(Settling, CountsFromTheGivenTime) {
  EXPECT_NEAR(*decaying(5, 2, 10, 40).time_s(at(11)), 2 * std::log(5.0) - 1, 1.001e-3);
}

TEST(Settling, IsZeroWhenItWasNeverOutsideSinceThen) {
  EXPECT_EQ(decaying(5, 2, 0, 30).time_s(at(20)), 0.0);
}

TEST(Settling, IsNothingWhenItEndsOutside) {
  EXPECT_FALSE(decaying(5, 200, 0, 30).time_s(at(0)));
}

TEST(Settling, DoesNotTakeAPassingCalmForRest) {
  Settling settling;
  for (int ms = 0; ms <= 60'000; ++ms) {
    settling.add(at(1e-3 * ms), 5 * std::abs(std::cos(std::numbers::pi * 1e-3 * ms / 2.84)));
  }
  EXPECT_FALSE(settling.time_s(at(0)));
}

TEST(Settling, StartsAgainWhenTheSwingLeavesOnceMore) {
  Settling settling = decaying(5, 2, 0, 30);
  settling.add(at(31), 1.5);
  for (int i = 0; i <= 100; ++i) settling.add(at(31.1 + 0.1 * i), 0.5);
  EXPECT_EQ(settling.time_s(at(0)), 31.0);
}

TEST(Settling, IsNothingBeforeTheFirstSample) {
  EXPECT_FALSE(Settling{}.time_s(at(0)));
}

}  // namespace
}  // namespace motionlab::monitor
