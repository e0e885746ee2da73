#include "gateway/estimator/lab_estimator.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <vector>

#include "tests/support/allocations.hpp"
#include "tests/unit/estimator/laboratory.hpp"

namespace motionlab::estimator {
namespace {

using test::belief_of;
using test::kDegree;
using test::Laboratory;
using test::LaboratoryOptions;
using test::vector;
using topic::Estimate;
using Vector3d = Eigen::Vector3d;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

void append(std::vector<double>& to, double value) {
  to.push_back(value);
}
template <std::size_t N>
void append(std::vector<double>& to, const std::array<double, N>& values) {
  to.insert(to.end(), values.begin(), values.end());
}

/// Every number of an estimate but its counters and stamps.
std::vector<double> numbers(const Estimate& e) {
  std::vector<double> all;
  Estimate::fields(e, [&](std::string_view name, const auto& value) {
    if (name == "sequence_number" || name.substr(0, 2) == "t_") return;
    if constexpr (std::is_convertible_v<decltype(value), double>) {
      append(all, static_cast<double>(value));
    } else {
      append(all, value);
    }
  });
  return all;
}

bool all_finite(const Estimate& e) {
  const auto all = numbers(e);
  return std::all_of(all.begin(), all.end(), [](double v) { return std::isfinite(v); });
}

/// Runs an estimator in a laboratory for so many seconds; `tamper` may change what it hears, `look` sees what
/// it says.
template <class Tamper, class Look>
void run(Laboratory& lab, LabEstimator& dut, double seconds, Tamper&& tamper, Look&& look) {
  const int steps = static_cast<int>(seconds * 1000 + 0.5);
  for (int i = 0; i < steps; ++i) {
    lab.step();
    Inputs in = lab.inputs();
    tamper(in);
    look(dut.step(in));
  }
}
const auto honestly = [](Inputs&) {};
const auto unseen = [](const Estimate&) {};

struct Errors {
  double tool_rms = 0, load_rms = 0, tool_nees = 0, load_nees = 0, load_speed_rms = 0, tool_speed_rms = 0;
};

/// Errors against truth over the last part of a run; consistency on the horizontal axes and the tool's
/// height.
Errors judge(Laboratory& lab, LabEstimator& dut, double settle_s, double judged_s) {
  run(lab, dut, settle_s, honestly, unseen);
  Errors sum;
  int count = 0;
  run(lab, dut, judged_s, honestly, [&](const Estimate& e) {
    const Vector3d tool = vector(e.p_world_tool_m) - lab.tool(lab.t());
    const Vector3d load = vector(e.p_world_load_m) - lab.load();
    sum.tool_rms += tool.squaredNorm();
    sum.load_rms += load.squaredNorm();
    sum.tool_speed_rms += (vector(e.v_world_tool_mps) - lab.tool_velocity()).squaredNorm();
    sum.load_speed_rms += (vector(e.v_world_load_mps) - lab.load_velocity()).squaredNorm();
    sum.tool_nees += tool.cwiseQuotient(vector(e.p_world_tool_sd_m)).squaredNorm() / 3;
    sum.load_nees += load.head<2>().cwiseQuotient(vector(e.p_world_load_sd_m).head<2>()).squaredNorm() / 2;
    ++count;
  });
  const auto rms = [count](double& s) { s = std::sqrt(s / count); };
  rms(sum.tool_rms);
  rms(sum.load_rms);
  rms(sum.tool_speed_rms);
  rms(sum.load_speed_rms);
  sum.tool_nees /= count;
  sum.load_nees /= count;
  return sum;
}

// ---------------------------------------------------------------- before the first data

TEST(LabEstimator, IsNotValidBeforeEverySourceWasHeard) {
  for (const int silent : {0, 1, 2, 3}) {
    Laboratory lab;
    LabEstimator dut(belief_of(lab));
    run(
        lab, dut, 0.5,
        [silent](Inputs& in) {
          if (silent == 0) in.mru.reset();
          if (silent == 1) in.load.reset();
          if (silent == 2) in.arm.reset();
          if (silent == 3) in.winch.reset();
        },
        [](const Estimate& e) {
          EXPECT_FALSE(e.valid);
          EXPECT_TRUE(all_finite(e));
        });
    run(lab, dut, 0.1, honestly, unseen);
    lab.step();
    EXPECT_TRUE(dut.step(lab.inputs()).valid) << silent;
  }
}

TEST(LabEstimator, SaysWithoutAnyInputThatNothingIsKnown) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  Inputs in;
  for (int i = 0; i < 100; ++i) {
    in.t = Laboratory::time(1e6 + 0.001 * i);
    const Estimate e = dut.step(in);
    EXPECT_FALSE(e.valid);
    EXPECT_FALSE(e.load_tracked);
    EXPECT_FALSE(e.platform_tracked);
    EXPECT_EQ(e.sequence_number, static_cast<std::uint64_t>(i + 1));
    EXPECT_EQ(e.t_estimated_ns, to_ns(in.t));
  }
}

// ---------------------------------------------------------------- truth

struct Case {
  const char* name;
  bool body;
  test::Arm arm;
  double tool_m;
  double load_m;
};

class Converges : public testing::TestWithParam<Case> {};

TEST_P(Converges, ToAMillimetre) {
  LaboratoryOptions options;
  options.platform_body = GetParam().body;
  options.arm = GetParam().arm;
  Laboratory lab(options);
  LabEstimator dut(belief_of(lab));
  const Errors e = judge(lab, dut, 30, 30);
  EXPECT_LT(e.tool_rms, GetParam().tool_m);
  EXPECT_LT(e.load_rms, GetParam().load_m);
  EXPECT_LT(e.tool_speed_rms, 0.01);
  EXPECT_LT(e.load_speed_rms, 0.02);
  EXPECT_EQ(dut.refused(), 0u);
  // Coarse on purpose: the beliefs are wider than white noise needs, never narrower than the errors. A load
  // that swings far is no linear pendulum; its belief is not judged.
  if (GetParam().arm == test::Arm::rests) return;
  EXPECT_LT(e.tool_nees, 3);
  EXPECT_LT(e.load_nees, 3);
  EXPECT_GT(e.tool_nees, 0.003);
  EXPECT_GT(e.load_nees, 0.003);
}

INSTANTIATE_TEST_SUITE_P(
    LabEstimator, Converges,
    testing::Values(Case{"TheToolHeldWithAPlatformBody", true, test::Arm::holds_tool, 1e-3, 1e-3},
                    Case{"TheToolHeldWithoutAPlatformBody", false, test::Arm::holds_tool, 1e-3, 1e-3},
                    Case{"TheToolMovingWithAPlatformBody", true, test::Arm::wanders, 1e-3, 1e-3},
                    Case{"TheToolMovingWithoutAPlatformBody", false, test::Arm::wanders, 1e-3, 1e-3},
                    Case{"TheToolOnTheShipWithAPlatformBody", true, test::Arm::rests, 5e-3, 5e-3},
                    Case{"TheToolOnTheShipWithoutAPlatformBody", false, test::Arm::rests, 15e-3, 5e-3}),
    [](const auto& one) { return one.param.name; });

TEST(LabEstimator, SwingAndItsRateAreThoseOfTheLoadAlsoWhileTheWireMoves) {
  LaboratoryOptions options;
  options.wire_moves = true;
  options.noise = 0;
  Laboratory lab(options);
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  // Eq 3.49 read backwards from truth, and its rates from differences of truth.
  const auto truth = [&] {
    const Vector3d d = lab.load() - lab.tool(lab.t());
    return Eigen::Vector2d(std::asin(-d.x() / d.norm()), std::atan2(d.y(), -d.z()));
  };
  Eigen::Vector2d before = truth();
  Estimate last;
  bool started = false;
  run(lab, dut, 10, honestly, [&](const Estimate& e) {
    const Eigen::Vector2d now = truth();
    if (started) {
      EXPECT_NEAR(last.swing_rad[0], before[0], 2e-3);
      EXPECT_NEAR(last.swing_rad[1], before[1], 2e-3);
      EXPECT_NEAR(0.5 * (last.swing_rate_radps[0] + e.swing_rate_radps[0]), (now[0] - before[0]) / 1e-3,
                  4e-3);
      EXPECT_NEAR(0.5 * (last.swing_rate_radps[1] + e.swing_rate_radps[1]), (now[1] - before[1]) / 1e-3,
                  4e-3);
    }
    started = true;
    last = e;
    before = now;
  });
}

// ---------------------------------------------------------------- which readings count, and how

TEST(LabEstimator, FiltersAndUnusedVariablesOfTheMruChangeNoBit) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab)), deceived(belief_of(lab));
  for (int i = 0; i < 5000; ++i) {
    lab.step();
    Inputs in = lab.inputs();
    const auto honest = numbers(dut.step(in));
    if (in.mru) {
      in.mru->p_heading_origin_m = {1e6, kNan, -kInfinity};
      in.mru->v_heading_origin_mps = {-3e3, kNan, 1};
      in.mru->v_mru_mps = {kNan, 7, 7};
      in.mru->a_mru_mps2 = {99, -99, kNan};
      in.mru->omega_down_radps = kNan;
    }
    ASSERT_EQ(numbers(deceived.step(in)), honest) << i;
  }
}

