// A required device falls silent: ramp to rest, latch, and nothing resumes by itself.
#include <gtest/gtest.h>

#include <string>

#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using topic::LinkState;
using topic::ModeAction;
using topic::ModeState;

enum class Death {
  silent,     ///< the device says nothing more
  cable,      ///< nothing passes in either direction, nobody is told
  processes,  ///< kill -9: connections are reset, ports are closed
};

struct Loss {
  std::string device;
  Death death = Death::silent;
  std::string code;
  Nanoseconds ramp_within{};  ///< 3 periods + 20 ms after the last sample
};
void PrintTo(const Loss& loss, std::ostream* out) {
  *out << loss.device;
}

class DeviceLoss : public testing::TestWithParam<Loss> {
 protected:
  /// Takes the device away, or gives it back.
  static void take_away(Line& line, const Loss& loss, bool away) {
    const auto& gateway = line.config().gateway;
    if (loss.death == Death::silent) return line.fault(loss.device, "silent", away);
    if (loss.device == "winch") {
      line.network().set_stream_fault(gateway.winch.plc, {.refuse = away && loss.death == Death::processes,
                                                          .silent = away && loss.death == Death::cable});
      if (away && loss.death == Death::processes) line.network().reset_streams(gateway.winch.plc);
      return;
    }
    const DatagramFault cut{.silent = away};
    if (loss.device == "mru1") line.network().set_datagram_fault(gateway.mrus.front().listen, cut);
    if (loss.device == "arm") {
      line.network().set_datagram_fault(gateway.comau.listen, cut);
      line.network().set_datagram_fault(gateway.comau.driver.robot_computer, cut);
    }
  }

  static LabTime last_sample(Line& line, const std::string& device) {
    auto& bus = line.lockstep().bus();
    if (device == "mru1") return from_ns(bus.reader<topic::Mru>("mru1").newest()->t_received_ns);
    if (device == "arm") return from_ns(bus.reader<topic::ArmState>("arm").newest()->t_received_ns);
    return from_ns(bus.reader<topic::WinchState>("winch").newest()->t_received_ns);
  }
};

TEST_P(DeviceLoss, RampsToRestLatchesReconnectsAndDoesNotResume) {
  const Loss& loss = GetParam();
  const lockstep::Config config = configure("thesis-wave");
  const auto& limits = config.gateway.limits;
  const double period_s = config.gateway.control_period_s;
  Line line(config);
  line.engage_and_run_to(22.3);
  ASSERT_EQ(line.mode().state, ModeState::engaged);
  ASSERT_FALSE(line.steps().back().at_rest());

  take_away(line, loss, true);
  line.run_for(0.001);
  const LabTime gone = line.now();
  ASSERT_TRUE(line.run_until_state(ModeState::fault, 1));
  const LabTime last = last_sample(line, loss.device);
  ASSERT_TRUE(line.run_until([&] { return line.health(loss.device).link != LinkState::up; }, 0.3));
  EXPECT_TRUE(line.health(loss.device).link == LinkState::stale ||
              line.health(loss.device).link == LinkState::down ||
              line.health(loss.device).link == LinkState::connecting);
  EXPECT_LE(line.now() - gone, 200ms);
  line.run_for(2);

  const auto stop = last_stop(line.steps(), limits, period_s);
  ASSERT_TRUE(stop);
  EXPECT_LE(stop->t_ramp - last, loss.ramp_within);
  RecordProperty("ramp_after_ms", std::to_string(1e3 * seconds(stop->t_ramp - last)));
  RecordProperty("rest_after_ms", std::to_string(1e3 * seconds(stop->t_rest - last)));
  EXPECT_EQ(steps_beyond_limits(line.steps(), limits, period_s), 0U);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  EXPECT_TRUE(line.mode().fault_latched);
  EXPECT_EQ(line.mode().fault_code.view(), loss.code);
  EXPECT_NE(line.mode().reason.view().find("reset"), std::string_view::npos) << line.mode().reason.view();
  EXPECT_FALSE(line.health(loss.device).advice.empty());

  // The cause persists: neither engage nor reset helps.
  line.ask(ModeAction::engage);
  line.run_for(0.1);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  line.ask(ModeAction::reset);
  line.run_for(0.1);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  EXPECT_EQ(line.mode().fault_code.view(), loss.code);

  // It returns: the link comes up, nothing moves.
  take_away(line, loss, false);
  EXPECT_TRUE(line.run_until([&] { return line.health(loss.device).link == LinkState::up; }, 8))
      << line.health(loss.device).advice.view();
  const std::size_t returned = line.steps().size();
  line.run_for(10);
  EXPECT_EQ(line.health(loss.device).link, LinkState::up);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  line.ask(ModeAction::engage);
  line.run_for(0.1);
  EXPECT_EQ(line.mode().state, ModeState::fault) << "engage is refused until reset";
  for (std::size_t k = returned; k < line.steps().size(); ++k) ASSERT_TRUE(line.steps()[k].at_rest());

  // Reset and engage: the load becomes still again.
  line.ask(ModeAction::reset);
  EXPECT_TRUE(line.run_until_state(ModeState::ready, 10)) << line.mode().reason.view();
  line.run_for(1);
  EXPECT_EQ(line.mode().state, ModeState::ready) << "a reset engages nothing";
  line.ask(ModeAction::engage);
  line.run_for(15);
  ASSERT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  line.take_motion();
  line.run_for(10);
  const auto motion = line.take_motion();
  EXPECT_LE(motion.swing_rms_deg, 0.12);
  EXPECT_LE(motion.load_error_rms_norm_m, 0.012);
  EXPECT_EQ(steps_beyond_limits(line.steps(), limits, period_s), 0U);
}

