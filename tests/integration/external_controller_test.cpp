// Somebody else's controller takes the command, keeps it by commanding, and loses it by silence; a hostile
// one moves nothing.
#include <gtest/gtest.h>

#include <limits>

#include "drivers/core/random.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

/// A controller of somebody's, on the bus of a calm laboratory.
class Pilot {
 public:
  Pilot(Line& line, std::string_view name)
      : line_(line),
        name_(name),
        arm_(line.lockstep().bus().advertise<topic::ArmCommand>()),
        winch_(line.lockstep().bus().advertise<topic::WinchCommand>()),
        requests_(line.lockstep().bus().advertise<topic::ModeRequest>()) {}

  void engage(bool external = true) {
    topic::ModeRequest request;
    request.requester = name_;
    request.action = ModeAction::engage;
    request.external_controller = external;
    requests_.publish(request);
  }
  void command(double qd_radps, double wire_speed_mps = 0) {
    topic::ArmCommand arm;
    arm.device = "arm";
    arm.requester = name_;
    arm.t_created_ns = to_ns(line_.now());
    arm.follow = true;
    arm.qd_wanted_radps[0] = qd_radps;
    arm_.publish(arm);
    topic::WinchCommand winch;
    winch.device = "winch";
    winch.requester = name_;
    winch.t_created_ns = arm.t_created_ns;
    winch.wire_speed_wanted_mps = wire_speed_mps;
    winch_.publish(winch);
  }
  void command_for(double s, double qd_radps, double wire_speed_mps = 0) {
    for (const double end = line_.now_s() + s; line_.now_s() < end;) {
      command(qd_radps, wire_speed_mps);
      line_.step();
    }
  }

 private:
  Line& line_;
  Text<32> name_;
  bus::Publisher<topic::ArmCommand> arm_;
  bus::Publisher<topic::WinchCommand> winch_;
  bus::Publisher<topic::ModeRequest> requests_;
};

double first_joint(Line& line) {
  return line.lockstep().lab().world().qd_radps()[0];
}

TEST(ExternalController, TakesTheCommandKeepsItAndLosesItBySilence) {
  Line line(configure("calm"));
  ASSERT_TRUE(line.run_until_state(ModeState::ready, 12)) << line.mode().reason.view();
  Pilot pilot(line, "pilot");

  pilot.engage();
  line.run_for(0.01);
  EXPECT_NE(line.mode().state, ModeState::engaged);
  EXPECT_TRUE(std::any_of(line.modes().begin(), line.modes().end(), [](const topic::Mode& mode) {
    return mode.fault_code.view() == "controller_silent";
  }));
  pilot.command_for(0.1, 0.2);
  pilot.engage();
  pilot.command_for(0.1, 0.2);
  EXPECT_NE(line.mode().state, ModeState::engaged);
  EXPECT_TRUE(std::any_of(line.modes().begin(), line.modes().end(), [](const topic::Mode& mode) {
    return mode.fault_code.view() == "controller_moving";
  }));

  pilot.command_for(0.1, 0);
  pilot.engage();
  pilot.command_for(0.3, 0);
  ASSERT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  EXPECT_EQ(line.mode().owner.view(), "pilot");
  EXPECT_TRUE(line.mode().external_controller);
  pilot.command_for(1, 0.1, 0.05);
  EXPECT_NEAR(first_joint(line), 0.1, 0.01);

  // Silence.
  const LabTime last = line.now();
  ASSERT_TRUE(line.run_until_state(ModeState::fault, 1));
  EXPECT_EQ(line.mode().fault_code.view(), "lease_lost");
  EXPECT_LE(line.now() - last, 102ms);
  line.run_for(1);
  EXPECT_TRUE(line.steps().back().at_rest());
  EXPECT_NEAR(first_joint(line), 0, 1e-3);
  pilot.command_for(1, 0.1);
  EXPECT_EQ(line.mode().state, ModeState::fault) << "coming back does not help";
  EXPECT_NEAR(first_joint(line), 0, 1e-3);
}