TEST(LabEstimator, TheLeverArmIsNotAppliedAgainToWhatIsAlreadyAtTheOrigin) {
  // The same readings from a unit mounted five metres away, which was told so: nothing changes.
  Laboratory lab;
  Belief elsewhere = belief_of(lab);
  elsewhere.calibration.X_BM.p += Vector3d(3, -4, 1);
  elsewhere.calibration.p_MO = elsewhere.calibration.X_BM.inverse().p;
  LabEstimator dut(belief_of(lab)), far(elsewhere);
  for (int i = 0; i < 5000; ++i) {
    lab.step();
    const Inputs in = lab.inputs();
    const auto a = numbers(dut.step(in)), b = numbers(far.step(in));
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t k = 0; k < a.size(); ++k) ASSERT_NEAR(a[k], b[k], 1e-9) << i;
  }
}

TEST(LabEstimator, AnUnstableMruIsNotListenedTo) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 2, honestly, unseen);
  EXPECT_EQ(dut.refused(), 0u);
  run(
      lab, dut, 1,
      [](Inputs& in) {
        in.mru->stable = false;
        in.mru->euler_heading_mru_rad = {0.3, 0.3, 0.3};
      },
      [](const Estimate& e) { EXPECT_TRUE(all_finite(e)); });
  EXPECT_NEAR(static_cast<double>(dut.refused()), 200, 4);
}

