#include "gateway/controller/servo_identifier.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "tests/support/allocation_count.hpp"

namespace motionlab::controller {
namespace {

using Vector3d = Eigen::Vector3d;

/// Three servos with speeds of their own that follow an integrated velocity; the identifier watches.
struct Bench {
  explicit Bench(const Vector3d& omega, const ServoIdentifierConfig& config = {})
      : dut({}, config), truth(omega) {
    dut.restart(q, qd);
  }

  /// Runs for so many seconds. @param u  velocities of the set points at a time
  void run(double s, const std::function<Vector3d(double)>& u) {
    constexpr double dt = 0.0005;
    const int steps = static_cast<int>(s / dt + 0.5);
    for (int i = 0; i < steps; ++i) {
      const Vector3d moved = dt * u(t);
      const Vector3d qdd = truth.cwiseProduct(truth.cwiseProduct(set_point + 0.5 * moved - q) - 2 * 0.7 * qd);
      q += dt * qd + 0.5 * dt * dt * qdd;
      qd += dt * qdd;
      set_point += moved;
      t += dt;
      dut.advance(moved, dt);
      if (i % 10 == 9) dut.measured(q + offset, 10 * dt);
    }
  }

  ServoIdentifier dut;
  Vector3d truth;
  Vector3d q = Vector3d::Zero(), qd = Vector3d::Zero(), set_point = Vector3d::Zero();
  Vector3d offset = Vector3d::Zero();  ///< of the encoders
  double t = 0;
};

/// What the joints do in a sea.
Vector3d sea(double t) {
  return {0.2 * std::sin(0.9 * t), 0.15 * std::sin(0.7 * t + 1), 0.2 * std::sin(1.1 * t + 2)};
}

TEST(ServoIdentifier, FindsEachJointsOwnSpeedWithinHalfAPercent) {
  Bench b(25.1327 * Vector3d(0.8, 1.0, 1.2));
  b.run(90, sea);
  for (int j = 0; j < 3; ++j) EXPECT_NEAR(b.dut.omega_radps()[j] / b.truth[j], 1, 0.005) << "joint " << j;
}

TEST(ServoIdentifier, LearnsNothingFromRest) {
  Bench b(25.1327 * Vector3d(0.8, 0.8, 0.8));
  b.run(60, [](double) { return Vector3d::Zero(); });
  EXPECT_EQ(b.dut.omega_radps(), Vector3d::Constant(25.1327));
}

TEST(ServoIdentifier, IsNotMisledByAnEncodersOffsetOrALostDatagram) {
  Bench b(25.1327 * Vector3d(0.9, 0.9, 0.9));
  b.run(60, sea);
  const Vector3d before = b.dut.omega_radps();
  b.offset = Vector3d(0.001, -0.001, 0.001);  // a set point that went a milliradian further than told
  b.run(60, sea);
  EXPECT_LT((b.dut.omega_radps() - before).cwiseAbs().maxCoeff(), 0.02 * 25.1327);
}

TEST(ServoIdentifier, FollowsAServoThatGrowsSlower) {
  Bench b(Vector3d::Constant(25.1327));
  b.run(60, sea);
  b.truth *= 0.85;
  b.run(120, sea);
  EXPECT_LT((b.dut.omega_radps() - b.truth).cwiseAbs().maxCoeff(), 0.02 * 25.1327);
}

TEST(ServoIdentifier, NeverLeavesItsBoundsWhateverTheEncodersSay) {
  ServoIdentifierConfig config;
  Bench b(25.1327 * Vector3d(0.2, 5.0, 1.0), config);
  b.run(200, sea);
  const Vector3d& w = b.dut.omega_radps();
  EXPECT_NEAR(w[0], 25.1327 / config.most_factor, 1e-9);
  EXPECT_LE(w[1], 25.1327 * config.most_factor);
  EXPECT_TRUE(w.allFinite());
}

TEST(ServoIdentifier, BelievesWhenItIsTold) {
  Bench b(25.1327 * Vector3d(0.8, 0.8, 0.8), {.memory_s = 0});
  b.run(60, sea);
  EXPECT_EQ(b.dut.omega_radps(), Vector3d::Constant(25.1327));
}

TEST(ServoIdentifier, NeverAllocates) {
  Bench b(Vector3d::Constant(20));
  const std::size_t before = test::allocations;
  b.dut.restart(b.q, b.qd);
  for (int i = 0; i < 100; ++i) {
    b.dut.advance(Vector3d::Constant(1e-4), 0.0005);
    b.dut.measured(Vector3d::Constant(1e-4 * i), 0.0005);
  }
  EXPECT_EQ(test::allocations, before);
}

}  // namespace
}  // namespace motionlab::controller
