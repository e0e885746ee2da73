// Where the load is asked to be: a jump, a moving place, a place on the second ship, and nonsense.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "drivers/core/random.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using Eigen::Vector3d;

struct Follower {
  explicit Follower(const lockstep::Config& given)
      : config(given), line(given), references(line.lockstep().bus().advertise<topic::Reference>()) {}

  void ask(const Vector3d& p, const Vector3d& v = Vector3d::Zero(),
           topic::ReferenceFrame frame = topic::ReferenceFrame::world) {
    topic::Reference reference;
    reference.sequence_number = ++sent;
    reference.requester = "test";
    reference.frame = frame;
    Eigen::Map<Vector3d>(reference.p_world_load_m.data()) = p;
    Eigen::Map<Vector3d>(reference.v_world_load_mps.data()) = v;
    references.publish(reference);
  }
  [[nodiscard]] Vector3d load() { return line.lockstep().lab().state().crane.p_WL; }
  [[nodiscard]] Vector3d home() const {
    return Eigen::Map<const Vector3d>(config.gateway.p_world_load_reference_m.data());
  }
  [[nodiscard]] std::size_t beyond_limits() {
    return steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s);
  }

  lockstep::Config config;
  Line line;
  bus::Publisher<topic::Reference> references;
  std::uint64_t sent = 0;
};

TEST(Reference, AJumpIsApproachedSmoothlyAndTheLoadHangsStillThere) {
  Follower f(configure("thesis-wave"));
  f.line.engage_and_run_to(20);
  const Vector3d place = f.home() + Vector3d(0.15, 0.1, -0.2);
  f.ask(place);
  f.line.run_for(20);
  double error = 0, swing = 0;
  while (f.line.now_s() < 60) {
    f.line.step();
    error = std::max(error, (f.load() - place).norm());
    const auto state = f.line.lockstep().lab().state();
    swing = std::max(swing, std::hypot(state.crane.swing_rad[0], state.crane.swing_rad[1]));
  }
  EXPECT_EQ(f.line.mode().state, topic::ModeState::engaged) << f.line.mode().reason.view();
  EXPECT_LT(error, 0.025);
  EXPECT_LT(swing, 0.3 * std::numbers::pi / 180);
  EXPECT_EQ(f.beyond_limits(), 0u);
}