// ---------------------------------------------------------------- lost bodies, silence, time

TEST(LabEstimator, ALostBodyNeverBecomesAPose) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  lab.load_hidden = lab.platform_hidden = true;
  bool said = false;
  run(lab, dut, 1, honestly, [&](const Estimate& e) {
    EXPECT_LT((vector(e.p_world_load_m) - lab.load()).norm(), 0.02);
    EXPECT_LT((vector(e.p_world_tool_m) - lab.tool(lab.t())).norm(), 0.02);
    said = !e.load_tracked && !e.platform_tracked;
  });
  EXPECT_TRUE(said);
  EXPECT_EQ(dut.refused(), 0u);
  lab.load_hidden = lab.platform_hidden = false;
  const Errors after = judge(lab, dut, 5, 5);
  EXPECT_LT(after.tool_rms, 1.5e-3);
  EXPECT_LT(after.load_rms, 1.5e-3);
}

TEST(LabEstimator, ALostBodyDoesNotStartTheFilter) {
  Laboratory lab;
  lab.load_hidden = true;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 1, honestly, [](const Estimate& e) { EXPECT_FALSE(e.valid); });
}

TEST(LabEstimator, DuplicatedSamplesDoNoHarm) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab)), insistent(belief_of(lab));
  for (int i = 0; i < 3000; ++i) {
    lab.step();
    const Inputs in = lab.inputs();
    Inputs nothing;
    nothing.t = in.t;
    dut.step(in);
    insistent.step(in);
    ASSERT_EQ(numbers(insistent.step(in)), numbers(dut.step(nothing)));
  }
  EXPECT_EQ(insistent.refused(), 0u);
}

/// How many measurements a step takes in, by what the innovations count.
int taken_by(LabEstimator& dut, const Inputs& in) {
  const auto counts = [&dut](std::initializer_list<Reading> kinds) {
    std::uint64_t sum = 0;
    for (const Reading kind : kinds) sum += dut.innovations(kind).taken;
    return sum;
  };
  const auto all = [&] {
    return std::array{counts({Reading::mru_angle, Reading::mru_rate, Reading::mru_acceleration}),
                      counts({Reading::load_place, Reading::load_height}),
                      counts({Reading::platform_place, Reading::platform_angle})};
  };
  const auto before = all();
  dut.step(in);
  const auto after = all();
  constexpr std::array<std::uint64_t, 3> kOfOne{9, 3, 6};
  int measurements = 0;
  for (std::size_t i = 0; i < kOfOne.size(); ++i) {
    measurements += static_cast<int>((after[i] - before[i]) / kOfOne[i]);
  }
  return measurements;
}

