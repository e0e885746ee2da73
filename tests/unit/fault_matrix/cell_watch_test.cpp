#include "simulators/lab/fault_matrix/cell_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "simulators/lab/fault_matrix/servo_speed.hpp"

namespace motionlab::matrix {
namespace {

using topic::ModeState;

LabTime at(double t_s) {
  return LabTime{} + from_seconds(t_s);
}

service::GatewayConfig gateway() {
  service::GatewayConfig config;
  config.limits.q_min_rad.fill(-1);
  config.limits.q_max_rad.fill(1);
  config.limits.qd_max_radps.fill(0.5);
  config.limits.wire_min_m = 1;
  config.limits.wire_max_m = 3;
  config.limits.wire_speed_max_mps = 0.2;
  config.limits.wire_acceleration_max_mps2 = 0.5;
  config.comau.driver.qdd_max_radps2.fill(6);
  config.comau.driver.command_period_s = 0.005;
  return config;
}

/// One run of a cell, told by hand: everything of one millisecond at once.
class Run : public testing::Test {
 protected:
  static Cell cell(State state) { return {{"arm", "cut", Program::hardened}, state}; }

  void begin(State state) {
    watch_.emplace(cell(state), gateway(), lab::LabConfig());
    t_ = {};
    truth_ = {};
    follows_ = true;
    times_ = Timetable::of(cell(state));
    truth_.wire_length_m = 2;
    mode(state == State::settled ? ModeState::ready : ModeState::engaged);
    until(times_.fault_s);
  }
  void mode(ModeState state, const char* code = "") {
    mode_.state = state;
    mode_.fault_latched = state == ModeState::fault;
    mode_.fault_code = code;
  }
  void until(double t_s) {
    for (; t_ < at(t_s); t_ += 1ms) {
      for (std::size_t j = 0; j < 6; ++j) truth_.q_rad[j] += 1e-3 * truth_.qd_radps[j];
      watch_->take(t_, mode_);
      watch_->sent(t_, follows_, truth_.qd_radps);
      watch_->take(t_, truth_);
    }
  }
  void rest_of_it() { until(times_.end_s); }
  Outcome outcome() const { return watch_->outcome(); }

