/// @file  Our controller: keeps the load still in the world while the ship moves under the crane.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/controller/carried_place.hpp"
#include "gateway/controller/keeper.hpp"
#include "gateway/controller/load_law.hpp"
#include "gateway/controller/servo_belief.hpp"
#include "gateway/controller/set_point_observer.hpp"
#include "gateway/controller/smooth_point.hpp"
#include "gateway/math/crane_arm.hpp"
#include "gateway/math/moving_base.hpp"

namespace motionlab::controller {

struct LoadKeeperConfig {
  math::CraneArmGeometry arm;
  math::RigidTransform X_BR;         ///< robot base in platform body
  math::RigidTransform X_WN_second;  ///< second ship at neutral
  ServoBelief servo;
  ServoBelief winch{.omega_radps = 25.1327, .zeta = 0.7, .delay_s = 0.015};  ///< half a hold, half a task
  LoadLawConfig law;
  SmoothPointLimits reference;         ///< how briskly a new reference is approached
  double command_period_s = 0.005;     ///< how long each velocity holds
  double command_latency_s = 0.0005;   ///< from sending to the robot computer's integrator
  double set_point_gain_per_s = 30.0;  ///< how fast a wrong set point is corrected
  double observer_gain_per_s = 10.0;   ///< see SetPointObserver
  ServoIdentifierConfig identifier;    ///< how the servos' speed is learnt
  double height_gain_per_s = 0.5;      ///< winch speed per metre of load height error
  double height_speed_max_mps = 0.05;
};

/// Moves a tool point in software by `LoadLaw` and makes the arm follow it on the moving ship.
///
/// The arm takes velocities, which the robot computer integrates to a set point that the joints follow with a
/// lag. So the wanted joints q_d(t) are found by inverse kinematics on the ship's predicted motion, the lag
/// is inverted (s_d = q_d + 2ζ/ω q̇_d + q̈_d/ω², one servo delay ahead, with each joint's identified ω), and
/// the velocity is what carries s_d over the coming hold, plus a slow pull of the observed set point to s_d.
///
/// A posture out of reach gives no wish.
class LoadKeeper final : public Keeper {
 public:
  explicit LoadKeeper(const LoadKeeperConfig& config);

  void sent(LabTime t, const topic::ArmCommand& command) override;
  /// While not engaged it keeps the software tool point at the real one.
  [[nodiscard]] std::optional<Wish> step(const KeeperInputs& inputs) override;
  [[nodiscard]] const Eigen::Vector3d& servo_omega_radps() const override { return observer_.omega_radps(); }

 private:
  using Vector3d = Eigen::Vector3d;

  /// The joints that put the tool where the software tool point will be, `ahead_s` after the inputs' time.
  [[nodiscard]] std::optional<Vector3d> wanted_joints(const math::BodyMotion& ship, double ahead_s) const;

  LoadKeeperConfig config_;
  math::CraneArm arm_;
  LoadLaw law_;
  SmoothPoint reference_;
  CarriedPlace carried_;
  SetPointObserver observer_;
  std::uint64_t arm_seen_ = 0;
  std::optional<LabTime> stepped_;
  bool running_ = false;
};

}  // namespace motionlab::controller
