// Whatever is wanted and measured, what leaves keeps speed, acceleration and stopping distance.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "drivers/comau/comau_driver_velocity.hpp"
#include "drivers/core/random.hpp"

namespace motionlab::comau {
namespace {

constexpr double kPeriod_s = 0.005;

VelocityShaper::Config random_limits(Random& random) {
  VelocityShaper::Config c;
  c.period_s = kPeriod_s;
  for (std::size_t i = 0; i < kJointCount; ++i) {
    c.q_min_rad[i] = random.uniform(-2.0, -0.1);
    c.q_max_rad[i] = random.uniform(0.1, 2.0);
    c.qd_max_radps[i] = random.uniform(0.02, 2.0);
    c.qdd_max_radps2[i] = random.uniform(0.2, 8.0);
    c.stop_deceleration_radps2[i] = random.uniform(0.2, 4.0);
  }
  return c;
}

/// Somebody who wants what is worst: full speed to an edge, reversals, nonsense, numbers that are none.
class Adversary {
 public:
  explicit Adversary(std::uint64_t seed) : random_(seed) {}
  Joints next() {
    if (random_.chance(0.01)) kind_ = random_.below(6);
    Joints qd{};
    for (double& v : qd) {
      switch (kind_) {
        case 0:
          v = 1e9;
          break;
        case 1:
          v = -1e9;
          break;
        case 2:
          v = random_.uniform(-3.0, 3.0);
          break;
        case 3:
          v = random_.chance(0.5) ? 1e308 : -1e308;
          break;
        case 4:
          v = 0.3 * random_.normal();
          break;
        default:
          v = std::numeric_limits<double>::infinity();
          break;
      }
      if (random_.chance(0.002)) v = std::numeric_limits<double>::quiet_NaN();
    }
    return qd;
  }
  bool brakes() {
    braking_ = random_.chance(braking_ ? 0.99 : 0.005);
    return braking_;
  }

