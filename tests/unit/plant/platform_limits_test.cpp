#include "simulators/plant/platform_limits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace motionlab::plant {
namespace {

using testing::HasSubstr;

ShipMotion motion(const char* name, std::uint64_t seed = 1, double height_factor = 1) {
  Scenario s = scenario_named(name).value();
  s.significant_height_m *= height_factor;
  return ShipMotion(s, seed);
}

TEST(PlatformLimits, EveryNamedScenarioStaysWithinTheMachine) {
  for (const char* name : {"thesis-wave", "sea", "pierson-moskowitz", "calm"}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      EXPECT_FALSE(excess(motion(name, seed), PlatformLimits::mechanical(), 120))
          << name << ", seed " << seed;
    }
  }
}

TEST(PlatformLimits, TheThesisWaveJustTouchesWhatTheLaboratoryAllows) {
  EXPECT_FALSE(excess(motion("thesis-wave"), PlatformLimits::plc(), 600));
  PlatformLimits tighter = PlatformLimits::plc();
  tighter.max[3] *= 0.999;
  EXPECT_TRUE(excess(motion("thesis-wave"), tighter, 600));
}

TEST(PlatformLimits, SayWhichOfThemIsExceededMost) {
  const auto found = excess(motion("pierson-moskowitz", 1, 2), PlatformLimits::mechanical(), 600);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->coordinate, 2);
  EXPECT_EQ(found->quantity, Excess::Quantity::acceleration);
  EXPECT_EQ(found->allowed, 0.8);
  const std::string text = describe(*found, PlatformLimits::mechanical());
  EXPECT_THAT(text, HasSubstr("heave: "));
  EXPECT_THAT(text, HasSubstr("m/s²"));
  EXPECT_THAT(text, HasSubstr("the mechanical limit is 0.8 m/s²"));
}

TEST(PlatformLimits, TheShareThatFitsFitsAndNoMore) {
  const auto found = excess(motion("pierson-moskowitz", 1, 2), PlatformLimits::mechanical(), 600);
  ASSERT_TRUE(found);
  EXPECT_FALSE(
      excess(motion("pierson-moskowitz", 1, 2 * found->share_that_fits), PlatformLimits::mechanical(), 600));
  EXPECT_TRUE(excess(motion("pierson-moskowitz", 1, 2.01 * found->share_that_fits),
                     PlatformLimits::mechanical(), 600));
}

TEST(PlatformLimits, AnglesAreToldInDegreesAndBothSidesOfAStrokeCount) {
  PlatformLimits limits = PlatformLimits::mechanical();
  limits.min[4] = -0.5 * std::numbers::pi / 180;
  const auto found = excess(motion("thesis-wave"), limits, 60);
  ASSERT_TRUE(found);
  EXPECT_LT(found->reached, 0);
  EXPECT_THAT(describe(*found, limits), HasSubstr("pitch: -5° after"));
}

TEST(DirectionalSea, RunsWithItsWaves) {
  Scenario s = scenario_named("sea").value();
  s.fade_in_s = 0;
  const auto rms = [&s](double mean, double spreading) {
    s.direction = WaveDirection{mean, spreading};
    const ShipMotion ship(s, 3);
    Vector6d variance = Vector6d::Zero();
    for (int i = 0; i < 20000; ++i) variance += ship.at(0.4 * i).eta.cwiseAbs2() / 20000;
    return Vector6d(variance.cwiseSqrt() / (0.5 / 4));
  };
  const double degree = std::numbers::pi / 180;
  Vector6d head, beam;
  head << 0.6, 0, 1, 0, 15 * degree, 0;
  beam << 0, 0.6, 1, 18 * degree, 0, 0;
  EXPECT_LT((rms(0, 0) - head).norm(), 0.05);
  EXPECT_LT((rms(std::numbers::pi / 2, 0) - beam).norm(), 0.05);
  const Vector6d spread = rms(0, 0.5);
  EXPECT_NEAR(spread[2], 1, 0.05) << "heave does not care where the waves come from";
  EXPECT_GT(spread[3], 0.1 * 18 * degree);
  EXPECT_LT(spread[0], 0.6);
}

TEST(DirectionalSea, TheBowRisesOnTheFrontOfAWaveThatRunsToTheBow) {
  Scenario s = scenario_named("sea").value();
  s.fade_in_s = 0;
  s.direction = WaveDirection{0, 0};
  const ShipMotion ship(s, 3);
  // The slope under the ship rises to the bow once the crest, which came from behind, is ahead: heave then
  // sinks. So pitch goes with the speed downwards.
  double together = 0, pitch = 0, sink = 0;
  for (int i = 0; i < 5000; ++i) {
    const ShipCoordinates c = ship.at(0.4 * i);
    together += c.eta[4] * c.eta_dot[2];
    pitch += c.eta[4] * c.eta[4];
    sink += c.eta_dot[2] * c.eta_dot[2];
  }
  EXPECT_GT(together / std::sqrt(pitch * sink), 0.9);
}

}  // namespace
}  // namespace motionlab::plant