TEST(LabEstimator, AStepTakesInOneMeasurement) {
  Laboratory lab;  // MRU and cameras measure at the same times, so that three measurements fall due together
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 2, honestly, unseen);
  int busy = 0;
  for (int i = 0; i < 1000; ++i) {
    lab.step();
    const int measurements = taken_by(dut, lab.inputs());
    ASSERT_LE(measurements, 1);
    busy += measurements;
  }
  EXPECT_NEAR(busy, 600, 3);
  EXPECT_EQ(dut.refused(), 0u);
}

TEST(LabEstimator, WhatPiledUpIsTakenInBitByBit) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 2, honestly, unseen);
  // Nobody steps for 30 ms: what waited for its turn is due at once, and the newest sample of each.
  for (int i = 0; i < 30; ++i) lab.step();
  int steps = 0, most = 0;
  for (int all = 0; all < 9; ++steps) {
    ASSERT_LT(steps, 20);
    const int measurements = taken_by(dut, lab.inputs());
    most = std::max(most, measurements);
    all += measurements;
    lab.step();
  }
  EXPECT_GT(most, 1) << "faster than one a step";
  EXPECT_LE(most, 3);
  EXPECT_EQ(dut.refused(), 0u);
}

TEST(LabEstimator, SamplesTooLateForTheirTurnAreCountedAndHarmless) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  topic::Bodies old = *lab.inputs().load;
  for (int i = 0; i < 100; ++i) {
    lab.step();
    dut.step(lab.inputs());
  }
  const auto before = dut.refused();
  Inputs in = lab.inputs();
  old.sequence_number += 1000000;
  in.load = old;
  dut.step(in);
  EXPECT_EQ(dut.refused(), before + 1);
  const Errors after = judge(lab, dut, 0.1, 2);
  EXPECT_LT(after.load_rms, 1.5e-3);
}

TEST(LabEstimator, TheOrderOfArrivalDoesNotMatter) {
  // Two laboratories that differ in nothing but in how long MRU and cameras are under way.
  LaboratoryOptions quick_mru, quick_cameras;
  quick_mru.mru_latency_s = 0.001;
  quick_mru.camera_latency_s = 0.010;
  quick_cameras.mru_latency_s = 0.010;
  quick_cameras.camera_latency_s = 0.001;
  Laboratory a(quick_mru), b(quick_cameras);
  LabEstimator first(belief_of(a)), second(belief_of(b));
  for (int i = 0; i < 10000; ++i) {
    // Both begin with the same sighting of the load.
    a.load_hidden = b.load_hidden = i < 100;
    a.step();
    b.step();
    const auto from_a = numbers(first.step(a.inputs())), from_b = numbers(second.step(b.inputs()));
    ASSERT_EQ(from_a, from_b) << i;
  }
  EXPECT_EQ(first.refused(), 0u);
}

TEST(LabEstimator, OfTwoSamplesOfTheSameTimeTheOrderOfArrivalDoesNotMatter) {
  Laboratory lab;
  LabEstimator first(belief_of(lab)), second(belief_of(lab));
  for (int i = 0; i < 4000; ++i) {
    lab.step();
    Inputs in = lab.inputs();
    if (in.load) in.load->t_measured_ns = in.mru ? in.mru->t_measured_ns : in.load->t_measured_ns;
    if (in.platform) in.platform.reset();
    Inputs early = in, late = in;
    if (i % 10 < 5) {
      early.mru.reset();
      late.load.reset();
    }
    first.step(early);
    second.step(late);
    const auto a = numbers(first.step(in)), b = numbers(second.step(in));
    ASSERT_EQ(a, b) << i;
  }
}

TEST(LabEstimator, StaysFiniteForEverWhenAllSourcesFallSilentAndItsDoubtGrows) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 10, honestly, unseen);
  Inputs in = lab.inputs();
  const Estimate last = dut.step(in);
  Estimate e;
  for (int i = 0; i < 120000; ++i) {
    in.t += 1ms;
    e = dut.step(in);
    if (i % 100 == 0) {
      ASSERT_TRUE(all_finite(e)) << i;
    }
  }
  EXPECT_FALSE(e.load_tracked);
  EXPECT_FALSE(e.platform_tracked);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_GT(e.p_world_tool_sd_m[k], 10 * last.p_world_tool_sd_m[k]);
    EXPECT_LT(std::abs(e.p_world_load_m[k] - last.p_world_load_m[k]), 2.0);
  }
}

