/// @file  Whether motion reference unit and cameras tell of the same laboratory.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <optional>

#include "gateway/estimator/belief.hpp"
#include "idl/arm_state.hpp"
#include "idl/bodies.hpp"
#include "idl/mru.hpp"
#include "idl/winch_state.hpp"

namespace motionlab::estimator {

/// Compares, slowly, what two independent ways say of one thing. A wrong sign, a frame exchanged, a wire's
/// zero that nobody set shows here, before anything moves; the filter would explain it away.
///
/// Tilt: roll and pitch of the platform by the unit, against the tracked body on it. Load: where the cameras
/// see it, against the plumb line below the tool by unit, joints and winch. Waves and swing average out over
/// the memory; nothing is told before two seconds of both.
class CrossCheck {
 public:
  explicit CrossCheck(const Calibration& calibration)
      : mount_(calibration.mount()), calibration_(calibration), arm_(calibration.arm) {}

  struct Inputs {
    double dt_s = 0;
    const topic::Mru* mru = nullptr;          ///< null: not heard or stale; likewise the others
    const topic::Bodies* platform = nullptr;  ///< not looked at while it is lost
    const topic::Bodies* load = nullptr;
    const topic::ArmState* arm = nullptr;
    const topic::WinchState* winch = nullptr;
  };
  void step(const Inputs& inputs);

  /// Roll and pitch of the cameras minus those of the unit [rad].
  [[nodiscard]] std::optional<Eigen::Vector2d> tilt_difference_rad() const { return told(tilt_); }
  /// Load seen minus load expected, in world [m].
  [[nodiscard]] std::optional<Eigen::Vector3d> load_difference_m() const { return told(load_); }

 private:
  static constexpr double kTiltMemory_s = 1.0;
  static constexpr double kLoadMemory_s = 4.0;
  static constexpr double kFirstVerdict_s = 2.0;

  template <int N>
  struct Mean {
    Eigen::Matrix<double, N, 1> value = Eigen::Matrix<double, N, 1>::Zero();
    double seen_s = 0;
    void add(const Eigen::Matrix<double, N, 1>& difference, double dt_s, double memory_s) {
      seen_s += dt_s;
      // A plain mean until the memory is full.
      value += std::min(1.0, dt_s / std::min(seen_s, memory_s)) * (difference - value);
    }
  };
  template <int N>
  static std::optional<Eigen::Matrix<double, N, 1>> told(const Mean<N>& mean) {
    return mean.seen_s >= kFirstVerdict_s ? std::optional(mean.value) : std::nullopt;
  }

  MruMount mount_;
  Calibration calibration_;
  math::CraneArm arm_;
  Mean<2> tilt_;
  Mean<3> load_;
};

}  // namespace motionlab::estimator
