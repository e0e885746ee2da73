#include "simulators/lab/fault_matrix/servo_speed.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/core/random.hpp"
#include "simulators/plant/second_order.hpp"

namespace motionlab::matrix {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kStep_s = 1e-4;

/// The plant's own servo, moved by a speed of the set point that is asked for in every step and followed
/// within the acceleration.
class Joint {
 public:
  Joint(ServoLoop loop, double acceleration_max)
      : servo_(loop.omega_radps, loop.zeta, loop.omega_radps * loop.omega_radps, kStep_s),
        speed_step_(acceleration_max * kStep_s) {}

  void step(double speed_wanted) {
    const double before = set_point_;
    speed_ += std::clamp(speed_wanted - speed_, -speed_step_, speed_step_);
    set_point_ += kStep_s * speed_;
    state_ = servo_.step(state_, before, set_point_);
    fastest_ = std::max(fastest_, std::abs(state_.v));
  }
  [[nodiscard]] double fastest() const { return fastest_; }

 private:
  plant::SecondOrder servo_;
  plant::SecondOrder::State state_;
  double speed_step_;
  double speed_ = 0, set_point_ = 0, fastest_ = 0;
};

struct Case {
  ServoLoop loop;
  double speed_max, acceleration_max;
};
constexpr Case kCases[] = {
    {{22.6, 0.7}, 0.1, 5}, {{22.6, 0.7}, 0.1, kInfinity}, {{25.1, 0.7}, 0.052, 1}, {{22.6, 0.7}, 0.52, 5},
    {{6.3, 0.3}, 1, 8},    {{40, 0.9}, 0.2, 0.5},
};

/// Reverses in the rhythm of the ringing, and lets the last reversal ring undisturbed.
double rhythm(const Case& c) {
  Joint joint(c.loop, c.acceleration_max);
  const double half_s = std::numbers::pi / (c.loop.omega_radps * std::sqrt(1 - c.loop.zeta * c.loop.zeta));
  constexpr int kReversals = 24;
  for (int i = 0; i * kStep_s < (kReversals + 3) * half_s; ++i) {
    const bool up = std::min(static_cast<int>(i * kStep_s / half_s), kReversals) % 2 == 0;
    joint.step(up ? c.speed_max : -c.speed_max);
  }
  return joint.fastest() / c.speed_max;
}

TEST(ServoSpeed, IsReachedBySetPointsThatReverseInTheRhythmOfTheRinging) {
  for (const Case& c : kCases) {
    const bool has_time = 2 * c.speed_max / c.acceleration_max < 0.9 * std::numbers::pi / c.loop.omega_radps;
    const double bound = servo_speed_share(c.loop, c.speed_max, c.acceleration_max);
    EXPECT_LE(rhythm(c), bound + 1e-6);
    if (has_time) {
      EXPECT_NEAR(rhythm(c), bound, 2e-4) << c.acceleration_max;
    }
  }
}

TEST(ServoSpeed, IsPassedByNoSetPoint) {
  for (const Case& c : kCases) {
    const double bound = servo_speed_share(c.loop, c.speed_max, c.acceleration_max);
    Random random(7, "set points");
    for (int run = 0; run < 50; ++run) {
      Joint joint(c.loop, c.acceleration_max);
      double wanted = 0;
      for (int i = 0; i < 20'000; ++i) {
        if (random.uniform() < 1e-3) wanted = random.uniform() < 0.5 ? -c.speed_max : c.speed_max;
        joint.step(wanted);
      }
      EXPECT_LE(joint.fastest() / c.speed_max, bound + 1e-6);
    }
  }
}

TEST(ServoSpeed, WithoutALimitOfAccelerationIsTheAreaUnderTheImpulseResponse) {
  const double M = std::exp(-std::numbers::pi * 0.7 / std::sqrt(1 - 0.49));
  EXPECT_NEAR(servo_speed_share({22.6, 0.7}, 0.1, kInfinity), (1 + M) / (1 - M), 1e-12);
  EXPECT_NEAR(servo_speed_share({22.6, 0.7}, 0.1, 1e6), (1 + M) / (1 - M), 1e-6);
}

TEST(ServoSpeed, GrowsWithTheAcceleration) {
  double before = 1;
  for (const double a : {0.1, 1.0, 2.0, 5.0, 20.0, kInfinity}) {
    const double now = servo_speed_share({22.6, 0.7}, 0.1, a);
    EXPECT_GE(now, before);
    before = now;
  }
}

}  // namespace
}  // namespace motionlab::matrix
