// The cameras are coasted over; the load is not left unseen for long.
#include <gtest/gtest.h>

#include <string>

#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

constexpr double kCentimetres = 0.05;

class Cameras : public testing::TestWithParam<std::tuple<std::string, bool>> {};

TEST_P(Cameras, TwoSecondsWithoutThemAreCoasted) {
  const auto& [fault, tracked] = GetParam();
  Line line(configure("thesis-wave", 1, tracked));
  line.engage_and_run_to(25);
  line.take_motion();
  line.fault("qualisys", fault, true);
  line.run_for(2);
  line.fault("qualisys", fault, false);
  line.run_for(3);
  EXPECT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  const auto meanwhile = line.take_motion();
  EXPECT_LE(meanwhile.load_error_max_m, kCentimetres);
  RecordProperty("load_error_max_m", std::to_string(meanwhile.load_error_max_m));
  line.run_for(8);
  line.take_motion();
  line.run_for(10);
  const auto after = line.take_motion();
  EXPECT_LE(after.swing_rms_deg, 0.12);
  EXPECT_LE(after.load_error_rms_norm_m, 0.012);
}

// Design: from 3 s on the compensation of surge and sway is taken back, at rest by 10 s.
TEST_P(Cameras, LongerEndsTheEngagementAtRest) {
  const auto& [fault, tracked] = GetParam();
  const lockstep::Config config = configure("thesis-wave", 1, tracked);
  const auto& limits = config.gateway.limits;
  const double period_s = config.gateway.control_period_s;
  Line line(config);
  line.engage_and_run_to(25);
  const LabTime lost = line.now();
  line.fault("qualisys", fault, true);
  line.run_for(2.5);
  EXPECT_EQ(line.mode().state, ModeState::engaged);
  line.run_for(9);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  EXPECT_EQ(line.mode().fault_code.view(), "load_lost");
  EXPECT_TRUE(line.mode().fault_latched);
  const auto stop = last_stop(line.steps(), limits, period_s);
  ASSERT_TRUE(stop);
  EXPECT_LE(stop->t_rest - lost, 10s + 500ms);
  EXPECT_EQ(steps_beyond_limits(line.steps(), limits, period_s), 0U);
  line.fault("qualisys", fault, false);
  line.run_for(12);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  line.ask(ModeAction::reset);
  EXPECT_TRUE(line.run_until_state(ModeState::ready, 10)) << line.mode().reason.view();
}

std::string name_of(const testing::TestParamInfo<Cameras::ParamType>& test) {
  const auto& [fault, tracked] = test.param;
  std::string name = fault + (tracked ? "_tracked" : "_untracked");
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Lost, Cameras,
                         testing::Combine(testing::Values("occlude:load", "silent", "stop_measurement"),
                                          testing::Bool()),
                         name_of);

TEST(CamerasAndPlatform, AnUnseenPlatformBodyIsDoneWithout) {
  Line line(configure("thesis-wave"));
  line.engage_and_run_to(25);
  line.fault("qualisys", "occlude:platform", true);
  line.take_motion();
  line.run_for(20);
  EXPECT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  const auto motion = line.take_motion();
  EXPECT_LE(motion.swing_rms_deg, 0.2);
  EXPECT_LE(motion.load_error_max_m, kCentimetres);
}

}  // namespace
}  // namespace motionlab::integration
