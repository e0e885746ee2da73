#include "drivers/comau/comau_driver_posture.hpp"

#include <cmath>
#include <numbers>

namespace motionlab::comau {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr Joints kStrokeMin_deg{-180, -75, -256, -280, -120, -2700};
constexpr Joints kStrokeMax_deg{180, 95, -10, 280, 120, 2700};
constexpr Joints kSpeedMax_degps{110, 110, 110, 190, 190, 230};

/// Beyond the controller's strokes by so much only brackets and calibration differ.
constexpr double kStrokeSlack_deg = 5.0;
/// Overshoot of the servos and noise of the measured speed.
constexpr double kSpeedSlack = 1.5;
/// Noise and resolution of the measured position.
constexpr double kPositionSlack_rad = 0.005;

}  // namespace

Status PostureCheck::check(const Answer& answer, Nanoseconds passed) const noexcept {
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double q_deg = answer.q_rad[i] / kDegree;
    if (q_deg < kStrokeMin_deg[i] - kStrokeSlack_deg || q_deg > kStrokeMax_deg[i] + kStrokeSlack_deg) {
      return Fault{Reason::bad_value, "a joint position lies outside the arm's stroke"};
    }
    const double fastest_radps = kSpeedSlack * kSpeedMax_degps[i] * kDegree;
    if (std::abs(answer.qd_radps[i]) > fastest_radps) {
      return Fault{Reason::bad_value, "a joint is said to move faster than the arm can"};
    }
    if (!last_rad_) continue;
    const double farthest_rad = fastest_radps * seconds(passed) + kPositionSlack_rad;
    if (std::abs(answer.q_rad[i] - (*last_rad_)[i]) > farthest_rad) {
      return Fault{Reason::bad_value, "a joint is said to have jumped farther than the arm can move"};
    }
  }
  return Done{};
}

}  // namespace motionlab::comau
