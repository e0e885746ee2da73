/// @file  The fault of the world itself: wind on the load.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "drivers/core/result.hpp"

namespace motionlab::lab {

/// A steady horizontal force on the load's centre while it is active.
class Gust {
 public:
  static constexpr std::string_view kName = "gust";
  static constexpr double kDefault_n = 50.0;

  /// `gust` pushes along x of world, `gust:DEGREES` so far turned from it towards y. The value is the force
  /// in N, 0 the default.
  /// @returns refused, with the names that there are
  Status set(std::string_view fault, bool active, double value);

  [[nodiscard]] const Eigen::Vector3d& force_n() const { return force_n_; }

 private:
  Eigen::Vector3d force_n_ = Eigen::Vector3d::Zero();
};

}  // namespace motionlab::lab
