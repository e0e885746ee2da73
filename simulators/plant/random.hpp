/// @file  Repeatable random numbers: the same seed and stream give the same numbers with every library.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>

namespace motionlab::plant {

/// One stream of random numbers (xoshiro256++, seeded by splitmix64). Every purpose has a stream with a name
/// of its own, so that switching one noise off leaves all the others as they were.
class Random {
 public:
  Random(std::uint64_t seed, std::string_view stream);

  [[nodiscard]] std::uint64_t next();
  /// In [0, 1).
  [[nodiscard]] double uniform();
  /// Mean 0, standard deviation 1.
  [[nodiscard]] double gaussian();
  [[nodiscard]] Eigen::Vector3d gaussian3();
  /// A unit vector, all directions alike.
  [[nodiscard]] Eigen::Vector3d direction();

 private:
  std::array<std::uint64_t, 4> s_{};
  double spare_ = 0;
  bool has_spare_ = false;
};

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
