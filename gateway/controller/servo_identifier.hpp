/// @file  How fast the joints' servos really are, learnt from what was sent and what the encoders say.
#pragma once

#include <Eigen/Core>

#include "gateway/controller/servo_belief.hpp"

namespace motionlab::controller {

struct ServoIdentifierConfig {
  double memory_s = 30.0;  ///< what was seen so long ago counts for 1/e; 0: believe, learn nothing
  /// How much motion it takes to move the belief: ∫ψ² of the sensitivity ψ = ∂q/∂ω. With joints that turn at
  /// 0.2 rad/s half of an error is gone after about ten seconds, ten times slower with a third of the motion.
  double caution = 4e-7;
  double washout_s = 10.0;   ///< slower differences are a set point that is not where it is thought to be
  double most_factor = 1.6;  ///< the farthest from the belief, up and (its inverse) down
};

/// Identifies ω of each crane joint's servo (see ServoBelief; ζ and the delay are believed) by recursive
/// prediction errors: a model runs beside the servo on the same velocities, its difference from the encoders
/// and its sensitivity to ω pass the same washout, and ω goes where the difference shrinks, with a
/// forgetting factor. A set point offset or a lost datagram is slow or rare and does not pass.
///
/// The servo's lag decides how still the load can be kept: 10 % of it costs millimetres.
class ServoIdentifier {
 public:
  using Vector3d = Eigen::Vector3d;

  explicit ServoIdentifier(const ServoBelief& servo, const ServoIdentifierConfig& config = {});

  /// The servos stand where the encoders say and move like this; what was learnt stays.
  void restart(const Vector3d& q_rad, const Vector3d& qd_radps);
  /// The set point moved by so much within dt. Steps of a millisecond or less. @pre after `restart`
  void advance(const Vector3d& moved_rad, double dt_s);
  /// The encoders' word for the time that was advanced to, `span_s` after the last one.
  void measured(const Vector3d& q_rad, double span_s);

  /// What the servos' ω are now taken for; the belief before anything was learnt.
  [[nodiscard]] const Vector3d& omega_radps() const { return omega_; }

 private:
  double belief_;
  double zeta_;
  ServoIdentifierConfig config_;
  Vector3d omega_;
  Vector3d information_;                ///< ∫ψ² with forgetting
  Vector3d lag_ = Vector3d::Zero();     ///< set point − modelled joint
  Vector3d qd_ = Vector3d::Zero();      ///< of the modelled joint
  Vector3d q_ = Vector3d::Zero();       ///< likewise
  Vector3d lag_by_ = Vector3d::Zero();  ///< ∂lag/∂ω = −∂q/∂ω
  Vector3d qd_by_ = Vector3d::Zero();   ///< ∂q̇/∂ω
  Vector3d slow_error_ = Vector3d::Zero();
  Vector3d slow_by_ = Vector3d::Zero();
};

}  // namespace motionlab::controller
