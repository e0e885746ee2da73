#include "simulators/plant/noise.hpp"

#include <cmath>

namespace motionlab::plant {

Eigen::Vector3d normal3(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

Eigen::Vector3d direction(Random& random) {
  return normal3(random).normalized();
}

GaussMarkov::GaussMarkov(double rms, double correlation_s, double step_s, Random& random)
    : keep_(std::exp(-step_s / correlation_s)),
      add_(rms * std::sqrt(1 - keep_ * keep_)),
      value_(rms * random.normal()) {}

double GaussMarkov::step(Random& random) {
  value_ = keep_ * value_ + add_ * random.normal();
  return value_;
}

}  // namespace motionlab::plant
