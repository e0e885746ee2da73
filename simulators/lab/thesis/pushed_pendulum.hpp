/// @file  Fig 4.20 and 4.21 of the thesis: filters on a pendulum whose cart is pushed to and fro.
#pragma once

#include <cmath>
#include <numbers>
#include <utility>

#include "gateway/math/integrate.hpp"
#include "simulators/plant/thesis_pendulum.hpp"

namespace motionlab::thesis {

/// rms errors of a filter over 20 s, and over the last 10 of them.
struct PushedErrors {
  double angle_rms_deg = 0;
  double late_angle_rms_deg = 0;
  double late_rate_rms_degps = 0;
};

/// Starts at 20 deg, which the filter does not know, and pushes with sin(omega t) m/s²; measurements are
/// exact. Errors are of what the filter predicts for t, before it is told of t.
/// @param wire_length_m  what the load really hangs on
/// @param watch          called every millisecond with its number, the true state and the predicted one
template <class Filter, class Watch>
PushedErrors push_pendulum(Filter filter, double wire_length_m, double omega_radps, const Watch& watch) {
  constexpr double kDegree = std::numbers::pi / 180;
  constexpr int kSteps = 20'000, kLate = 10'000;
  const plant::ThesisPendulum pendulum(wire_length_m);
  Eigen::Vector4d x(0, 0, 20 * kDegree, 0);
  double angle = 0, late_angle = 0, late_rate = 0;
  for (int k = 0; k < kSteps; ++k) {
    const double t = 1e-3 * k, u = std::sin(omega_radps * t);
    watch(k, x, filter.state().x);
    const Eigen::Vector4d error = (filter.state().x - x) / kDegree;
    angle += error[2] * error[2];
    if (k >= kLate) {
      late_angle += error[2] * error[2];
      late_rate += error[3] * error[3];
    }
    filter.update({x[0], x[2]});
    x = math::rk4_step([&](double, const Eigen::Vector4d& s) { return pendulum.rate(s, u); }, t, x, 1e-3);
    filter.predict(u);
  }
  return {std::sqrt(angle / kSteps), std::sqrt(late_angle / (kSteps - kLate)),
          std::sqrt(late_rate / (kSteps - kLate))};
}

/// The same, unwatched.
template <class Filter>
[[nodiscard]] PushedErrors push_pendulum(Filter filter, double wire_length_m, double omega_radps) {
  return push_pendulum(std::move(filter), wire_length_m, omega_radps,
                       [](int, const Eigen::Vector4d&, const Eigen::Vector4d&) {});
}

}  // namespace motionlab::thesis
