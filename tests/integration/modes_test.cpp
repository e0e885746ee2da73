// Nothing moves by accident, and nothing stops with a jerk.
#include <gtest/gtest.h>

#include <functional>
#include <string>

#include "tests/integration/line.hpp"
#include "tests/integration/taken_apart.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

double fastest_joint(const plant::World& world) {
  double fastest = 0;
  for (const double v : world.qd_radps()) fastest = std::max(fastest, std::abs(v));
  return fastest;
}

TEST(Modes, NothingMovesBeforeEngage) {
  Line line(configure("thesis-wave"));
  const auto q_start = line.lockstep().lab().state().q_rad;
  line.run_to(15);
  EXPECT_EQ(line.mode().state, ModeState::ready);
  for (const Step& step : line.steps()) {
    ASSERT_TRUE(step.at_rest());
    ASSERT_FALSE(step.following);
  }
  const auto q = line.lockstep().lab().state().q_rad;
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(q[i], q_start[i], 1e-3) << "joint " << i + 1;
  const auto truth = line.lockstep().lab().truth();
  EXPECT_NEAR(truth.wire_length_m, 2.002, 0.003);
}

TEST(Modes, SettleBringsTheArmToRestWithinTheDecelerationAndLetsGoOnlyThen) {
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  line.engage_and_run_to(22.3);
  ASSERT_EQ(line.mode().state, ModeState::engaged);
  ASSERT_GT(fastest_joint(line.lockstep().lab().world()), 0.05);
  const LabTime asked = line.now();
  line.ask(ModeAction::settle);

  const auto arm = line.lockstep().bus().reader<topic::ArmState>("arm");
  bool followed = true;
  double speed_when_let_go = -1;
  double commanded_when_let_go = -1;
  ASSERT_TRUE(line.run_until(
      [&] {
        const bool follows = arm.newest()->following;
        if (followed && !follows) {
          speed_when_let_go = fastest_joint(line.lockstep().lab().world());
          commanded_when_let_go = line.steps().back().at_rest() ? 0 : 1;
        }
        followed = follows;
        return !follows;
      },
      3));
  EXPECT_LT(speed_when_let_go, 0.005);
  EXPECT_EQ(commanded_when_let_go, 0);
  EXPECT_EQ(line.mode().state,
            ModeState::settled == line.mode().state ? ModeState::settled : ModeState::ready);

  const auto stop = last_stop(line.steps(), config.gateway.limits, config.gateway.control_period_s);
  ASSERT_TRUE(stop);
  EXPECT_LE(stop->t_ramp - asked, 1ms);
  EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
}

TEST(Modes, EngagesAgainAfterSettle) {
  Line line(configure("thesis-wave"));
  line.engage_and_run_to(20);
  line.ask(ModeAction::settle);
  line.run_for(1);
  ASSERT_EQ(line.mode().state, ModeState::ready);
  line.run_for(5);
  line.ask(ModeAction::engage);
  line.run_for(14);
  ASSERT_EQ(line.mode().state, ModeState::engaged);
  line.take_motion();
  line.run_for(10);
  const auto motion = line.take_motion();
  EXPECT_LE(motion.swing_rms_deg, 0.12);
  EXPECT_LE(motion.load_error_rms_norm_m, 0.012);
}

TEST(Modes, SettleWinsOverEngageInOneCycleWhateverTheOrder) {
  for (const bool settle_first : {true, false}) {
    Line line(configure("calm"));
    line.run_to(10);
    ASSERT_EQ(line.mode().state, ModeState::ready);
    line.ask(settle_first ? ModeAction::settle : ModeAction::engage);
    line.ask(settle_first ? ModeAction::engage : ModeAction::settle);
    line.run_for(1);
    EXPECT_EQ(line.mode().state, ModeState::ready);
    for (const auto& mode : line.modes()) EXPECT_NE(mode.state, ModeState::engaged);

    line.ask(ModeAction::engage);
    line.run_for(1);
    ASSERT_EQ(line.mode().state, ModeState::engaged);
    line.ask(settle_first ? ModeAction::settle : ModeAction::engage);
    line.ask(settle_first ? ModeAction::engage : ModeAction::settle);
    line.run_for(2);
    EXPECT_EQ(line.mode().state, ModeState::ready);
  }
}

