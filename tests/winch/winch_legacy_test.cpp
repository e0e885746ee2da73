// The laboratory's own PLC project: it is told, and moved only with leave and slowly.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/winch/winch_bench.hpp"

namespace motionlab::winch {
namespace {

using Mode = topic::WinchCommandMode;
using State = topic::WinchDriveState;

DeviceConfig published_project() {
  DeviceConfig config;
  config.project = PlcProject::legacy;
  return config;
}

DriverConfig legacy(bool commands) {
  DriverConfig config;
  config.profile = Profile::legacy;
  config.legacy_commands = commands;
  return config;
}

TEST(WinchLegacyProfile, TellsTheStatusAtItsRateAndWritesNothingWithoutLeave) {
  Bench bench{legacy(false), published_project()};
  bench.engage();
  bench.command = Bench::make(Mode::velocity, true, 0.2);
  bench.run(1s);
  const auto& health = bench.driver_->health();
  EXPECT_EQ(health.phase(), LinkPhase::up);
  EXPECT_EQ(health.rejected_total(), 0U);
  EXPECT_NEAR(health.rate_hz(bench.now()), 100.0, 5.0);
  EXPECT_NE(health.advice().find("only listened to"), std::string_view::npos);
  const auto& state = bench.last();
  EXPECT_EQ(state.drive_state, State::off);
  EXPECT_NEAR(state.wire_length_m, 2.0, 1e-12);
  EXPECT_NEAR(state.wire_length_min_m, 1.2, 1e-12);
  EXPECT_NEAR(state.wire_length_max_m, 2.7, 1e-12);
  EXPECT_TRUE(state.homed);
  EXPECT_FALSE(state.command_path_alive);
  EXPECT_FALSE(state.ready) << "nothing engages on a winch that may not be moved";
  EXPECT_TRUE(std::isnan(state.motor_torque_nm));
  EXPECT_LT(state.t_measured_ns, state.t_received_ns) << "not newer than the question";
  EXPECT_EQ(bench.driver_->counters().commands_written, 0U);
  EXPECT_EQ(bench.device_->plc().state(), PlcState::off);
  EXPECT_EQ(bench.device_->handles(), 6U) << "what cannot be written was not even asked for";
}

TEST(WinchLegacyProfile, MovesWithLeaveButNeverFasterThanItsOwnLimit) {
  Bench bench{legacy(true), published_project()};
  bench.engage();
  EXPECT_EQ(bench.last().drive_state, State::hold);
  EXPECT_TRUE(bench.last().ready);
  EXPECT_TRUE(bench.last().command_path_alive);
  bench.command = Bench::make(Mode::velocity, true, 0.2);
  bench.run(1s);
  EXPECT_EQ(bench.last().drive_state, State::velocity);
  EXPECT_NEAR(bench.last().wire_speed_mps, 0.05, 1e-9);
  bench.command = Bench::make(Mode::position, true, 2.5);
  bench.run(500ms);
  EXPECT_NEAR(bench.last().wire_speed_mps, 0.0, 1e-9) << "there is no position mode";
  EXPECT_TRUE(bench.driver_->health().advice().empty()) << bench.driver_->health().advice();
}

TEST(WinchLegacyProfile, WritesZeroWhenTheCommandIsStale) {
  Bench bench{legacy(true), published_project()};
  bench.engage();
  bench.command = Bench::make(Mode::velocity, true, 0.05);
  bench.run(500ms);
  bench.command.reset();
  bench.run(300ms);
  EXPECT_NEAR(bench.last().wire_speed_mps, 0.0, 1e-9);
  EXPECT_EQ(bench.driver_->counters().commands_stale, 1U);
}

TEST(WinchLegacyProfile, StopsInGoodOrderAndGivesBackEveryHandle) {
  for (const bool commands : {false, true}) {
    Bench bench{legacy(commands), published_project()};
    bench.engage();
    bench.command = Bench::make(Mode::velocity, true, 0.05);
    bench.run(500ms);
    bench.driver_->orderly_stop();
    bench.run(1s);
    EXPECT_TRUE(bench.driver_->stopped()) << commands;
    EXPECT_EQ(bench.device_->plc().state(), PlcState::off) << commands;
    EXPECT_EQ(bench.device_->handles(), 0U) << commands;
    EXPECT_EQ(bench.device_->subscriptions(), 0U) << commands;
  }
}

TEST(WinchLegacyProfile, ResolvesItsHandlesAgainAfterAnOnlineChange) {
  Bench bench{legacy(false), published_project()};
  bench.run(500ms);
  ASSERT_TRUE(bench.device_->set_fault("online_change", true).ok());
  bench.run(500ms);
  EXPECT_EQ(bench.driver_->counters().resolved_again, 1U);
  EXPECT_EQ(bench.driver_->health().reconnects(), 0U);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_EQ(bench.device_->handles(), 6U);
  const auto told = bench.states_.size();
  bench.run(500ms);
  EXPECT_GT(bench.states_.size(), told + 40);
}

TEST(WinchLegacyProfile, ADriveFaultIsTold) {
  Bench bench{legacy(true), published_project()};
  bench.engage();
  ASSERT_TRUE(bench.device_->set_fault("drive_fault", true).ok());
  bench.run(200ms);
  EXPECT_EQ(bench.last().drive_state, State::fault);
  EXPECT_TRUE(bench.last().error);
  EXPECT_EQ(bench.driver_->health().advice().find("drive: "), 0U);
}

TEST(WinchLegacyProfile, ListensToOurProjectTooWithoutMovingIt) {
  Bench bench{legacy(true)};  // MAIN.winch beside GVL_Winch tells, and is not obeyed
  bench.engage();
  bench.command = Bench::make(Mode::velocity, true, 0.05);
  bench.run(1s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_EQ(bench.device_->plc().state(), PlcState::off);
  EXPECT_NEAR(bench.last().wire_length_m, 2.0, 1e-12);
}

TEST(WinchLegacyProfile, SaysWhichProjectIsMissing) {
  Bench bench{DriverConfig{}, published_project()};
  bench.run(200ms);
  EXPECT_NE(bench.driver_->health().advice().find("lacks GVL_Winch"), std::string_view::npos)
      << bench.driver_->health().advice();
}

}  // namespace
}  // namespace motionlab::winch
