/// @file  A place that is carried by the world or by the second ship, and handed over smoothly.
#pragma once

#include "gateway/math/moving_base.hpp"

namespace motionlab::controller {

/// Blends between a place that stands in the world and the same place carried by a ship. The share of the
/// ship goes to 0 or 1 through three lags of `kLag_s`, so that position, velocity and acceleration never
/// jump.
class CarriedPlace {
 public:
  static constexpr double kLag_s = 0.7;

  /// @param X_WN  the ship at neutral
  explicit CarriedPlace(const math::RigidTransform& X_WN) : X_NW_(X_WN.inverse()) {}

  /// The world carries it, at once.
  void reset() { stage_[0] = stage_[1] = stage_[2] = 0; }
  /// @param carried  whether the ship shall carry it
  void step(double dt_s, bool carried);
  /// The place's motion in W. @param p  with the ship at neutral  @param ship  X_WB is the ship's pose now
  [[nodiscard]] math::PointMotion motion(const math::PointMotion& p, const math::BodyMotion& ship) const;

 private:
  math::RigidTransform X_NW_;
  double stage_[3] = {0, 0, 0};
};

}  // namespace motionlab::controller