TEST(LabEstimator, BeginsAnewWhenTimeJumps) {
  for (const double jump : {3600.0, -3600.0, 2.5, -2.5, 1e7}) {
    Laboratory lab;
    LabEstimator dut(belief_of(lab));
    const auto moved = [jump](Inputs& in) {
      const Nanoseconds by = from_seconds(jump);
      in.t += by;
      const auto shift = [by](auto& sample) {
        if (sample) sample->t_measured_ns += by.count();
      };
      shift(in.mru);
      shift(in.load);
      shift(in.platform);
      shift(in.arm);
      shift(in.winch);
    };
    run(lab, dut, 10, honestly, unseen);
    run(lab, dut, 20, moved, [&](const Estimate& e) { ASSERT_TRUE(all_finite(e)) << jump; });
    double worst = 0;
    bool valid = true;
    run(lab, dut, 1, moved, [&](const Estimate& e) {
      valid = valid && e.valid;
      worst = std::max(worst, (vector(e.p_world_tool_m) - lab.tool(lab.t())).norm());
    });
    EXPECT_TRUE(valid) << jump;
    EXPECT_LT(worst, 4e-3) << jump;
  }
}

TEST(LabEstimator, ASmallJumpOfTimeIsCrossed) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  for (int i = 0; i < 300; ++i) {
    lab.step();
    (void)lab.inputs();
  }
  const Errors after = judge(lab, dut, 1, 2);
  EXPECT_LT(after.load_rms, 2e-3);
}

TEST(LabEstimator, StampsFromTheFutureAreRefusedAndDoNotFillTheQueue) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  std::uint64_t sequence = 1u << 30;
  run(
      lab, dut, 0.2,
      [&](Inputs& in) {
        in.mru->sequence_number = ++sequence;
        in.mru->t_measured_ns += 3'600'000'000'000;
        in.arm->sequence_number = ++sequence;
        in.arm->t_measured_ns = std::numeric_limits<std::int64_t>::max();
        in.winch->sequence_number = ++sequence;
        in.winch->t_measured_ns = std::numeric_limits<std::int64_t>::min();
      },
      [](const Estimate& e) { ASSERT_TRUE(all_finite(e)); });
  EXPECT_EQ(dut.refused(), 600u);
  const Errors after = judge(lab, dut, 5, 5);
  EXPECT_LT(after.tool_rms, 1.5e-3);
}

// ---------------------------------------------------------------- bad readings

TEST(LabEstimator, AWildReadingIsRefusedByTheGateAndCounted) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  ASSERT_EQ(dut.refused(), 0u);
  int left = 5;
  std::uint64_t last = lab.inputs().load->sequence_number;
  run(
      lab, dut, 1,
      [&](Inputs& in) {
        if (in.load->sequence_number == last || left == 0) return;
        last = in.load->sequence_number;
        --left;
        for (double& p : in.load->p_camera_body_m) p += 0.5;
      },
      [&](const Estimate& e) { EXPECT_LT((vector(e.p_world_load_m) - lab.load()).norm(), 5e-3); });
  EXPECT_EQ(dut.refused(), 15u);
}

