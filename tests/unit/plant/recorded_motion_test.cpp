#include "simulators/plant/recorded_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "simulators/plant/sea.hpp"

namespace motionlab::plant {
namespace {

/// Heave (and yaw, twice as much) of a wave, sampled at uneven times.
RecordedMotion wave(double until_s, double step_s) {
  std::vector<RecordedMotion::Sample> samples;
  for (int i = 0; step_s * i <= until_s; ++i) {
    const double t = step_s * (i + 0.2 * (i % 2));
    Vector6d eta = Vector6d::Zero();
    eta[2] = std::sin(t);
    eta[5] = 2 * std::sin(t);
    samples.push_back({100 + t, eta});
  }
  return RecordedMotion(std::move(samples));
}

TEST(RecordedMotion, GoesThroughItsSamplesAndCountsFromTheFirst) {
  const RecordedMotion motion = wave(20, 0.2);
  for (int i = 0; i <= 100; i += 7) {
    const double t = 0.2 * (i + 0.2 * (i % 2));
    EXPECT_NEAR(motion.at(t).eta[2], std::sin(t), 1e-12);
    EXPECT_NEAR(motion.at(t).eta[5], 2 * std::sin(t), 1e-12);
  }
  EXPECT_NEAR(motion.duration_s(), 20, 1e-12);
}

TEST(RecordedMotion, IsNearTheMotionThatWasSampled) {
  const RecordedMotion motion = wave(20, 0.1);
  for (double t = 1; t < 19; t += 0.037) {
    EXPECT_NEAR(motion.at(t).eta[2], std::sin(t), 2e-6);
    EXPECT_NEAR(motion.at(t).eta_dot[2], std::cos(t), 1e-4);
    EXPECT_NEAR(motion.at(t).eta_ddot[2], -std::sin(t), 3e-3);
  }
}

TEST(RecordedMotion, HasTwoContinuousDerivativesAtEverySample) {
  const RecordedMotion motion = wave(20, 0.5);
  for (int i = 1; i < 40; ++i) {
    const double t = 0.5 * (i + 0.2 * (i % 2));
    const ShipCoordinates before = motion.at(t - 1e-9), after = motion.at(t + 1e-9);
    EXPECT_LT((after.eta - before.eta).norm(), 1e-8);
    EXPECT_LT((after.eta_dot - before.eta_dot).norm(), 1e-7);
    EXPECT_LT((after.eta_ddot - before.eta_ddot).norm(), 1e-7);
  }
  EXPECT_LT(motion.at(0).eta_ddot.norm(), 1e-12) << "natural ends";
}

// x = 0, 1, 0 at t = 0, 1, 2: the natural spline's middle second derivative is −3.
TEST(RecordedMotion, IsTheNaturalSplineOfThreeSamples) {
  Vector6d zero = Vector6d::Zero(), one = Vector6d::Ones();
  const RecordedMotion motion({{0, zero}, {1, one}, {2, zero}});
  EXPECT_NEAR(motion.at(1).eta_ddot[0], -3, 1e-12);
  EXPECT_NEAR(motion.at(0.5).eta[0], 0.6875, 1e-12);
  EXPECT_NEAR(motion.at(1).eta_dot[3], 0, 1e-12);
}

TEST(RecordedMotion, StandsStillBeforeAndAfter) {
  const RecordedMotion motion = wave(10, 0.5);
  EXPECT_EQ(motion.at(-1).eta, motion.at(0).eta);
  EXPECT_EQ(motion.at(99).eta_dot.norm(), 0);
}

TEST(RecordedMotion, AsAShipItFadesInAndOutAndThenStandsAtNeutral) {
  Scenario scenario{.sea = Sea::recorded};
  scenario.recording = std::make_shared<RecordedMotion>(wave(30, 0.1));
  const ShipMotion ship(scenario, 1);
  EXPECT_EQ(ship.at(0).eta.norm(), 0);
  EXPECT_NEAR(ship.at(15).eta[2], std::sin(15), 1e-5);
  EXPECT_LT(ship.at(29.999).eta.norm(), 1e-9);
  EXPECT_LT(ship.at(29.999).eta_ddot.norm(), 1e-2);
  EXPECT_EQ(ship.at(31).eta.norm(), 0);
  const double h = 1e-4;
  for (const double t : {2.02, 15.02, 27.02}) {
    const ShipCoordinates before = ship.at(t - h), s = ship.at(t), after = ship.at(t + h);
    EXPECT_LT(((after.eta - before.eta) / (2 * h) - s.eta_dot).norm(), 1e-6) << t;
    EXPECT_LT(((after.eta_dot - before.eta_dot) / (2 * h) - s.eta_ddot).norm(), 1e-6) << t;
  }
}

}  // namespace
}  // namespace motionlab::plant