 private:
  Random random_;
  std::uint32_t kind_ = 0;
  bool braking_ = false;
};

double at(const Command& command, std::size_t i) {
  return static_cast<double>(command.qd_radps[i]);
}

void expect_within_limits(const VelocityShaper::Config& c, const Command& before, const Command& now) {
  if (now.mode == 0) {
    ASSERT_EQ(now, Command{});
    ASSERT_EQ(before.qd_radps, Command{}.qd_radps) << "mode 0 only from rest";
    return;
  }
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double v0 = at(before, i);
    const double v1 = at(now, i);
    ASSERT_TRUE(std::isfinite(v1));
    ASSERT_LE(std::abs(v1), c.qd_max_radps[i]);
    const double away = c.qdd_max_radps2[i] * kPeriod_s;
    const double towards = std::max(away, c.stop_deceleration_radps2[i] * kPeriod_s);
    ASSERT_LE(std::abs(v1 - v0), (std::abs(v1) > std::abs(v0) ? away : towards) + 1e-7);
    ASSERT_LE(std::abs(v1 - v0), towards + 1e-12);
  }
}

/// Braking from here ends inside the box. The shaper is a copy: nothing is changed.
void expect_stoppable(const VelocityShaper::Config& c, VelocityShaper shaper, Joints q) {
  while (!shaper.holding()) {
    const Command command = shaper.brake();
    for (std::size_t i = 0; i < kJointCount; ++i) q[i] += at(command, i) * kPeriod_s;
  }
  for (std::size_t i = 0; i < kJointCount; ++i) {
    ASSERT_LE(q[i], c.q_max_rad[i] + 1e-6) << i;
    ASSERT_GE(q[i], c.q_min_rad[i] - 1e-6) << i;
  }
}

TEST(VelocityShaper, NeverLeavesItsLimitsAndCanAlwaysStopWhateverIsWanted) {
  Random random{4711};
  for (int world = 0; world < 60; ++world) {
    const VelocityShaper::Config c = random_limits(random);
    VelocityShaper dut{c};
    Adversary adversary{random.bits()};
    Joints q{};
    Command before;
    double farthest = 0.0;
    for (int k = 0; k < 3000; ++k) {
      const Command now = adversary.brakes() ? dut.brake() : dut.follow(adversary.next(), q);
      ASSERT_NO_FATAL_FAILURE(expect_within_limits(c, before, now)) << "world " << world << ", step " << k;
      for (std::size_t i = 0; i < kJointCount; ++i) {
        q[i] += at(now, i) * kPeriod_s;
        farthest = std::max(farthest, std::abs(q[i]));
      }
      if (k % 7 == 0) {
        ASSERT_NO_FATAL_FAILURE(expect_stoppable(c, dut, q)) << "world " << world << ", step " << k;
      }
      before = now;
    }
    EXPECT_GT(farthest, 0.05) << "it did go somewhere";
  }
}

TEST(VelocityShaper, KeepsTheSetPointInTheBoxThroughAServoThatLagsAndAMeasurementThatIsOld) {
  Random random{42};
  for (int world = 0; world < 40; ++world) {
    VelocityShaper::Config c = random_limits(random);
    c.qd_max_radps.fill(0.6);
    VelocityShaper dut{c};
    Adversary adversary{random.bits()};
    const double omega = random.uniform(22.0, 60.0);
    constexpr double kZeta = 0.7;
    Joints set_point{};
    Joints q{};
    Joints qd{};
    Joints old{};
    for (int k = 0; k < 4000; ++k) {
      const Command now = adversary.brakes() ? dut.brake() : dut.follow(adversary.next(), old);
      old = q;  // one period late
      for (int cycle = 0; cycle < 12; ++cycle) {
        constexpr double kCycle_s = kPeriod_s / 12;
        for (std::size_t i = 0; i < kJointCount; ++i) {
          set_point[i] += at(now, i) * kCycle_s;
          qd[i] += (omega * omega * (set_point[i] - q[i]) - 2 * kZeta * omega * qd[i]) * kCycle_s;
          q[i] += qd[i] * kCycle_s;
        }
      }
      for (std::size_t i = 0; i < kJointCount; ++i) {
        ASSERT_LE(set_point[i], c.q_max_rad[i] + 1e-3) << "world " << world << ", step " << k;
        ASSERT_GE(set_point[i], c.q_min_rad[i] - 1e-3) << "world " << world << ", step " << k;
      }
    }
  }
}

TEST(VelocityShaper, BrakesWhenAPositionOrAWishIsNoNumber) {
  Random random{3};
  VelocityShaper::Config c = random_limits(random);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                           -std::numeric_limits<double>::infinity()}) {
    for (const bool wish : {false, true}) {
      VelocityShaper dut{c};
      Joints q{};
      Command now;
      for (int k = 0; k < 30; ++k) now = dut.follow({1, 1, 1, 1, 1, 1}, q);
      ASSERT_GT(now.qd_radps[3], 0.0F);
      const float before = now.qd_radps[3];
      Joints spoilt{};
      spoilt[0] = bad;
      now = wish ? dut.follow(spoilt, q) : dut.follow({1, 1, 1, 1, 1, 1}, spoilt);
      EXPECT_LT(now.qd_radps[3], before);
      EXPECT_EQ(now.mode, 1);
    }
  }
}

TEST(VelocityShaper, OpensOnlyTheWayBackOutsideItsBox) {
  VelocityShaper::Config c;
  c.q_min_rad.fill(-1.0);
  c.q_max_rad.fill(1.0);
  c.qd_max_radps.fill(0.5);
  c.qdd_max_radps2.fill(5.0);
  c.stop_deceleration_radps2.fill(1.0);
  VelocityShaper dut{c};
  Joints q{1.2, -1.2, 1.2, -1.2, 0, 0};
  Command now;
  for (int k = 0; k < 60; ++k) now = dut.follow({0.3, -0.3, -0.3, 0.3, 0.3, -0.3}, q);
  EXPECT_EQ(now.qd_radps[0], 0.0F);
  EXPECT_EQ(now.qd_radps[1], 0.0F);
  EXPECT_EQ(now.qd_radps[2], -0.3F);
  EXPECT_EQ(now.qd_radps[3], 0.3F);
}

TEST(VelocityShaper, SendsExactlyWhatIsWantedWhenNothingForbidsIt) {
  VelocityShaper::Config c;
  c.q_min_rad.fill(-1.0);
  c.q_max_rad.fill(1.0);
  c.qd_max_radps.fill(0.5);
  c.qdd_max_radps2.fill(5.0);
  c.stop_deceleration_radps2.fill(1.0);
  VelocityShaper dut{c};
  Command now;
  for (int k = 0; k < 60; ++k) now = dut.follow({0.1, -0.2, 0.3, 0.01, -0.02, 0.5}, {});
  EXPECT_EQ(now.qd_radps, (std::array{0.1F, -0.2F, 0.3F, 0.01F, -0.02F, 0.5F}));
}

}  // namespace
}  // namespace motionlab::comau
