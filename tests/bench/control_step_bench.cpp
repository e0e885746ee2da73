// What single control steps cost: the median and the 99th percentile of one step, not the mean of many.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "gateway/controller/guard.hpp"
#include "gateway/controller/load_keeper.hpp"
#include "tests/unit/estimator/laboratory.hpp"

namespace motionlab {
namespace {

constexpr double kSeconds = 5;

/// Everything the estimator hears in so many seconds, one entry a millisecond.
const std::vector<estimator::Inputs>& recording() {
  static const std::vector<estimator::Inputs> inputs = [] {
    test::Laboratory lab;
    std::vector<estimator::Inputs> all;
    for (int i = 0; i < static_cast<int>(1000 * kSeconds); ++i) {
      lab.step();
      all.push_back(lab.inputs());
    }
    return all;
  }();
  return inputs;
}

/// Times `step(i)` for every entry of the recording and reports the quantiles in µs.
template <class Step>
void measure(benchmark::State& state, Step&& step) {
  std::vector<double> times_us;
  std::size_t i = 0;
  for (auto _ : state) {
    const auto begin = std::chrono::steady_clock::now();
    step(i);
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
    times_us.push_back(took.count());
    state.SetIterationTime(1e-6 * took.count());
    i = (i + 1) % recording().size();
  }
  std::sort(times_us.begin(), times_us.end());
  const auto quantile = [&](double f) {
    return times_us[static_cast<std::size_t>(f * static_cast<double>(times_us.size() - 1))];
  };
  state.counters["p50_us"] = quantile(0.50);
  state.counters["p99_us"] = quantile(0.99);
}

controller::LoadKeeperConfig keeper_config() {
  const auto calibration = test::published_calibration();
  controller::LoadKeeperConfig config;
  config.arm = calibration.arm;
  config.X_BR = calibration.X_BR;
  return config;
}

void estimator_step(benchmark::State& state) {
  estimator::Belief belief;
  belief.calibration = test::published_calibration();
  estimator::LabEstimator dut(belief);
  measure(state, [&](std::size_t i) { benchmark::DoNotOptimize(dut.step(recording()[i])); });
}

void load_keeper_step(benchmark::State& state) {
  // What the keeper is told is estimated beforehand.
  estimator::Belief belief;
  belief.calibration = test::published_calibration();
  estimator::LabEstimator estimator(belief);
  controller::LoadKeeper dut(keeper_config());
  std::vector<controller::KeeperInputs> inputs;
  for (const auto& heard : recording()) {
    controller::KeeperInputs in;
    in.t = in.t_send = heard.t;
    in.estimate = estimator.step(heard);
    if (heard.arm) in.arm = *heard.arm;
    in.reference.p_WL = {0.847625, -0.407825, 3.919269};
    in.engaged = in.estimate.valid;
    inputs.push_back(in);
  }
  measure(state, [&](std::size_t i) { benchmark::DoNotOptimize(dut.step(inputs[i])); });
}

void guard_step(benchmark::State& state) {
  controller::GuardLimits limits;
  limits.q_min_rad.fill(-2.5);
  limits.q_max_rad.fill(2.5);
  limits.qd_max_radps.fill(0.5);
  limits.qdd_max_radps2.fill(3);
  limits.wire_min_m = 1.3;
  limits.wire_max_m = 2.7;
  controller::Guard dut(limits);
  controller::Guard::Inputs in;
  in.dt_s = 1e-3;
  in.may_move = true;
  in.q_rad.emplace();
  in.wire_length_m = 2.0;
  measure(state, [&](std::size_t i) {
    in.wish.emplace();
    in.wish->qd_radps.fill(0.6 * std::sin(0.01 * static_cast<double>(i)));
    benchmark::DoNotOptimize(dut.step(in));
  });
}

BENCHMARK(estimator_step)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(load_keeper_step)->UseManualTime()->Unit(benchmark::kMicrosecond);
BENCHMARK(guard_step)->UseManualTime()->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace motionlab

BENCHMARK_MAIN();
