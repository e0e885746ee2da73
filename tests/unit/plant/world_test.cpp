#include "simulators/plant/world.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace motionlab::plant {
namespace {

using Eigen::Vector3d;

LabTime at_ms(double ms) {
  return LabTime{from_seconds(1e-3 * ms)};
}

Scenario scenario(std::string_view name) {
  return scenario_named(name).value();
}

TEST(World, StartsPlumbAndAtRestWithTheToolAtItsPublishedPlace) {
  World world(WorldConfig::ideal(), scenario("thesis-wave"), 1);
  const WorldState s = world.state();
  EXPECT_LT((s.crane.tool.p_W - Vector3d(0.847625, -0.407825, 5.919269)).norm(), 2e-6);
  EXPECT_EQ(s.crane.swing_rad.norm(), 0);
  EXPECT_EQ(s.crane.v_WL.norm(), 0);
  EXPECT_NEAR((s.crane.tool.p_W - s.crane.p_WL).z(), 2.0 * (1 + 12 * 9.81 / 2e6), 1e-12);
  EXPECT_NEAR(s.crane.tension_n, 12 * 9.81, 1e-6);
  EXPECT_EQ(s.winch_length_m, 2.0);
}

TEST(World, StaysAtRestInACalm) {
  World world({}, scenario("calm"), 1);
  const WorldState start = world.state();
  world.advance(at_ms(5000));
  const WorldState s = world.state();
  EXPECT_LT((s.crane.p_WL - start.crane.p_WL).norm(), 1e-12);
  EXPECT_LT(s.twin.swing_rad.norm(), 1e-12);
}

TEST(World, RunsWholeTicksOnlyAndNeverBackwards) {
  World world({}, scenario("calm"), 1, at_ms(1000));
  EXPECT_EQ(world.time(), at_ms(1000));
  world.advance(at_ms(1000.39));
  EXPECT_EQ(world.time(), at_ms(1000));
  world.advance(at_ms(1000.4));
  EXPECT_EQ(world.time(), at_ms(1000.4));
  world.advance(at_ms(1005.3));
  EXPECT_EQ(world.time(), at_ms(1005.2));
  world.advance(at_ms(900));
  EXPECT_EQ(world.time(), at_ms(1005.2));
}

TEST(World, DiffersFromTheBeliefByWhatTheConfigurationSays) {
  World world({}, scenario("calm"), 1);
  const WorldState s = world.state();
  EXPECT_NEAR(s.crane.free_length_m - s.winch_length_m, 0.002, 1e-15);
  const double off = (s.crane.tool.p_W - Vector3d(0.847625, -0.407825, 5.919269)).norm();
  EXPECT_GT(off, 1e-4);
  EXPECT_LT(off, 5e-4 + 8.7e-4 * 3.5);
}

TEST(World, TheSameSeedGivesTheSameBytesAndAnotherSeedOthers) {
  const auto run = [](std::uint64_t seed) {
    World world({}, scenario("sea"), seed);
    for (int i = 1; i <= 200; ++i) {
      world.set_joint_set_points({0.001 * i, 0, -1.57, 0, 0, 0});
      world.advance(at_ms(10.0 * i));
    }
    const WorldState s = world.state();
    std::array<double, 9> values{s.crane.p_WL.x(), s.crane.p_WL.y(),      s.crane.p_WL.z(),
                                 s.twin.p_WL.x(),  s.twin.p_WL.y(),       s.twin.p_WL.z(),
                                 s.q_rad[0],       s.platform.X_WB.p.x(), s.crane.tension_n};
    return values;
  };
  const auto a = run(1), b = run(1), c = run(2);
  EXPECT_EQ(std::memcmp(a.data(), b.data(), sizeof a), 0);
  EXPECT_NE(std::memcmp(a.data(), c.data(), sizeof a), 0);
}

TEST(World, HowOftenItIsAskedChangesNothing) {
  World often({}, scenario("sea"), 1), seldom({}, scenario("sea"), 1);
  for (int i = 1; i <= 5000; ++i) {
    often.advance(at_ms(0.4 * i));
    (void)often.sample(at_ms(0.4 * i - 0.2));
  }
  seldom.advance(at_ms(2000));
  EXPECT_EQ(often.state().crane.p_WL, seldom.state().crane.p_WL);
}

TEST(World, AShipThatStartsLaterMovesAsOneThatStartsAtOnce) {
  Scenario later = scenario("thesis-wave");
  later.delay_s = 1.2345;
  World delayed({}, later, 1), at_once({}, scenario("thesis-wave"), 1);
  delayed.advance(at_ms(1200));
  EXPECT_EQ(delayed.state().platform.v_WB.norm(), 0);
  delayed.advance(at_ms(9234.8));
  at_once.advance(at_ms(8000.4));
  const Vector3d p = delayed.sample(at_ms(9234.5)).platform.X_WB.p;
  EXPECT_LT((p - at_once.sample(at_ms(8000)).platform.X_WB.p).norm(), 1e-12);
}

TEST(World, WithoutCommandsTheCraneIsItsTwin) {
  World world({}, scenario("thesis-wave"), 1);
  world.advance(at_ms(20000));
  const WorldState s = world.state();
  EXPECT_LT((s.crane.p_WL - s.twin.p_WL).norm(), 1e-9);
  EXPECT_GT(s.twin.swing_rad.norm(), 0.01);
}

TEST(World, ASampleInsideTheTickIsWhatAFinerWorldWouldSay) {
  World world({}, scenario("thesis-wave"), 1);
  world.set_joint_set_points({0.02, 0.01, -1.55, 0, 0, 0});
  world.set_wire_set_point(2.01);
  world.advance(at_ms(7000));
  const WorldState before = world.state();
  world.advance(at_ms(7000.4));
  const WorldState after = world.state(), mid = world.sample(at_ms(7000.2));
  EXPECT_EQ(mid.t, at_ms(7000.2));
  EXPECT_LT((0.5 * (before.crane.p_WL + after.crane.p_WL) - mid.crane.p_WL).norm(), 1e-6);
  EXPECT_LT((0.5 * (before.crane.v_WL + after.crane.v_WL) - mid.crane.v_WL).norm(), 1e-4);
  EXPECT_EQ(world.sample(at_ms(0)).t, at_ms(7000)) << "not older than the last tick";
  EXPECT_EQ(world.sample(at_ms(9000)).t, at_ms(7000.4));
}

TEST(World, ToolVelocityAndAccelerationAreDerivativesOfItsPosition) {
  World world({}, scenario("thesis-wave"), 1);
  // Smooth joint motion: a slow sine, updated every tick.
  const auto run_to = [&](int tick) {
    for (int i = static_cast<int>(world.time().time_since_epoch() / World::kTick); i < tick; ++i) {
      const double q = 0.1 * std::sin(0.0004 * i);
      world.set_joint_set_points({q, 0.5 * q, -1.57 + q, 0, 0, 0});
      world.advance(world.time() + World::kTick);
    }
    return world.state();
  };
  const WorldState a = run_to(20000), b = run_to(20010), c = run_to(20020);
  const double h = 0.004;
  EXPECT_LT(((c.crane.tool.p_W - a.crane.tool.p_W) / (2 * h) - b.crane.tool.v_W).norm(), 1e-5);
  EXPECT_LT(((c.crane.tool.v_W - a.crane.tool.v_W) / (2 * h) - b.crane.tool.a_W).norm(), 0.02)
      << "within the saw-tooth that set points held for a tick make";
}

TEST(World, JointsAreSlowerThanTheModelByTheConfiguredFactor) {
  const auto lag = [](const WorldConfig& config) {
    World world(config, Scenario{.sea = Sea::calm}, 1);
    const double rate = 0.1;
    for (int i = 1; i <= 5000; ++i) {
      world.set_joint_set_points({rate * 0.0004 * (i - 1), 0, -1.57, 0, 0, 0});
      world.advance(LabTime{World::kTick * i});
    }
    return 2.0 - world.state().q_rad[0] / rate;
  };
  const double tick = 0.0004, expected = 2 * 0.7 / 25.1327;
  EXPECT_NEAR(lag(WorldConfig::ideal()), 0.0024 + tick / 2 + expected, 1e-5);
  EXPECT_NEAR(lag({}), 0.0024 + tick / 2 + expected / 0.9, 1e-5);
}

TEST(World, TheWinchMovesTheLoad) {
  World world(WorldConfig::ideal(), scenario("calm"), 1);
  const double z = world.state().crane.p_WL.z();
  for (int i = 1; i <= 1000; ++i) {
    world.set_wire_set_point(2.0 + 0.0001 * i);
    world.advance(at_ms(5.0 * i));
  }
  world.advance(at_ms(8000));
  EXPECT_NEAR(world.state().crane.p_WL.z(), z - 0.1, 1e-4);
  EXPECT_NEAR(world.state().winch_torque_nm, 12 * 9.81 * 0.0218304 / 6.283185307, 1e-3);
}

}  // namespace
}  // namespace motionlab::plant
