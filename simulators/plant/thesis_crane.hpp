/// @file  The suspended load and the motion system of the thesis (Sec 4.5.1, 4.6.1): a tool point that can be
/// accelerated at will in the robot's axes, the robot on a ship or on the ground, a rigid wire below it.
#pragma once

#include <Eigen/Core>

#include "gateway/math/moving_base.hpp"
#include "gateway/math/rotation.hpp"
#include "simulators/plant/sea.hpp"

namespace motionlab::plant {

/// Wire length as a function of time: mean + amplitude sin(2 pi f t). Thesis Eq 5.2 (which lost its t).
struct ThesisWire {
  double mean_m = 2.0;
  double amplitude_m = 0.0;
  double frequency_hz = 0.05;

  [[nodiscard]] double length_m(double t_s) const;
  [[nodiscard]] double speed_mps(double t_s) const;
};

/// Where the robot stands. Defaults: on the ground, its axes the world's.
struct ThesisMount {
  math::RigidTransform X_WN;  ///< platform neutral
  math::RigidTransform X_BR;  ///< robot base in the platform's body
  /// The mistake of Eq 3.81/3.82: the tool's vertical acceleration enters the swing with the wrong sign.
  bool heave_upside_down = false;

  /// On the platform as the thesis prints it, the rotation made one by the nearest; N is z-down, so W turns
  /// it (the thesis prints no X_WN: heading and origin are a choice).
  [[nodiscard]] static ThesisMount on_ship();
  /// As the thesis computes: the swing equations, which want z up, fed in the axes of N, which is z-down, and
  /// the mount as printed. W then is left-handed, (x, y, −z) of N, in which a point mass swings by the same
  /// equations but for the sign of heave; the load hangs down.
  [[nodiscard]] static ThesisMount on_ship_as_printed();
};

/// State: tool point and velocity in the robot's axes (3 each), swing angles against the z axis of W (2) and
/// their rates (2). Rigid massless wire, point load, no friction: what swings, swings for ever.
class ThesisCrane {
 public:
  using State = Eigen::Matrix<double, 10, 1>;

  /// @param wave  whether the ship moves as in Tab 4.4, from t = 0 at once
  ThesisCrane(const ThesisMount& mount, bool wave, const ThesisWire& wire, double gravity_mps2 = 9.81);

  /// d/dt of the state when the tool is accelerated in the robot's axes.
  [[nodiscard]] State rate(double t_s, const State& state, const Eigen::Vector3d& a_RT) const;
  /// The tool point in W.
  [[nodiscard]] math::PointMotion tool(double t_s, const State& state, const Eigen::Vector3d& a_RT) const;
  /// The load in W (Eq 3.49).
  [[nodiscard]] Eigen::Vector3d p_WL(double t_s, const State& state) const;
  /// A point that is fixed in the robot's axes, in W, while the ship is at neutral.
  [[nodiscard]] Eigen::Vector3d at_neutral(const Eigen::Vector3d& p_R) const;
  /// The ship's coordinates in N.
  [[nodiscard]] ShipCoordinates ship(double t_s) const;
  [[nodiscard]] const ThesisWire& wire() const { return wire_; }

 private:
  ThesisMount mount_;
  bool wave_;
  ThesisWire wire_;
  double gravity_;
  ShipMotion motion_;
};

}  // namespace motionlab::plant
