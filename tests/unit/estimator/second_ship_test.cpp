#include "gateway/estimator/second_ship.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/allocation_count.hpp"
#include "tests/unit/estimator/laboratory.hpp"

namespace motionlab::estimator {
namespace {

using Eigen::Vector3d;

/// The laboratory's first ship seen as if it were the second: by its unit alone.
struct Bench {
  test::Laboratory lab;
  Belief belief = test::belief_of(lab);
  SecondShip dut{{belief.calibration.X_WN, belief.calibration.X_BM, belief.calibration.p_MO,
                  belief.calibration.mru_order},
                 belief.ship,
                 belief.mru,
                 belief.load.gravity_mps2};
  std::optional<topic::Mru> heard;

  template <class Look>
  void run(double seconds, Look&& look) {
    for (int i = 0; i < static_cast<int>(1000 * seconds); ++i) {
      lab.step();
      heard = lab.inputs().mru;
      dut.step(lab.inputs().t, heard);
      look();
    }
  }
};

TEST(SecondShip, KnowsNothingBeforeItsUnitWasHeardForAWhile) {
  Bench b;
  EXPECT_FALSE(b.dut.valid());
  b.run(10, [] {});
  EXPECT_FALSE(b.dut.valid());
  b.run(11, [] {});
  EXPECT_TRUE(b.dut.valid());
}

TEST(SecondShip, KnowsRollAndPitchWellAndItsPlaceAtWaveFrequencies) {
  Bench b;
  b.run(60, [] {});
  double tilt = 0, place = 0;
  int count = 0;
  b.run(60, [&] {
    const auto truth = b.lab.ship(b.lab.t());
    const math::BodyMotion m = b.dut.motion();
    tilt += (m.X_WB.R.col(2) - truth.R.col(2)).squaredNorm();
    place += (m.X_WB.p - truth.p).squaredNorm();
    ++count;
  });
  EXPECT_LT(std::sqrt(tilt / count), 1e-3) << "rad";
  EXPECT_LT(std::sqrt(place / count), 0.09) << "m, of 0.21 m rms, at 0.1 Hz slower than in a sea";
  // And it says so.
  EXPECT_GT(b.dut.p_sd_m().minCoeff(), 0.005);
  EXPECT_LT(b.dut.p_sd_m().maxCoeff(), 0.25);
}

TEST(SecondShip, ForgetsEverythingWhenItsUnitFallsSilent) {
  Bench b;
  b.run(25, [] {});
  ASSERT_TRUE(b.dut.valid());
  LabTime t = b.lab.inputs().t;
  for (int i = 0; i < 600; ++i) b.dut.step(t += 1ms, b.heard);
  EXPECT_FALSE(b.dut.valid());
}

TEST(SecondShip, IsNotPoisonedByWhatIsNotFiniteOrFromTheFuture) {
  Bench b;
  b.run(25, [] {});
  topic::Mru bad = *b.heard;
  bad.sequence_number += 1000;
  bad.euler_heading_mru_rad[0] = std::numeric_limits<double>::quiet_NaN();
  b.dut.step(b.lab.inputs().t, bad);
  bad = *b.heard;
  bad.sequence_number += 2000;
  bad.t_measured_ns += 1'000'000'000;
  b.dut.step(b.lab.inputs().t, bad);
  EXPECT_TRUE(b.dut.valid());
  EXPECT_TRUE(b.dut.motion().X_WB.p.allFinite());
  b.run(1, [] {});
  EXPECT_TRUE(b.dut.valid());
}

TEST(SecondShip, NeverAllocates) {
  Bench b;
  std::size_t allocated = 0;
  for (int i = 0; i < 2000; ++i) {
    b.lab.step();
    const auto in = b.lab.inputs();
    const std::size_t before = test::allocations;
    b.dut.step(in.t, in.mru);
    (void)b.dut.motion();
    allocated += test::allocations - before;
  }
  EXPECT_EQ(allocated, 0u);
}

}  // namespace
}  // namespace motionlab::estimator