TEST(Modes, ObserveAndShadowEngageAndSendNothing) {
  for (const auto authority : {topic::Authority::observe, topic::Authority::shadow}) {
    Line line(configure("thesis-wave"));
    line.run_to(9);
    line.ask_authority(authority);
    line.engage_and_run_to(16);
    EXPECT_EQ(line.mode().state, ModeState::engaged);
    EXPECT_EQ(line.mode().authority, authority);
    for (const Step& step : line.steps()) {
      ASSERT_TRUE(step.at_rest());
      ASSERT_FALSE(step.following);
    }
    EXPECT_LT(fastest_joint(line.lockstep().lab().world()), 1e-3);
  }
}

TEST(Modes, LimitedStaysWithinATenthOfTheLimits) {
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  line.run_to(9);
  line.ask_authority(topic::Authority::limited);
  line.engage_and_run_to(20);
  ASSERT_EQ(line.mode().state, ModeState::engaged);
  double fastest = 0;
  for (const Step& step : line.steps()) {
    for (std::size_t i = 0; i < 6; ++i) {
      ASSERT_LE(std::abs(step.qd_radps[i]), 0.1 * config.gateway.limits.qd_max_radps[i] + 1e-12);
      fastest = std::max(fastest, std::abs(step.qd_radps[i]));
    }
  }
  EXPECT_GT(fastest, 0.01);
}

/// One reason for which engaging is refused, and how to bring it about.
struct Hindrance {
  std::string code;
  std::string device, fault;
  double from_s = 12;
  double ask_at_s = 14;
};
void PrintTo(const Hindrance& hindrance, std::ostream* out) {
  *out << hindrance.code;
}

class EngageIsRefused : public testing::TestWithParam<Hindrance> {};

TEST_P(EngageIsRefused, WithACodeAndASentenceAndGrantedWhenTheCauseIsGone) {
  const Hindrance& hindrance = GetParam();
  Line line(configure("thesis-wave"));
  line.run_to(hindrance.from_s);
  line.fault(hindrance.device, hindrance.fault, true);
  line.run_to(hindrance.ask_at_s);
  const auto told = line.mode().sequence_number;
  line.ask(ModeAction::engage);
  line.run_for(0.1);
  EXPECT_EQ(line.mode().state, ModeState::settled);
  EXPECT_EQ(line.mode().fault_code.view(), hindrance.code);
  EXPECT_GT(line.mode().reason.view().size(), 20U);
  EXPECT_GT(line.mode().sequence_number, told) << "a refusal is told";
  EXPECT_FALSE(line.mode().fault_latched);
  for (const Step& step : line.steps()) ASSERT_TRUE(step.at_rest());

  line.fault(hindrance.device, hindrance.fault, false);
  EXPECT_TRUE(line.run_until_state(ModeState::ready, 12)) << line.mode().reason.view();
  line.run_for(2);
  EXPECT_EQ(line.mode().state, ModeState::ready) << "nothing engages by itself";
  line.ask(ModeAction::engage);
  line.run_for(0.1);
  EXPECT_EQ(line.mode().state, ModeState::engaged);
}

