/// @file  Integrators of x' = f(t, x) for states of fixed size: the classical Runge–Kutta step, and a
/// Rosenbrock step for stiff equations (fast modes that have long died away must not dictate the step).
/// Nothing is allocated. A rate is anything callable as f(t, x) that returns a State.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace motionlab::math {

/// One classical Runge–Kutta step of fourth order: x(t + h).
template <class State, class Rate>
[[nodiscard]] State rk4_step(const Rate& f, double t, const State& x, double h) {
  const State k1 = f(t, x);
  const State k2 = f(t + h / 2, State(x + h / 2 * k1));
  const State k3 = f(t + h / 2, State(x + h / 2 * k2));
  const State k4 = f(t + h, State(x + h * k3));
  return x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
}

/// `steps` Runge–Kutta steps of equal size from t0 to t1.
template <class State, class Rate>
[[nodiscard]] State rk4(const Rate& f, double t0, const State& x0, double t1, int steps) {
  const double h = (t1 - t0) / steps;
  State x = x0;
  for (int i = 0; i < steps; ++i) x = rk4_step(f, t0 + i * h, x, h);
  return x;
}

template <class State>
using JacobianOf = Eigen::Matrix<double, State::RowsAtCompileTime, State::RowsAtCompileTime>;

/// df/dx by central differences, for rates whose derivative nobody wants to write.
template <class State, class Rate>
[[nodiscard]] JacobianOf<State> difference_jacobian(const Rate& f, double t, const State& x) {
  JacobianOf<State> J;
  State moved = x;
  for (int i = 0; i < State::RowsAtCompileTime; ++i) {
    const double d = 6e-6 * std::max(1.0, std::abs(x[i]));
    moved[i] = x[i] + d;
    const State above = f(t, moved);
    moved[i] = x[i] - d;
    J.col(i) = (above - f(t, moved)) / (2 * d);
    moved[i] = x[i];
  }
  return J;
}

/// What a stiff step gives.
template <class State>
struct StiffStep {
  State x;      ///< x(t + h), third order
  State error;  ///< estimate of its error, from an embedded second-order result
};

/// One step of RODAS3 (Sandu et al., Benchmarking stiff ODE solvers for atmospheric chemistry problems II,
/// 1997): third order, L-stable, stiffly accurate. Linearly implicit: one factorisation and four
/// back-substitutions, no iteration, so its cost is known beforehand.
/// @param J  df/dx at (t, x)
template <class State, class Rate>
[[nodiscard]] StiffStep<State> stiff_step(const Rate& f, const JacobianOf<State>& J, double t, const State& x,
                                          double h) {
  const double gamma = 0.5;
  const JacobianOf<State> M = JacobianOf<State>::Identity() / (gamma * h) - J;
  const Eigen::PartialPivLU<JacobianOf<State>> factor(M);
  // df/dt enters at third order; a central difference far inside the step does.
  const double d = 1e-3 * h;
  const State f_t = (f(t + d, x) - f(t - d, x)) / (2 * d);
  const State f0 = f(t, x);
  const State k1 = factor.solve(f0 + (0.5 * h) * f_t);
  const State k2 = factor.solve(f0 + (4 / h) * k1 + (1.5 * h) * f_t);
  const State k3 = factor.solve(f(t + h, State(x + 2 * k1)) + (1 / h) * (k1 - k2));
  const State y4 = x + 2 * k1 + k3;
  const State k4 = factor.solve(f(t + h, y4) + (1 / h) * (k1 - k2 - (8.0 / 3.0) * k3));
  return {y4 + k4, k4};
}

/// The same with the Jacobian by differences.
template <class State, class Rate>
[[nodiscard]] StiffStep<State> stiff_step(const Rate& f, double t, const State& x, double h) {
  return stiff_step(f, difference_jacobian(f, t, x), t, x, h);
}

/// How carefully `integrate_stiff` steps.
struct StiffTolerance {
  double absolute = 1e-9;
  double relative = 1e-6;
  double first_step = 1e-6;
  int most_steps = 1'000'000;  ///< taken or refused; what is left undone after so many is reported
};

/// Where `integrate_stiff` came to.
template <class State>
struct StiffPath {
  State x;
  double t = 0;
  int taken = 0;
  int refused = 0;
  bool arrived = false;  ///< false when the steps ran out or the state left the finite numbers
};

/// Integrates from t0 to t1 > t0 with steps chosen by the embedded error estimate. `jacobian(t, x)` gives
/// df/dx.
template <class State, class Rate, class Jacobian>
[[nodiscard]] StiffPath<State> integrate_stiff(const Rate& f, const Jacobian& jacobian, double t0,
                                               const State& x0, double t1,
                                               const StiffTolerance& tolerance = {}) {
  StiffPath<State> path{x0, t0, 0, 0, false};
  double h = std::min(tolerance.first_step, t1 - t0);
  while (path.taken + path.refused < tolerance.most_steps && path.t + h > path.t) {
    const bool last = path.t + h >= t1;
    if (last) h = t1 - path.t;
    const StiffStep<State> next = stiff_step<State>(f, jacobian(path.t, path.x), path.t, path.x, h);
    const State larger = path.x.cwiseAbs().cwiseMax(next.x.cwiseAbs());
    const double size = std::sqrt(
        (next.error.array() / (tolerance.absolute + tolerance.relative * larger.array())).square().mean());
    if (!std::isfinite(size)) {
      ++path.refused;
      h *= 0.1;
      continue;
    }
    if (size <= 1) {
      ++path.taken;
      path.x = next.x;
      path.t = last ? t1 : path.t + h;
      if (last) {
        path.arrived = true;
        return path;
      }
    } else {
      ++path.refused;
    }
    h *= std::clamp(0.9 / std::cbrt(std::max(size, 1e-12)), 0.2, 6.0);
  }
  return path;
}

/// The same with the Jacobian by differences.
template <class State, class Rate>
[[nodiscard]] StiffPath<State> integrate_stiff(const Rate& f, double t0, const State& x0, double t1,
                                               const StiffTolerance& tolerance = {}) {
  return integrate_stiff(
      f, [&f](double t, const State& x) { return difference_jacobian(f, t, x); }, t0, x0, t1, tolerance);
}

}  // namespace motionlab::math
