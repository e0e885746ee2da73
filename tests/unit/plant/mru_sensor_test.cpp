#include "simulators/plant/mru_sensor.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "simulators/plant/calibration.hpp"

namespace motionlab::plant {
namespace {

using Eigen::Vector3d;

constexpr double kPi = std::numbers::pi;

/// N level and pointing along world x, z down: the unit's D frame is N itself.
math::RigidTransform level() {
  math::RigidTransform X;
  X.R = Vector3d(1, -1, -1).asDiagonal();
  return X;
}

MruConfig perfect() {
  MruConfig c = MruConfig{}.without_errors();
  c.misalignment_rad.setZero();
  return c;
}

MruSensor unit(const MruConfig& config) {
  return {config, level(), {Eigen::Matrix3d::Identity(), -config.lever_to_origin_m}, 1, "mru1"};
}

ShipCoordinates heaving(double amplitude, double w, double t) {
  ShipCoordinates s;
  s.eta[2] = amplitude * std::sin(w * t);
  s.eta_dot[2] = amplitude * w * std::cos(w * t);
  s.eta_ddot[2] = -amplitude * w * w * std::sin(w * t);
  return s;
}

TEST(MruSensor, AtRestSaysNothingButItsAttitude) {
  MruSensor mru = unit(perfect());
  ShipCoordinates ship;
  ship.eta << 0, 0, 0, 0.05, -0.03, 0.2;
  const MruReading r = mru.sample(platform_state(level(), ship));
  EXPECT_LT((r.euler_rad - Vector3d(0.05, -0.03, 0.2)).norm(), 1e-12);
  EXPECT_LT(r.a_unit_M_mps2.norm(), 1e-12) << "gravity is taken out";
  EXPECT_LT(r.p_origin_H_m.norm(), 1e-12);
  EXPECT_LT(r.omega_M_radps.norm(), 1e-12);
}

TEST(MruSensor, OnlyTheUnitsOwnValuesCarryTheLeverArm) {
  // Pure roll about the platform's origin: the origin does not move, the unit does.
  MruSensor mru = unit(perfect());
  const double A = 0.08, w = 2 * kPi * 0.15;
  double worst_origin = 0, most_unit = 0;
  for (int i = 0; i < 4000; ++i) {
    const double t = 0.005 * i;
    ShipCoordinates s;
    s.eta[3] = A * (1 - std::cos(w * t));
    s.eta_dot[3] = A * w * std::sin(w * t);
    s.eta_ddot[3] = A * w * w * std::cos(w * t);
    const PlatformState platform = platform_state(level(), s);
    const MruReading r = mru.sample(platform);
    worst_origin =
        std::max({worst_origin, r.a_origin_H_mps2.norm(), r.p_origin_H_m.norm(), r.v_origin_H_mps.norm()});
    most_unit = std::max(most_unit, r.a_unit_M_mps2.norm());
    // Rigid-body kinematics about the fixed origin, in body axes.
    const Vector3d arm(-1.289, 0.576, -0.966), omega(s.eta_dot[3], 0, 0), alpha(s.eta_ddot[3], 0, 0);
    ASSERT_LT((r.a_unit_M_mps2 - (alpha.cross(arm) + omega.cross(omega.cross(arm)))).norm(), 1e-9);
  }
  EXPECT_LT(worst_origin, 1e-9);
  EXPECT_GT(most_unit, 0.05);
}

TEST(MruSensor, HeaveAndSurgeAnswerAsTheirHighPassFilters) {
  const double A = 0.2, w = 2 * kPi * 0.1;
  MruSensor mru = unit(perfect());
  // Steady state after many filter periods: H(jw) = −w² / (wn² − w² + 2 j zeta wn w).
  const double wn = 2 * kPi / 10.0, zeta = 0.7;
  const double re = wn * wn - w * w, im = 2 * zeta * wn * w;
  const double gain = w * w / std::hypot(re, im), phase = kPi - std::atan2(im, re);
  double worst = 0;
  for (int i = 0; i < 40000; ++i) {
    const double t = 0.005 * i;
    const MruReading r = mru.sample(platform_state(level(), heaving(A, w, t)));
    if (t < 150) continue;
    worst = std::max(worst, std::abs(r.p_origin_H_m.z() - A * gain * std::sin(w * t + phase)));
    worst = std::max(worst, std::abs(r.v_origin_H_mps.z() - A * gain * w * std::cos(w * t + phase)));
  }
  EXPECT_LT(worst, 1e-5);
  EXPECT_NEAR(gain, 1 / 1.4, 1e-6) << "at its own period the filter passes 1 / (2 zeta)";
}

TEST(MruSensor, AHeldOffsetIsForgotten) {
  MruSensor mru = unit(perfect());
  const double w = 2 * kPi * 0.2;
  MruReading r{};
  for (int i = 0; i < 20000; ++i) {
    const double t = 0.005 * i;
    ShipCoordinates s;
    if (t < 2.5) {  // half a cosine to surge 0.3 m
      s.eta[0] = 0.15 * (1 - std::cos(w * t));
      s.eta_dot[0] = 0.15 * w * std::sin(w * t);
      s.eta_ddot[0] = 0.15 * w * w * std::cos(w * t);
    } else {
      s.eta[0] = 0.3;
    }
    r = mru.sample(platform_state(level(), s));
  }
  EXPECT_LT(r.p_origin_H_m.norm(), 1e-6);
}

TEST(MruSensor, WithoutHighPassThePositionIsAbsolute) {
  MruConfig c = perfect();
  c.high_pass = false;
  MruSensor mru = unit(c);
  ShipCoordinates s;
  s.eta << 0.3, 0.1, -0.2, 0, 0, kPi / 2;
  const MruReading r = mru.sample(platform_state(level(), s));
  EXPECT_LT((r.p_origin_H_m - Vector3d(0.1, -0.3, -0.2)).norm(), 1e-12) << "in the axes of its heading";
}

TEST(MruSensor, AWrongVerticalLeaksGravityIntoTheHorizontalAcceleration) {
  MruConfig c = perfect();
  c.roll_pitch_rms_rad = 3.5e-4;
  MruSensor mru = unit(c);
  for (int i = 0; i < 2000; ++i) {
    const MruReading r = mru.sample(platform_state(level(), {}));
    // Level in truth: what roll and pitch say is error, and a pitch error e leaks −g e forward, a roll error
    // g e to starboard.
    ASSERT_NEAR(r.a_origin_H_mps2.x(), -9.81 * r.euler_rad.y(), 1e-5);
    ASSERT_NEAR(r.a_origin_H_mps2.y(), 9.81 * r.euler_rad.x(), 1e-5);
    const double ws = 2 * kPi / 2.5;
    if (i == 0) {
      EXPECT_NEAR(r.p_origin_H_m.x(), r.a_origin_H_mps2.x() / (ws * ws), 2e-4) << "settled from the start";
    }
  }
}

TEST(MruSensor, NoiseHasTheConfiguredSize) {
  MruConfig c;
  c.yaw_walk_rad_per_sqrt_s = 0;
  c.misalignment_rad.setZero();
  MruSensor mru = unit(c);
  const int n = 400000;  // 2000 s: a hundred correlation times
  double roll2 = 0, lag2 = 0, rate2 = 0, az = 0, az2 = 0, last = 0;
  for (int i = 0; i < n; ++i) {
    const MruReading r = mru.sample(platform_state(level(), {}));
    roll2 += r.euler_rad.x() * r.euler_rad.x() / n;
    lag2 += std::pow(r.euler_rad.x() - last, 2) / n;
    last = r.euler_rad.x();
    rate2 += r.omega_M_radps.squaredNorm() / 3 / n;
    az += r.a_unit_M_mps2.z() / n;
    az2 += r.a_unit_M_mps2.z() * r.a_unit_M_mps2.z() / n;
  }
  EXPECT_NEAR(std::sqrt(roll2), 3.5e-4, 0.25 * 3.5e-4);
  EXPECT_LT(std::sqrt(lag2), 0.05 * 3.5e-4) << "slow, not white";
  EXPECT_NEAR(std::sqrt(rate2), 3e-4, 0.02 * 3e-4);
  EXPECT_NEAR(az, -0.038, 1e-4);
  EXPECT_NEAR(std::sqrt(az2 - az * az), 0.01, 2e-4);
}

TEST(MruSensor, BiasDoesNotReachTheFilteredHeave) {
  MruConfig c = perfect();
  c.acceleration_bias_mps2 = {0, 0, -0.038};
  MruSensor mru = unit(c);
  MruReading r{};
  for (int i = 0; i < 10000; ++i) r = mru.sample(platform_state(level(), {}));
  EXPECT_NEAR(r.a_origin_H_mps2.z(), -0.038, 1e-12);
  EXPECT_LT(r.p_origin_H_m.norm(), 1e-12);
}

TEST(MruSensor, YawWandersHalfADegreeAMinute) {
  MruConfig c = perfect();
  c.yaw_walk_rad_per_sqrt_s = MruConfig{}.yaw_walk_rad_per_sqrt_s;
  double sum2 = 0;
  const int runs = 60;
  for (int run = 0; run < runs; ++run) {
    MruSensor mru(c, level(), {}, static_cast<std::uint64_t>(run), "mru1");
    MruReading r{};
    for (int i = 0; i < 12000; ++i) r = mru.sample(platform_state(level(), {}));
    sum2 += std::pow(r.euler_rad.z() * 180 / kPi, 2) / runs;
  }
  EXPECT_NEAR(std::sqrt(sum2), 0.5, 0.15);
}

TEST(MruSensor, MisalignmentTurnsWhatItSays) {
  MruConfig c = perfect();
  c.misalignment_rad = {0.13 * kPi / 180, 0.38 * kPi / 180, 1.5 * kPi / 180};
  MruSensor mru = unit(c);
  const MruReading r = mru.sample(platform_state(level(), {}));
  EXPECT_LT((r.euler_rad - c.misalignment_rad).norm(), 1e-12);
}

TEST(MruSensor, SeesGravityNotTheTiltOfTheSurveyedNeutral) {
  const Calibration lab;
  MruSensor mru(perfect(), lab.world_to_em8000, lab.em8000_to_mru1, 1, "mru1");
  const MruReading r = mru.sample(platform_state(lab.world_to_em8000, {}));
  // The surveyed neutral pose leans by half a milliradian; row 3 of R_WN is -down in N.
  const Eigen::RowVector3d up = lab.world_to_em8000.R.row(2);
  EXPECT_NEAR(r.euler_rad.x(), std::atan2(-up.y(), -up.z()), 1e-9);
  EXPECT_NEAR(r.euler_rad.y(), std::asin(up.x()), 1e-9);
  EXPECT_NEAR(r.euler_rad.z(), 0, 1e-6);
}

TEST(MruSensor, TheSameSeedGivesTheSameNumbersAndTheUnitsDiffer) {
  MruSensor a = unit({}), b = unit({});
  MruSensor other(MruConfig{}, level(), {}, 1, "mru2");
  const PlatformState rest = platform_state(level(), {});
  for (int i = 0; i < 10; ++i) {
    const MruReading ra = a.sample(rest), rb = b.sample(rest), ro = other.sample(rest);
    EXPECT_EQ(ra.omega_M_radps, rb.omega_M_radps);
    EXPECT_NE(ra.omega_M_radps, ro.omega_M_radps);
  }
}

}  // namespace
}  // namespace motionlab::plant
