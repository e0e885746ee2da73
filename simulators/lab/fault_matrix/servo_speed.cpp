#include "simulators/lab/fault_matrix/servo_speed.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace motionlab::matrix {

namespace {

using std::numbers::pi;

/// Mean of s − 1 over the time T round the first peak of the step response s, T at most half a period.
/// s(t) − 1 = Re(c exp(z t)).
double mean_overshoot(ServoLoop loop, double T) {
  const double r = std::sqrt(1 - loop.zeta * loop.zeta);
  const std::complex<double> z = loop.omega_radps * std::complex(-loop.zeta, r);
  const std::complex<double> c(-1, loop.zeta / r);
  // s(t) = s(t − T) where Re(w exp(z t)) = 0; the t that is wanted lies in [h, h + T].
  const std::complex<double> w = c * (1.0 - std::exp(-z * T));
  const double turns = std::ceil((pi - pi / 2 + std::arg(w)) / pi - 1e-9);
  const double t = (pi / 2 - std::arg(w) + turns * pi) / z.imag();
  return (w * std::exp(z * t) / (T * z)).real();
}

}  // namespace

double servo_speed_share(ServoLoop loop, double speed_max, double acceleration_max) {
  const double r = std::sqrt(1 - loop.zeta * loop.zeta);
  const double M = std::exp(-pi * loop.zeta / r);
  const double T = std::min(2 * speed_max / acceleration_max, pi / (loop.omega_radps * r));
  constexpr double kAtOnce = 1e-6;  // of a radian of the loop: below it the mean is lost in rounding
  const double m = loop.omega_radps * T > kAtOnce ? mean_overshoot(loop, T) : M;
  return 1 + 2 * m / (1 - M);
}

}  // namespace motionlab::matrix