std::string name_of(const testing::TestParamInfo<Loss>& test) {
  constexpr std::string_view kHow[] = {"silent", "cable", "killed"};
  return test.param.device + "_" + std::string(kHow[static_cast<std::size_t>(test.param.death)]);
}

INSTANTIATE_TEST_SUITE_P(OfARequiredOne, DeviceLoss,
                         testing::Values(Loss{"mru1", Death::silent, "mru1_stale", 35ms},
                                         Loss{"mru1", Death::cable, "mru1_stale", 35ms},
                                         Loss{"arm", Death::silent, "arm_stale", 35ms},
                                         Loss{"arm", Death::cable, "arm_stale", 35ms},
                                         Loss{"winch", Death::silent, "winch_stale", 50ms},
                                         Loss{"winch", Death::cable, "winch_stale", 50ms},
                                         Loss{"winch", Death::processes, "winch_stale", 50ms}),
                         name_of);

TEST(DeviceLossFacts, TheSecondShipsUnitIsMissedByNobody) {
  Line line(configure("thesis-wave"));
  line.engage_and_run_to(20);
  line.fault("mru2", "silent", true);
  line.run_for(3);
  EXPECT_EQ(line.mode().state, ModeState::engaged);
  EXPECT_NE(line.health("mru2").link, LinkState::up);
  EXPECT_FALSE(line.health("mru2").required);
}

TEST(DeviceLossFacts, AWinchDriveFaultEndsTheEngagement) {
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  line.engage_and_run_to(22.3);
  line.fault("winch", "drive_fault", true);
  line.run_for(2);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  EXPECT_EQ(line.mode().fault_code.view(), "winch_fault");
  EXPECT_TRUE(last_stop(line.steps(), config.gateway.limits, config.gateway.control_period_s));
  EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);
}

TEST(DeviceLossFacts, AnUnstableUnitEndsTheEngagement) {
  Line line(configure("thesis-wave"));
  line.engage_and_run_to(22.3);
  line.fault("mru1", "unstable", true);
  line.run_for(2);
  EXPECT_EQ(line.mode().state, ModeState::fault);
  EXPECT_EQ(line.mode().fault_code.view(), "mru1_unstable");
  EXPECT_TRUE(line.steps().back().at_rest());
}

/// What keeps the arm from doing what it is told, with answers that look healthy.
class ArmIgnores : public testing::TestWithParam<const char*> {};

TEST_P(ArmIgnores, IsNoticedLatchedAndNotResumed) {
  Line line(configure("thesis-wave"));
  line.engage_and_run_to(22.3);
  ASSERT_EQ(line.mode().state, ModeState::engaged);
  line.fault("arm", GetParam(), true);
  ASSERT_TRUE(line.run_until_state(ModeState::fault, 1));
  EXPECT_EQ(line.mode().fault_code.view(), "arm_ignores");
  line.run_for(2);
  EXPECT_TRUE(line.steps().back().at_rest());
  line.fault("arm", GetParam(), false);
  line.run_for(2);
  EXPECT_EQ(line.mode().state, ModeState::fault) << "nothing resumes by itself";
  EXPECT_TRUE(line.steps().back().at_rest());
  line.ask(ModeAction::reset);
  EXPECT_TRUE(line.run_until_state(ModeState::ready, 10)) << line.mode().reason.view();
}

INSTANTIATE_TEST_SUITE_P(Of, ArmIgnores, testing::Values("hold", "local", "drive_off"),
                         [](const auto& of) { return std::string(of.param); });

}  // namespace
}  // namespace motionlab::integration
