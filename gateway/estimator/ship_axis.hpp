/// @file  One coordinate of the ship: position, velocity, acceleration and jerk of a noise-driven double
/// resonator.
#pragma once

#include <Eigen/Core>
#include <array>

namespace motionlab::estimator {

/// The belief of how a ship's coordinate moves: x⁗ = −c₃ x‴ − c₂ ẍ − c₁ ẋ − c₀ x + noise, which is the
/// cascade of two resonators (s² + 2ζωs + ω²)². The same for all six coordinates; only the noise differs.
class ShipAxis {
 public:
  static constexpr int kSize = 4;  ///< x, ẋ, ẍ, x‴

  ShipAxis(double period_s, double damping);

  /// exp(F dt), by its Taylor series to the ninth power. dt up to about 0.1 s.
  [[nodiscard]] Eigen::Matrix4d transition(double dt_s) const;
  /// Covariance that noise of unit density adds in dt.
  [[nodiscard]] static Eigen::Matrix4d noise(double dt_s);
  /// Stationary covariance under noise of unit density.
  [[nodiscard]] const Eigen::Matrix4d& stationary() const { return stationary_; }

 private:
  std::array<Eigen::Matrix4d, 10> taylor_;  ///< Fᵏ / k!
  Eigen::Matrix4d stationary_;
};

}  // namespace motionlab::estimator
