#include "simulators/plant/sea.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace motionlab::plant {
namespace {

Scenario at_once(std::string_view name) {
  Scenario s = scenario_named(name).value();
  s.fade_in_s = 0;
  return s;
}

TEST(Sea, KnowsItsScenariosByNameAndNoOthers) {
  EXPECT_EQ(scenario_named("thesis-wave")->sea, Sea::thesis_wave);
  EXPECT_EQ(scenario_named("sea")->sea, Sea::jonswap);
  EXPECT_EQ(scenario_named("pierson-moskowitz")->sea, Sea::pierson_moskowitz);
  EXPECT_EQ(scenario_named("calm")->sea, Sea::calm);
  EXPECT_FALSE(scenario_named("storm"));
}

// Values of an independent computation of thesis Tab 4.4 at t = 1.3 s and 19 s.
TEST(Sea, ThesisWaveIsTheTablesWave) {
  const ShipMotion ship(at_once("thesis-wave"), 1);
  Vector6d eta, eta_dot, eta_ddot;
  eta << 0.07289686274214116, 0.19990131207314632, 0.13690942118573776, 0.029560460048191455,
      0.06361451346123727, -0.04829252293504343;
  eta_dot << 0.04301136318043444, -0.003947192398541069, -0.09160489938418165, -0.07738434148475802,
      0.03753449516348204, -0.09134003492303563;
  eta_ddot << -0.02877852789381773, -0.07891787477682648, -0.05404967303541416, -0.026257504193087085,
      -0.02511400328120742, 0.07626049550390614;
  const ShipCoordinates s = ship.at(1.3);
  EXPECT_LT((s.eta - eta).norm(), 1e-14);
  EXPECT_LT((s.eta_dot - eta_dot).norm(), 1e-14);
  EXPECT_LT((s.eta_ddot - eta_ddot).norm(), 1e-14);
  eta << -0.05877852522924735, 0.031286893008046254, 0.16180339887498943, 0.051293939735846214,
      -0.05129393973584605, 0.06485162011869586;
  EXPECT_LT((ship.at(19.0).eta - eta).norm(), 1e-13);
}

// Values of an independent computation, Hs 0.57 m, Tp 7 s.
TEST(Sea, SpectraHaveTheirPublishedShape) {
  EXPECT_NEAR(pierson_moskowitz(0.6, 0.57, 7), 0.0016185431641066493, 1e-15);
  EXPECT_NEAR(pierson_moskowitz(1.8, 0.57, 7), 0.0032284647243282284, 1e-15);
  EXPECT_NEAR(jonswap(0.6, 0.57, 7, 3.3), 0.0010639571249314598, 1e-15);
  EXPECT_NEAR(jonswap(0.9, 0.57, 7, 3.3), 0.07025812034167504, 1e-14);
  EXPECT_NEAR(jonswap(1.8, 0.57, 7, 3.3), 0.0021222127278639875, 1e-15);
  EXPECT_EQ(pierson_moskowitz(0.0, 0.57, 7), 0.0);
}

class RandomSea : public testing::TestWithParam<const char*> {};

TEST_P(RandomSea, HasTheVarianceOfItsHeightInEveryCoordinate) {
  const ShipMotion ship(at_once(GetParam()), 3);
  Vector6d variance = Vector6d::Zero();
  const int n = 20000;  // 0.4 s apart: many beats of the closest harmonics
  for (int i = 0; i < n; ++i) variance += ship.at(0.4 * i).eta.cwiseAbs2() / n;
  const double sigma = scenario_named(GetParam())->significant_height_m / 4, degree = std::numbers::pi / 180;
  EXPECT_NEAR(std::sqrt(variance[2]), sigma, 0.05 * sigma);
  EXPECT_NEAR(std::sqrt(variance[0]), 0.6 * sigma, 0.05 * 0.6 * sigma);
  EXPECT_NEAR(std::sqrt(variance[1]), 0.6 * sigma, 0.05 * 0.6 * sigma);
  EXPECT_NEAR(std::sqrt(variance[3]), 18 * degree * sigma, 0.05 * 18 * degree * sigma);
  EXPECT_NEAR(std::sqrt(variance[4]), 15 * degree * sigma, 0.05 * 15 * degree * sigma);
  EXPECT_NEAR(std::sqrt(variance[5]), 8 * degree * sigma, 0.05 * 8 * degree * sigma);
}

TEST_P(RandomSea, IsTheSeedsSeaAndNoOther) {
  const Scenario scenario = scenario_named(GetParam()).value();
  const ShipMotion a(scenario, 5), b(scenario, 5), c(scenario, 6);
  EXPECT_EQ(a.at(33.3).eta, b.at(33.3).eta);
  EXPECT_GT((a.at(33.3).eta - c.at(33.3).eta).norm(), 1e-3);
}

INSTANTIATE_TEST_SUITE_P(, RandomSea, testing::Values("sea", "pierson-moskowitz"), [](const auto& tested) {
  return tested.index == 0 ? "Jonswap" : "PiersonMoskowitz";
});

TEST(Sea, DerivativesAreTheDerivativesAlsoWhileItFadesIn) {
  for (const char* name : {"thesis-wave", "sea"}) {
    const ShipMotion ship(scenario_named(name).value(), 2);
    const double h = 1e-4;
    for (const double t : {0.3, 2.5, 4.99, 5.01, 47.0}) {
      const ShipCoordinates s = ship.at(t), before = ship.at(t - h), after = ship.at(t + h);
      EXPECT_LT(((after.eta - before.eta) / (2 * h) - s.eta_dot).norm(), 1e-7) << name << " at " << t;
      EXPECT_LT(((after.eta_dot - before.eta_dot) / (2 * h) - s.eta_ddot).norm(), 1e-6)
          << name << " at " << t;
    }
  }
}

TEST(Sea, BeginsAtRestAndWithoutAJumpInAcceleration) {
  for (const char* name : {"thesis-wave", "sea", "calm"}) {
    const ShipMotion ship(scenario_named(name).value(), 2);
    EXPECT_EQ(ship.at(0).eta.norm(), 0);
    EXPECT_EQ(ship.at(-1).eta.norm(), 0);
    EXPECT_EQ(ship.at(0).eta_dot.norm(), 0);
    EXPECT_LT(ship.at(1e-6).eta_ddot.norm(), 1e-5);
    EXPECT_LT((ship.at(5.0 - 1e-7).eta_ddot - ship.at(5.0 + 1e-7).eta_ddot).norm(), 1e-6);
  }
}

TEST(Sea, CalmIsCalm) {
  EXPECT_EQ(ShipMotion(scenario_named("calm").value(), 1).at(12.3).eta.norm(), 0);
}

TEST(Sea, CacheAgreesWithTheMotionItCaches) {
  for (const char* name : {"thesis-wave", "sea"}) {
    const Scenario scenario = scenario_named(name).value();
    const ShipMotion exact(scenario, 4);
    CachedShipMotion cached(scenario, 4);
    for (int i = 0; i < 3000; ++i) {
      const double t = 0.0037 * i;
      const ShipCoordinates a = exact.at(t), b = cached.at(t);
      ASSERT_LT((a.eta - b.eta).norm(), 1e-12) << t;
      ASSERT_LT((a.eta_dot - b.eta_dot).norm(), 1e-9) << t;
      ASSERT_LT((a.eta_ddot - b.eta_ddot).norm(), 1e-6) << t;
    }
    EXPECT_LT((exact.at(3.3333).eta - cached.at(3.3333).eta).norm(), 1e-12) << "also backwards";
  }
}

}  // namespace
}  // namespace motionlab::plant
