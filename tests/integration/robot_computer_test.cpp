// What becomes of the arm when the gateway is gone: the hardened robot computer stops, the published one does
// not.
#include <gtest/gtest.h>

#include "tests/integration/taken_apart.hpp"

namespace motionlab::integration {
namespace {

double fastest_joint(const plant::World& world) {
  double fastest = 0;
  for (const double v : world.qd_radps()) fastest = std::max(fastest, std::abs(v));
  return fastest;
}

/// Engages, destroys the gateway in the middle of a movement, and tells the fastest joint after a while.
struct Aftermath {
  double before_radps = 0;
  double after_half_s_radps = 0;
  double after_2_s_radps = 0;
  double q_travelled_rad = 0;
};

Aftermath destroy_while_moving(bool hardened) {
  lockstep::Config config = configure("thesis-wave");
  config.lab.arm.hardened = hardened;
  TakenApart line(config);
  line.run_to(10);
  line.ask(topic::ModeAction::engage);
  line.run_to(20);
  EXPECT_EQ(line.mode().state, topic::ModeState::engaged) << line.mode().reason.view();
  while (line.now_s() < 30 && fastest_joint(line.lab().world()) < 0.08) line.step();
  Aftermath result;
  result.before_radps = fastest_joint(line.lab().world());
  const auto q_before = line.lab().state().q_rad;
  line.destroy_gateway();
  line.run_to(line.now_s() + 0.5);
  result.after_half_s_radps = fastest_joint(line.lab().world());
  line.run_to(line.now_s() + 1.5);
  result.after_2_s_radps = fastest_joint(line.lab().world());
  const auto q_after = line.lab().state().q_rad;
  for (std::size_t i = 0; i < 6; ++i) {
    result.q_travelled_rad = std::max(result.q_travelled_rad, std::abs(q_after[i] - q_before[i]));
  }
  return result;
}

TEST(RobotComputer, HardenedComesToRestWhenTheGatewayIsGone) {
  const Aftermath got = destroy_while_moving(true);
  EXPECT_GT(got.before_radps, 0.08);
  EXPECT_LT(got.after_half_s_radps, 0.002);
  EXPECT_LT(got.after_2_s_radps, 0.001);
  EXPECT_LT(got.q_travelled_rad, 0.03);
}

// The published defect that the deadman and `[comau] watchdog` are for: nobody stops it.
TEST(RobotComputer, FaithfulIntegratesTheLastVelocityForEver) {
  const Aftermath got = destroy_while_moving(false);
  EXPECT_GT(got.before_radps, 0.08);
  EXPECT_GT(got.after_half_s_radps, 0.05);
  EXPECT_GT(got.q_travelled_rad, 0.1);
}

}  // namespace
}  // namespace motionlab::integration