TEST(LabEstimator, WhatIsNotFiniteOrImpossibleIsRefusedAndPoisonsNothing) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  Random random(5);
  const double bad[] = {kNan, kInfinity, -kInfinity, 1e300, -1e9};
  const auto spoil = [&](auto& values) { values[random.below(3)] = bad[random.below(5)]; };
  std::uint64_t sequence = 1u << 30;
  run(
      lab, dut, 2,
      [&](Inputs& in) {
        const auto anew = [&](auto& sample) {
          if (sample) sample->sequence_number = ++sequence;
        };
        switch (random.below(8)) {
          case 0:
            anew(in.mru);
            spoil(in.mru->euler_heading_mru_rad);
            break;
          case 1:
            anew(in.mru);
            spoil(in.mru->omega_mru_radps);
            break;
          case 2:
            anew(in.mru);
            spoil(in.mru->a_heading_origin_mps2);
            break;
          case 3:
            anew(in.load);
            spoil(in.load->p_camera_body_m);
            break;
          case 4:
            anew(in.platform);
            spoil(in.platform->q_camera_body);
            break;
          case 5:
            anew(in.arm);
            spoil(in.arm->q_rad);
            break;
          case 6:
            anew(in.arm);
            spoil(in.arm->qd_radps);
            break;
          default:
            anew(in.winch);
            in.winch->wire_length_m = random.chance(0.3) ? 0.0 : bad[random.below(5)];
        }
      },
      [&](const Estimate& e) {
        ASSERT_TRUE(all_finite(e));
        ASSERT_LT((vector(e.p_world_tool_m) - lab.tool(lab.t())).norm(), 0.02);
      });
  EXPECT_EQ(dut.refused(), 2000u);
  const Errors after = judge(lab, dut, 3, 3);
  EXPECT_LT(after.tool_rms, 1.5e-3);
}

TEST(LabEstimator, APoseWithoutARotationIsRefused) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(
      lab, dut, 1,
      [](Inputs& in) {
        if (in.platform) in.platform->q_camera_body = {};
      },
      unseen);
  EXPECT_NEAR(static_cast<double>(dut.refused()), 199, 3);
}

TEST(LabEstimator, RandomBitsInEveryReadingNeverMakeItSayWhatIsNotFinite) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 1, honestly, unseen);
  Random random(9);
  const auto any = [&](auto& values) {
    for (double& v : values) {
      v = random.chance(0.5) ? std::bit_cast<double>(random.bits()) : random.uniform(-1000, 1000);
    }
  };
  run(
      lab, dut, 20,
      [&](Inputs& in) {
        any(in.mru->euler_heading_mru_rad);
        any(in.mru->omega_mru_radps);
        any(in.mru->a_heading_origin_mps2);
        any(in.load->p_camera_body_m);
        any(in.platform->p_camera_body_m);
        any(in.platform->q_camera_body);
        any(in.arm->q_rad);
        any(in.arm->qd_radps);
        in.winch->wire_length_m = random.uniform(-1, 110);
        in.winch->wire_speed_mps = random.uniform(-1000, 1000);
        in.load->t_measured_ns += static_cast<std::int64_t>(random.below(40'000'000)) - 20'000'000;
      },
      [](const Estimate& e) { ASSERT_TRUE(all_finite(e)); });
  EXPECT_GT(dut.refused(), 1000u);
}

TEST(LabEstimator, AFirstSightingInTheWrongPlaceIsForgotten) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  int sightings = 0;
  std::uint64_t last = 0;
  run(
      lab, dut, 30,
      [&](Inputs& in) {
        if (!in.load) return;
        if (in.load->sequence_number != last) ++sightings;
        last = in.load->sequence_number;
        if (sightings < 3) in.load->p_camera_body_m = {3, 3, 3};
      },
      unseen);
  const Errors after = judge(lab, dut, 0.001, 5);
  EXPECT_LT(after.load_rms, 1.5e-3);
}

TEST(LabEstimator, FindsALoadThatSomebodyPushed) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  run(lab, dut, 20, honestly, unseen);
  // A hand: half a second at 1.5 m/s² sideways, far beyond what the belief allows.
  lab.push({1.5, -1.0, 0});
  run(lab, dut, 0.5, honestly, unseen);
  lab.push({0, 0, 0});
  run(lab, dut, 1.0, honestly, unseen);
  double worst = 0;
  run(lab, dut, 3.0, honestly,
      [&](const Estimate& e) { worst = std::max(worst, (vector(e.p_world_load_m) - lab.load()).norm()); });
  EXPECT_LT(worst, 0.02);
}

// ---------------------------------------------------------------- real time

TEST(LabEstimator, NeverAllocates) {
  Laboratory lab;
  LabEstimator dut(belief_of(lab));
  for (int i = 0; i < 2000; ++i) {
    lab.step();
    const Inputs in = lab.inputs();
    const std::size_t before = test::allocations;
    const Estimate e = dut.step(in);
    ASSERT_EQ(test::allocations, before) << i;
    ASSERT_EQ(e.valid, i > 30 || e.valid);
  }
  const std::size_t before = test::allocations;
  delete new int(7);
  EXPECT_EQ(test::allocations, before + 1) << "the counter counts";
}

}  // namespace
}  // namespace motionlab::estimator
