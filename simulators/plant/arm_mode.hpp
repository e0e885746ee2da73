/// @file  The arm gives way: the lowest mode of a crane arm as felt at its tool point.
#pragma once

#include <cmath>
#include <numbers>

namespace motionlab::plant {

/// A mass on a spring and a damper, alike in all three directions, between the point where the servo posture
/// puts the tool and where the tool is:
///
///     e'' + 2 zeta w e' + w² e = −a + F/m        e, F in world axes
///
/// with a the acceleration of the posture's point in world and F the pull of the wire. The encoders see
/// nothing of e. Alike in all directions, so that the axes of world serve as well as those of the robot base;
/// what the base's turning adds (2 zeta w × 0.1 rad/s against w², below 1e-4) is left out. The arm's own
/// weight sags it too; the calibration has taken that out for the posture at home on a neutral ship, so only
/// its turning with the ship remains (`own_sag_m`, see World).
struct ArmMode {
  bool flexible = true;
  double frequency_hz = 12.0;
  double damping_ratio = 0.03;
  double mass_kg = 100.0;  ///< that moves with the tool point; with 12 Hz a stiffness of 0.57 N/µm

  static ArmMode rigid() { return {false}; }

  [[nodiscard]] double omega_radps() const { return 2 * std::numbers::pi * frequency_hz; }
  [[nodiscard]] double own_sag_m(double gravity_mps2) const {
    return flexible ? gravity_mps2 / (omega_radps() * omega_radps()) : 0.0;
  }
};

}  // namespace motionlab::plant