  std::optional<CellWatch> watch_;
  Timetable times_{};
  LabTime t_{};
  topic::Mode mode_;
  Truth truth_;
  bool follows_ = true;
};

TEST_F(Run, RestsWhenTheModeLatchesAndThePlantStands) {
  begin(State::sea);
  truth_.qd_radps[0] = 0.1;
  truth_.swing_deg = 2;
  until(times_.fault_s + 0.03);
  mode(ModeState::fault, "arm_stale");
  until(times_.fault_s + 0.2);
  truth_.qd_radps[0] = 0;
  truth_.swing_deg = 1;
  rest_of_it();
  const Outcome o = outcome();
  EXPECT_EQ(o.ending, Ending::rests);
  EXPECT_EQ(o.code, "arm_stale");
  EXPECT_EQ(o.detected_by, "mode arm_stale");
  EXPECT_NEAR(o.detected_after_s.value(), 0.03, 1.1e-3);
  EXPECT_NEAR(o.at_rest_after_s.value(), 0.2, 2e-3);
  EXPECT_NEAR(o.swing_max_deg, 2, 1e-9);
  EXPECT_FALSE(o.moved_by_itself);
}

TEST_F(Run, RidesThroughWhatChangesNothingAndTellsWhatWasCounted) {
  begin(State::sea);
  topic::Health health;
  health.link = topic::LinkState::up;
  watch_->take(at(times_.fault_s - 1), health);
  truth_.qd_radps[0] = 0.1;
  truth_.swing_deg = 0.5;
  until(times_.fault_s + 0.1);
  ++health.rejected[0];
  watch_->take(t_, health);
  until(times_.fault_s + 1);
  truth_.qd_radps[0] = -0.1;
  truth_.swing_deg = 0;
  rest_of_it();
  const Outcome o = outcome();
  EXPECT_EQ(o.ending, Ending::rides_through);
  EXPECT_EQ(o.detected_by, "counted");
  EXPECT_NEAR(o.detected_after_s.value(), 0.1, 1.1e-3);
  EXPECT_FALSE(o.at_rest_after_s);
  EXPECT_NEAR(o.swing_rms_deg, 0.5 * std::sqrt(1.0 / 5), 1e-3);
}

TEST_F(Run, TellsAWordOfTheDeviceBeforeACounter) {
  begin(State::calm);
  topic::Health health;
  health.link = topic::LinkState::up;
  watch_->quality(t_, true);
  ++health.lost;
  until(times_.fault_s + 0.05);
  watch_->take(t_, health);
  until(times_.fault_s + 0.1);
  health.advice = "switch it on";
  watch_->take(t_, health);
  until(times_.fault_s + 0.2);
  watch_->quality(t_, false);
  rest_of_it();
  EXPECT_EQ(outcome().detected_by, "advice");
  EXPECT_NEAR(outcome().detected_after_s.value(), 0.1, 1.1e-3);
  EXPECT_TRUE(outcome().advised);
}

TEST_F(Run, SeesThatTheModeSaysEngagedWhileTheArmIsLetGo) {
  begin(State::sea);
  follows_ = false;
  rest_of_it();
  EXPECT_EQ(outcome().ending, Ending::brakes_engaged);
}

TEST_F(Run, SeesAnArmThatGoesOn) {
  begin(State::sea);
  truth_.qd_radps[0] = 0.05;
  until(times_.fault_s + 0.03);
  mode(ModeState::fault, "arm_stale");
  until(times_.fault_ends_s);
  truth_.qd_radps[0] = 0;
  rest_of_it();
  EXPECT_EQ(outcome().ending, Ending::not_stoppable);
  EXPECT_NEAR(outcome().joint_speed_max_radps, 0.05, 1e-12);
}

TEST_F(Run, SeesAnArmThatCreeps) {
  begin(State::calm);
  truth_.qd_radps[0] = 0.9e-3;
  until(times_.fault_s + 0.03);
  mode(ModeState::fault, "arm_stale");
  rest_of_it();
  EXPECT_EQ(outcome().ending, Ending::not_stoppable);
}

TEST_F(Run, SeesMotionAfterRestWhenTheCauseIsGone) {
  begin(State::sea);
  mode(ModeState::fault, "arm_stale");
  until(times_.fault_ends_s + 0.5);
  truth_.qd_radps[0] = 0.01;
  rest_of_it();
  EXPECT_TRUE(outcome().moved_by_itself);
}

TEST_F(Run, SeesMotionAfterRestWhileTheCauseLasts) {
  begin(State::sea);
  mode(ModeState::fault, "arm_stale");
  until(times_.fault_s + 1);
  truth_.qd_radps[0] = 0.01;
  until(times_.fault_s + 1.1);
  truth_.qd_radps[0] = 0;
  rest_of_it();
  EXPECT_TRUE(outcome().moved_by_itself);
}

TEST_F(Run, TakesAJointThatTurnsRoundForNoRest) {
  begin(State::sea);
  truth_.qd_radps[0] = 0.01;
  mode(ModeState::fault, "arm_stale");
  until(times_.fault_s + 0.1);
  truth_.qd_radps[0] = 0;
  until(times_.fault_s + 0.12);
  truth_.qd_radps[0] = -0.01;
  until(times_.fault_s + 0.3);
  truth_.qd_radps[0] = 0;
  rest_of_it();
  EXPECT_FALSE(outcome().moved_by_itself);
  EXPECT_EQ(outcome().ending, Ending::rests);
  EXPECT_NEAR(outcome().at_rest_after_s.value(), 0.3, 2e-3);
}

TEST_F(Run, KnowsWhetherTheGatewayWasInTheStateOfTheCell) {
  begin(State::sea);
  EXPECT_TRUE(outcome().in_state);
  begin(State::settled);
  EXPECT_TRUE(outcome().in_state);
  watch_.emplace(cell(State::sea), gateway(), lab::LabConfig());
  watch_->take(at(1), mode_);  // ready, though it should be engaged
  EXPECT_FALSE(outcome().in_state);
}

TEST_F(Run, SettledItSeesNothingInBecomingReady) {
  begin(State::settled);
  mode(ModeState::settled);
  until(times_.fault_s + 0.1);
  EXPECT_EQ(outcome().detected_by, "mode settled");
  watch_.emplace(cell(State::settled), gateway(), lab::LabConfig());
  mode(ModeState::settled);
  watch_->take(at(1), mode_);
  mode(ModeState::ready);
  watch_->take(at(times_.fault_s + 0.1), mode_);
  EXPECT_FALSE(outcome().detected_after_s);
}

TEST_F(Run, SettledItDoesNotTakeTheTimeBeforeTheFirstCommandForBraking) {
  begin(State::settled);
  follows_ = false;
  until(times_.engage_s);
  mode(ModeState::engaged);
  until(times_.engage_s + 0.05);
  follows_ = true;
  truth_.qd_radps[0] = 0.01;
  rest_of_it();
  EXPECT_EQ(outcome().ending, Ending::engages);
}

TEST_F(Run, SeesAnEngagementThatNobodyAskedFor) {
  begin(State::sea);
  mode(ModeState::fault, "arm_stale");
  until(times_.fault_ends_s + 0.5);
  mode(ModeState::engaged);
  rest_of_it();
  EXPECT_TRUE(outcome().moved_by_itself);
}

TEST_F(Run, SettledItRefusesAndTellsWhy) {
  begin(State::settled);
  mode(ModeState::settled, "arm_stale");
  rest_of_it();
  const Outcome o = outcome();
  EXPECT_EQ(o.ending, Ending::refuses);
  EXPECT_EQ(o.code, "arm_stale");
  EXPECT_EQ(o.detected_by, "mode arm_stale");
  EXPECT_FALSE(o.moved_by_itself);
}

TEST_F(Run, SettledItEngagesWhenAsked) {
  begin(State::settled);
  until(times_.engage_s + 0.001);
  mode(ModeState::engaged);
  truth_.qd_radps[0] = 0.1;
  rest_of_it();
  EXPECT_EQ(outcome().ending, Ending::engages);
  EXPECT_FALSE(outcome().moved_by_itself);
}

TEST_F(Run, SettledNothingMoves) {
  begin(State::settled);
  truth_.qd_radps[0] = 0.01;
  rest_of_it();
  EXPECT_TRUE(outcome().moved_by_itself);
}

TEST_F(Run, SettledAfterTheFaultNothingEngagesThatWasRefusedBefore) {
  begin(State::settled);
  mode(ModeState::settled, "arm_stale");
  until(times_.fault_ends_s + 0.5);
  mode(ModeState::engaged);
  rest_of_it();
  EXPECT_TRUE(outcome().moved_by_itself);
}

TEST_F(Run, MeasuresEveryLimit) {
  begin(State::sea);
  EXPECT_EQ(outcome().overshoot.worst(), "");
  truth_.q_rad[2] = 1.01;
  watch_->take(t_, truth_);
  EXPECT_NEAR(outcome().overshoot.joint_position_rad, 0.01, 1e-12);
  EXPECT_EQ(outcome().overshoot.worst(), "joint position");

  begin(State::sea);
  truth_ = {.qd_radps = {0, -0.6}, .wire_length_m = 0.9, .wire_speed_mps = 0.3};
  watch_->take(t_, truth_);
  EXPECT_NEAR(outcome().overshoot.plant_joint_speed, 1.2, 1e-12);
  EXPECT_NEAR(outcome().overshoot.wire_length_m, 0.1, 1e-12);
  EXPECT_NEAR(outcome().overshoot.plant_wire_speed, 1.5, 1e-12);
}

TEST_F(Run, LetsAServoRingAtItsLimitAndNotBeyondWhatItCan) {
  begin(State::sea);
  const double share =
      servo_speed_share({0.9 * 25.1327, 0.7}, 0.5, 10);  // what a hardened program lets through
  truth_.qd_radps[0] = 0.5 * share - 1e-9;
  watch_->take(t_, truth_);
  EXPECT_GT(outcome().overshoot.plant_joint_speed, 1.05);
  EXPECT_EQ(outcome().overshoot.worst(), "");
  truth_.qd_radps[0] = 0.5 * share + 1e-9;
  watch_->take(t_, truth_);
  EXPECT_EQ(outcome().overshoot.worst(), "joint speed");
}

TEST_F(Run, LetsNoCommandPassItsSpeedLimit) {
  begin(State::sea);
  const std::array<double, 6> at_limit{0.5}, beyond{0.5000001};
  watch_->sent(t_, true, at_limit);
  watch_->sent(t_ + 1s, true, at_limit);
  EXPECT_EQ(outcome().overshoot.joint_speed, 1);
  watch_->sent(t_ + 2s, true, beyond);
  EXPECT_EQ(outcome().overshoot.worst(), "commanded joint speed");

  begin(State::sea);
  topic::WinchCommand winch;
  winch.wire_speed_wanted_mps = 0.21;
  watch_->take(t_, winch);
  EXPECT_EQ(outcome().overshoot.worst(), "commanded wire speed");
}

TEST_F(Run, MeasuresAccelerationsOfWhatIsSent) {
  begin(State::sea);
  const std::array<double, 6> still{}, fast{0, 0, 0.06};
  watch_->sent(t_, true, still);
  watch_->sent(t_ + 5ms, true, fast);
  EXPECT_NEAR(outcome().overshoot.joint_acceleration, 2, 1e-9) << "12 of 6 rad/s²";
  EXPECT_EQ(outcome().overshoot.worst(), "joint acceleration");
  begin(State::sea);
  watch_->sent(t_, true, fast);
  watch_->sent(t_ + 5ms, false, fast);
  EXPECT_NEAR(outcome().overshoot.joint_acceleration, 2, 1e-9) << "letting go is no speed";

  topic::WinchCommand winch;
  watch_->take(t_, winch);
  winch.wire_speed_wanted_mps = 0.001;
  watch_->take(t_ + 1ms, winch);
  EXPECT_NEAR(outcome().overshoot.wire_acceleration, 2, 1e-9);
}

}  // namespace
}  // namespace motionlab::matrix
