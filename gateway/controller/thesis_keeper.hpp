/// @file  The thesis' integral controller on the real line: the baseline that ours is measured against.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "gateway/controller/keeper.hpp"
#include "gateway/controller/set_point_observer.hpp"
#include "gateway/controller/thesis_laws.hpp"
#include "gateway/math/crane_arm.hpp"
#include "gateway/math/rotation.hpp"

namespace motionlab::controller {

struct ThesisKeeperConfig {
  math::CraneArmGeometry arm;
  math::RigidTransform X_WN;  ///< platform at neutral
  math::RigidTransform X_BR;  ///< robot base in platform body
  ServoBelief servo;
  double command_period_s = 0.005;
  double command_latency_s = 0.0005;
  double observer_gain_per_s = 10.0;
};

/// State feedback with integral on tool position in the robot's axes and swing angles in world (Sec 4.6.3,
/// the weights of its code), resolved to joint accelerations (Eq 3.31) and these added to the joint
/// velocities.
///
/// As in the thesis the arm does what it is told: position and velocity of the tool point are those of the
/// robot's set point, for fed back through the servos' lag the loop is unstable below 5 Hz. The tool is
/// brought to where it is when engaged; reference and ship motion are not its business, nor is the winch.
class ThesisKeeper final : public Keeper {
 public:
  explicit ThesisKeeper(const ThesisKeeperConfig& config);

  void sent(LabTime t, const topic::ArmCommand& command) override;
  [[nodiscard]] std::optional<Wish> step(const KeeperInputs& inputs) override;
  [[nodiscard]] const Eigen::Vector3d& servo_omega_radps() const override { return observer_.omega_radps(); }

 private:
  ThesisKeeperConfig config_;
  math::CraneArm arm_;
  ThesisLoadIntegral law_;
  ThesisLoadIntegral::Memory memory_ = ThesisLoadIntegral::Memory::Zero();
  SetPointObserver observer_;
  Eigen::Vector3d p_RT_home_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d qd_sent_ = Eigen::Vector3d::Zero();
  std::optional<LabTime> stepped_;
  std::uint64_t arm_seen_ = 0;
  bool running_ = false;
};

}  // namespace motionlab::controller
