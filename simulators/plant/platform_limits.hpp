/// @file  What a motion platform can do, and whether a ship motion is within it.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "simulators/plant/sea.hpp"

namespace motionlab::plant {

/// Bounds of the six ship coordinates, m and rad, in the order of ShipCoordinates.
struct PlatformLimits {
  std::string_view name;  ///< for people
  Vector6d min, max;
  Vector6d speed;         ///< magnitude
  Vector6d acceleration;  ///< magnitude

  /// The stroke, speed and acceleration of the EM8000 (thesis App. A.1.1).
  static PlatformLimits mechanical();
  /// The laboratory's operating limits, which its PLC holds, and the machine's speed and acceleration.
  static PlatformLimits plc();
};

/// The limit that a motion exceeds by the largest factor.
struct Excess {
  enum class Quantity { position, speed, acceleration };
  int coordinate;
  Quantity quantity;
  double reached;  ///< m, rad, per second or per second²
  double allowed;
  double t_s;
  double share_that_fits;  ///< so much of the whole motion is within all limits
};

/// Looks at a motion every 20 ms from its beginning to `until_s`. A recording that ends earlier stands still
/// then. @returns nothing when it stays within the limits
[[nodiscard]] std::optional<Excess> excess(const ShipMotion& motion, const PlatformLimits& limits,
                                           double until_s);

/// "heave: 0.86 m/s² after 312.4 s, the mechanical limit is 0.8 m/s²"
[[nodiscard]] std::string describe(const Excess& excess, const PlatformLimits& limits);

}  // namespace motionlab::plant