std::string name_of(const testing::TestParamInfo<Hindrance>& test) {
  std::string name = test.param.code + "_by_" + test.param.fault + "_" + std::to_string(test.index);
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(ByFault, EngageIsRefused,
                         testing::Values(Hindrance{"mru1_stale", "mru1", "silent"},
                                         Hindrance{"mru1_unstable", "mru1", "unstable"},
                                         Hindrance{"arm_stale", "arm", "silent"},
                                         Hindrance{"arm_stale", "arm", "freeze_counter"},
                                         Hindrance{"winch_stale", "winch", "silent"},
                                         Hindrance{"winch_stale", "winch", "frozen_cycle"},
                                         Hindrance{"load_lost", "qualisys", "occlude:load"},
                                         Hindrance{"load_lost", "qualisys", "occlude:load", 12, 24},
                                         Hindrance{"platform_lost", "qualisys", "occlude:platform"},
                                         Hindrance{"no_estimate", "qualisys", "silent", 0, 8}),
                         name_of);

/// Runs to 12 s with a change in the samples, asks, and tells the mode after it.
topic::Mode refused_with(const std::function<void(TakenApart&)>& change, double ask_at_s = 12) {
  TakenApart line(configure("thesis-wave"));
  change(line);
  line.run_to(ask_at_s);
  line.ask(ModeAction::engage);
  line.run_to(ask_at_s + 0.01);
  for (const Step& step : line.steps()) EXPECT_TRUE(step.at_rest());
  return line.mode();
}

TEST(EngageIsRefusedByContent, WhileTheArmMoves) {
  const auto mode = refused_with(
      [](TakenApart& line) { line.change_arm = [](topic::ArmState& arm) { arm.qd_radps[2] = 0.02; }; });
  EXPECT_EQ(mode.state, ModeState::settled);
  EXPECT_EQ(mode.fault_code.view(), "arm_moving");
}

TEST(EngageIsRefusedByContent, WhileTheWinchIsNotReady) {
  const auto mode = refused_with(
      [](TakenApart& line) { line.change_winch = [](topic::WinchState& winch) { winch.ready = false; }; });
  EXPECT_EQ(mode.state, ModeState::settled);
  EXPECT_EQ(mode.fault_code.view(), "winch_not_ready");
}

TEST(EngageIsRefusedByContent, WhileTheWinchReportsAFault) {
  const auto mode = refused_with(
      [](TakenApart& line) { line.change_winch = [](topic::WinchState& winch) { winch.error = true; }; });
  EXPECT_EQ(mode.state, ModeState::settled);
  EXPECT_EQ(mode.fault_code.view(), "winch_fault");
}

TEST(EngageIsRefusedByContent, WhileTheEstimateSettles) {
  lockstep::Config config = configure("thesis-wave", 1, false);
  config.gateway.belief.camera.load_sd_m = 1.0;  // one that learns slowly, so that the moment can be met
  config.gateway.belief.camera.load_height_sd_m = 1.0;
  Line line(config);
  // Asked in every step, it says in every step what is missing.
  const auto settles = [&] {
    line.ask(ModeAction::engage);
    return line.mode().fault_code.view() == "estimate_settling";
  };
  ASSERT_TRUE(line.run_until(settles, 10)) << line.mode().reason.view();
  EXPECT_EQ(line.mode().state, ModeState::settled);
  for (const Step& step : line.steps()) ASSERT_TRUE(step.at_rest());
}

TEST(EngageIsRefusedByContent, BeforeADeviceWasHeard) {
  Line line(configure("thesis-wave"));
  line.fault("mru1", "silent", true);
  line.run_to(5);
  line.ask(ModeAction::engage);
  line.run_for(0.1);
  EXPECT_EQ(line.mode().state, ModeState::off);
}

TEST(EngagedByContent, AReferenceOutOfReachOrNotFiniteMovesNothingBeyondTheLimits) {
  const lockstep::Config config = configure("calm");
  for (const double far : {100.0, -3.0, std::nan("")}) {
    TakenApart line(config);
    line.run_to(10);
    line.ask(ModeAction::engage);
    line.run_to(12);
    ASSERT_EQ(line.mode().state, ModeState::engaged);
    topic::Reference reference;
    reference.p_world_load_m = {0.85, far, 3.9};
    line.refer(reference);
    line.run_to(20);
    EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
    if (std::isnan(far)) {
      EXPECT_EQ(line.mode().state, ModeState::engaged);
    } else {
      const auto q = line.lab().state().q_rad;
      for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_GE(q[i], config.gateway.limits.q_min_rad[i] - 0.01) << i;
        EXPECT_LE(q[i], config.gateway.limits.q_max_rad[i] + 0.01) << i;
      }
    }
  }
}

}  // namespace
}  // namespace motionlab::integration