TEST(ExternalController, WhateverItWantsStaysWithinTheGuard) {
  const lockstep::Config config = configure("calm");
  Line line(config);
  ASSERT_TRUE(line.run_until_state(ModeState::ready, 12));
  Pilot pilot(line, "pilot");
  pilot.command_for(0.1, 0);
  pilot.engage();
  pilot.command_for(0.3, 0);
  ASSERT_EQ(line.mode().state, ModeState::engaged);
  for (const double wanted : {1e300, -1e300, std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(), 5.0, -5.0}) {
    pilot.command_for(1.5, wanted, wanted);
    EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
    const auto q = line.lockstep().lab().state().q_rad;
    EXPECT_LE(std::abs(q[0]), config.gateway.limits.q_max_rad[0] + 2e-3) << wanted;
  }
}

TEST(ExternalController, WhoDoesNotHoldTheLeaseMovesNothing) {
  Line with(configure("calm")), without(configure("calm"));
  for (Line* const line : {&with, &without}) line->engage_and_run_to(11);
  ASSERT_EQ(with.mode().state, ModeState::engaged);
  Pilot mallory(with, "mallory"), forger(with, "motionlab-gateway");
  for (int i = 0; i < 2000; ++i) {
    mallory.command(3, 1);
    forger.command(3, 1);
    if (i % 100 == 0) mallory.engage();
    with.step();
    without.step();
  }
  EXPECT_EQ(with.mode().state, ModeState::engaged);
  EXPECT_EQ(with.mode().owner, without.mode().owner);
  EXPECT_EQ(with.commands_hash(), without.commands_hash());
  EXPECT_GT(with.lockstep().bus().refused<topic::ArmCommand>(), 1000U) << "nobody speaks for the gateway";
}

TEST(ModeRequests, AHostileFloodOfThemMovesNothingBeyondTheLimitsAndASettleAmongThemBringsRest) {
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    const lockstep::Config config = configure(seed % 2 ? "calm" : "thesis-wave");
    Line line(config);
    line.engage_and_run_to(12);
    ASSERT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
    auto requests = line.lockstep().bus().advertise<topic::ModeRequest>();
    Random random(seed);
    const auto flood = [&] {
      for (int i = 0; i < 20; ++i) {  // everything but a settle, and what is no action at all
        topic::ModeRequest request;
        if (random.chance(0.9)) request.requester = std::to_string(random.below(1000));
        request.action = static_cast<ModeAction>(1 + random.below(6));
        request.authority = static_cast<topic::Authority>(random.below(7));
        request.external_controller = random.chance(0.5);
        requests.publish(request);
      }
    };
    for (int ms = 0; ms < 3000; ++ms) {
      flood();
      line.step();
      ASSERT_LE(line.mode().authority, topic::Authority::full);
    }
    // From here on each step hears a settle, in the midst of the others.
    const double stopped_by = line.now_s() + 3;
    while (line.now_s() < stopped_by) {
      flood();
      line.ask(ModeAction::settle);
      flood();
      line.step();
      EXPECT_NE(line.mode().state, ModeState::engaged);
    }
    EXPECT_TRUE(line.steps().back().at_rest()) << seed;
    EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
  }
}

TEST(CrossCheck, EngagingIsRefusedWithNumbersWhileSensorsDisagree) {
  struct Case {
    const char* code;
    void (*spoil)(lockstep::Config&);
  };
  const Case cases[] = {
      {"tilt_disagrees",
       [](lockstep::Config& c) {
         auto& R_BM = c.gateway.belief.calibration.X_BM.R;
         R_BM = R_BM * math::rot_x(0.05);
       }},
      {"load_disagrees", [](lockstep::Config& c) { c.gateway.winch.driver.wire_at_zero_travel_m += 0.6; }},
  };
  for (const Case& wrong : cases) {
    lockstep::Config config = configure("calm");
    wrong.spoil(config);
    Line line(config);
    line.engage_and_run_to(12);
    EXPECT_EQ(line.mode().state, ModeState::settled);
    EXPECT_EQ(line.mode().fault_code.view(), wrong.code) << line.mode().reason.view();
    EXPECT_NE(line.mode().reason.view().find('.'), std::string_view::npos) << "with numbers";
  }
}

}  // namespace
}  // namespace motionlab::integration