TEST(Reference, AMovingPlaceToldTenTimesASecondIsFollowedWithinTwoCentimetres) {
  Follower f(configure("thesis-wave"));
  f.line.engage_and_run_to(20);
  constexpr double kRadius = 0.12, kOmega = 2 * std::numbers::pi / 30;
  const auto place = [&](double s) {
    return Vector3d(f.home() + kRadius * Vector3d(std::sin(kOmega * s), 1 - std::cos(kOmega * s), 0));
  };
  double squares = 0;
  int count = 0;
  for (int i = 0; i < 40'000; ++i) {
    const double s = 1e-3 * i;
    if (i % 100 == 0) {
      f.ask(place(s), kRadius * kOmega * Vector3d(std::cos(kOmega * s), std::sin(kOmega * s), 0));
    }
    f.line.step();
    if (i < 10'000) continue;
    squares += (f.load() - place(s + 1e-3)).squaredNorm();
    ++count;
  }
  EXPECT_LT(std::sqrt(squares / count), 0.02);
  EXPECT_EQ(f.beyond_limits(), 0u);
}

TEST(Reference, AMovingPlaceThatIsNoLongerToldStands) {
  Follower f(configure("calm"));
  f.line.engage_and_run_to(20);
  f.ask(f.home(), Vector3d(0.1, 0, 0));
  f.line.run_for(15);
  EXPECT_NEAR(f.load().x() - f.home().x(), 0.025, 0.01) << "a quarter of a second of 0.1 m/s";
}

TEST(Reference, APlaceOnTheSecondShipRidesWithIt) {
  lockstep::Config config = configure("calm");
  config.lab.set_second_ship("sea");
  Follower f(config);
  f.line.engage_and_run_to(25);
  f.ask(f.home(), Vector3d::Zero(), topic::ReferenceFrame::em1500);
  f.line.run_for(15);
  const auto X_NW = config.lab.world.calibration.world_to_em1500.inverse();
  double squares = 0, moved = 0;
  int count = 0;
  while (f.line.now_s() < 100) {
    f.line.step();
    const Vector3d place = f.line.lockstep().lab().state().second.X_WB * (X_NW * f.home());
    squares += (f.load() - place).squaredNorm();
    moved += (place - f.home()).squaredNorm();
    ++count;
  }
  EXPECT_EQ(f.line.mode().state, topic::ModeState::engaged) << f.line.mode().reason.view();
  RecordProperty("error_rms_m", std::to_string(std::sqrt(squares / count)));
  RecordProperty("place_rms_m", std::to_string(std::sqrt(moved / count)));
  EXPECT_LT(std::sqrt(squares), 0.5 * std::sqrt(moved)) << "no camera sees that ship: its unit alone must do";
  EXPECT_EQ(f.beyond_limits(), 0u);
}

TEST(Reference, OnASecondShipThatFallsSilentBringsTheCraneToRest) {
  lockstep::Config config = configure("calm");
  config.lab.set_second_ship("sea");
  config.faults.push_back(lab::PlannedFault::parse("mru2:silent@40"));
  Follower f(config);
  f.line.engage_and_run_to(25);
  f.ask(f.home(), Vector3d::Zero(), topic::ReferenceFrame::em1500);
  f.line.run_to(39.9);
  ASSERT_EQ(f.line.mode().state, topic::ModeState::engaged) << f.line.mode().reason.view();
  f.line.run_to(41);
  EXPECT_EQ(f.line.mode().state, topic::ModeState::fault);
  EXPECT_EQ(f.line.mode().fault_code.view(), "mru2_stale");
  EXPECT_TRUE(f.line.steps().back().at_rest());
}

TEST(Reference, InWorldASilentSecondShipIsNoMatter) {
  lockstep::Config config = configure("calm");
  config.faults.push_back(lab::PlannedFault::parse("mru2:silent@25"));
  Follower f(config);
  f.line.engage_and_run_to(30);
  EXPECT_EQ(f.line.mode().state, topic::ModeState::engaged);
}

/// Places that a hostile peer might tell.
std::vector<Vector3d> hostile_vectors() {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  return {Vector3d(nan, nan, nan), Vector3d(inf, -inf, 0),  Vector3d(1e300, -1e300, 1e300),
          Vector3d(19, 19, 19),    Vector3d(-19, -19, -19), Vector3d(0, 0, 0),
          Vector3d(1e-300, 0, 20), Vector3d(0.8, -0.4, 3.9)};
}

TEST(Reference, HostileOnesEachMillisecondMoveNothingBeyondTheLimits) {
  const auto vectors = hostile_vectors();
  for (std::uint32_t seed = 1; seed <= 4; ++seed) {
    Follower f(configure(seed % 2 ? "calm" : "thesis-wave"));
    f.line.engage_and_run_to(15);
    ASSERT_EQ(f.line.mode().state, topic::ModeState::engaged) << f.line.mode().reason.view();
    Random random(seed);
    const auto& limits = f.config.gateway.limits;
    bool moved = false;
    for (int ms = 0; ms < 10'000; ++ms) {
      const int samples = ms % 1000 == 0 ? 200 : 1;
      for (int i = 0; i < samples; ++i) {
        f.ask(vectors[random.below(static_cast<std::uint32_t>(vectors.size()))],
              vectors[random.below(static_cast<std::uint32_t>(vectors.size()))],
              static_cast<topic::ReferenceFrame>(random.below(4)));
      }
      f.line.step();
      moved = moved || !f.line.steps().back().at_rest();
      const auto q = f.line.lockstep().lab().state().q_rad;
      for (std::size_t i = 0; i < 6; ++i) {
        ASSERT_LE(q[i], limits.q_max_rad[i] + 2e-3)
            << "joint " << i + 1 << " at " << ms << " ms, seed " << seed;
        ASSERT_GE(q[i], limits.q_min_rad[i] - 2e-3)
            << "joint " << i + 1 << " at " << ms << " ms, seed " << seed;
      }
    }
    EXPECT_TRUE(moved) << "some of these places are possible ones";
    EXPECT_EQ(f.beyond_limits(), 0u) << seed;
  }
}

TEST(Reference, ImpossibleOnesEachMillisecondChangeNoCommandByABit) {
  Follower with(configure("thesis-wave")), without(configure("thesis-wave"));
  for (Follower* const f : {&with, &without}) f->line.engage_and_run_to(15);
  ASSERT_EQ(with.line.mode().state, topic::ModeState::engaged) << with.line.mode().reason.view();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int ms = 0; ms < 5000; ++ms) {
    with.ask(Vector3d(nan, 0, 0));
    with.ask(with.home(), Vector3d(0, 1e300, 0));
    with.ask(Vector3d(0.3, 0.3, 3), Vector3d::Zero(), static_cast<topic::ReferenceFrame>(2));
    with.ask(Vector3d(0.3, 0.3, 3), Vector3d::Zero(), static_cast<topic::ReferenceFrame>(0xffffffffU));
    with.line.step();
    without.line.step();
  }
  EXPECT_EQ(with.line.commands_hash(), without.line.commands_hash());
}

TEST(Reference, NonsenseIsNotFollowed) {
  Follower f(configure("calm"));
  f.line.engage_and_run_to(20);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  f.ask(Vector3d(nan, 0, 0));
  f.ask(f.home(), Vector3d(0, std::numeric_limits<double>::infinity(), 0));
  f.ask(Vector3d(1e6, 0, 0));
  f.line.run_for(10);
  EXPECT_EQ(f.line.mode().state, topic::ModeState::engaged) << f.line.mode().reason.view();
  EXPECT_LT((f.load() - f.home()).norm(), 0.012);
}

}  // namespace
}  // namespace motionlab::integration
