/// @file  The law that keeps the load still: how a tool point that moves in the world should be accelerated.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "gateway/math/moving_base.hpp"

namespace motionlab::controller {

/// Weights of the regulator for one horizontal axis, and the bounds of what it may ask.
struct LoadLawConfig {
  double gravity_mps2 = 9.81;
  double weight_load_error = 20.0;  ///< on (load − reference)² [1/m²]
  double weight_tool_speed = 1.0;   ///< on V² [s²/m²]
  double weight_swing_rate = 4.0;   ///< on ḋ² [s²/m²]
  double weight_load_error_integral = 1.0;
  double vertical_omega_radps = 1.2;  ///< how fast the tool height is brought to its place
  double acceleration_max_mps2 = 1.5;
  double speed_max_mps = 0.6;
  double integral_zone_m = 0.10;  ///< the integral acts only this near to the reference
};

/// A tool point in software: where the tool shall be in the world, moved by the law and followed by the arm.
///
/// Per horizontal axis a linear quadratic regulator acts on tool position and speed, on the load's offset
/// from the tool and its rate, and on the integral of the load's error. The offset is taken from the software
/// tool point, not from the real one: a calibration error is then a constant that the integral removes.
///
/// A load that shall be accelerated hangs behind its tool: the regulator brings the tool to r + L/g r̈, and
/// the load with it to r. The jerk that this needs comes from a differentiating filter (0.1 s).
class LoadLaw {
 public:
  using Vector3d = Eigen::Vector3d;

  /// Solves the regulator for wire lengths of 0.5 … 7 m; @throws std::runtime_error for weights without
  /// solution.
  explicit LoadLaw(const LoadLawConfig& config);

  /// Begins with the tool where it is and as it moves: the first acceleration is bounded, there is no step.
  /// @param tool_height_m  where the tool shall be brought in z; the load's own height is the winch's
  /// business
  void start(const Vector3d& p_WT, const Vector3d& v_WT, double tool_height_m);

  /// Brings the tool to another height; the same rules hold.
  void set_tool_height(double tool_height_m) { tool_height_m_ = tool_height_m; }

  struct Inputs {
    math::PointMotion reference;  ///< where the load shall be, and how that place moves
    Vector3d p_WL;                ///< where the load is
    Vector3d v_WL;
    double wire_length_m = 0;
    double share =
        1.0;  ///< how much of the horizontal motion is the law's, 0…1; the rest rides with the ship
    Vector3d v_ship = Vector3d::Zero();  ///< of the ship's point at the tool, in W
  };
  void step(double dt_s, const Inputs& inputs);

  [[nodiscard]] const Vector3d& p_WT() const { return p_; }
  [[nodiscard]] Vector3d v_WT() const { return v_ + v_riding_; }
  [[nodiscard]] const Vector3d& a_WT() const { return a_; }

 private:
  using Gain = Eigen::Matrix<double, 1, 5>;  ///< on P, V, d, ḋ, ∫
  static constexpr double kShortest = 0.5;
  static constexpr double kLongest = 7.0;
  static constexpr int kGains = 66;

  [[nodiscard]] Gain gain(double wire_length_m) const;

  LoadLawConfig config_;
  std::array<Gain, kGains> gains_;
  Vector3d p_ = Vector3d::Zero();
  Vector3d v_ = Vector3d::Zero();
  Vector3d a_ = Vector3d::Zero();
  Eigen::Vector2d integral_ = Eigen::Vector2d::Zero();
  std::optional<Vector3d> a_reference_;   ///< of the reference, filtered
  Vector3d v_riding_ = Vector3d::Zero();  ///< what the tool does with the ship, horizontal
  double tool_height_m_ = 0;
};

}  // namespace motionlab::controller
