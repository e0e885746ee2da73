/// @file  Random errors: vectors of white noise, random directions, slow errors.
#pragma once

#include <Eigen/Core>

#include "drivers/core/random.hpp"

namespace motionlab::plant {

/// Three independent numbers of mean 0 and standard deviation 1.
[[nodiscard]] Eigen::Vector3d normal3(Random& random);

/// A unit vector, all directions alike.
[[nodiscard]] Eigen::Vector3d direction(Random& random);

/// A slow error: first-order Gauss–Markov process of given rms and correlation time, started in its
/// stationary distribution.
class GaussMarkov {
 public:
  GaussMarkov(double rms, double correlation_s, double step_s, Random& random);
  /// Moves on by one step and returns the value.
  double step(Random& random);
  [[nodiscard]] double value() const { return value_; }

 private:
  double keep_;
  double add_;
  double value_;
};

}  // namespace motionlab::plant
