#include "gateway/controller/thesis_keeper.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace motionlab::controller {
namespace {

/// Nearer to a stretched or folded arm than this its accelerations mean nothing.
constexpr double kLeastDeterminant = 1e-3;

Eigen::Vector3d crane_joints(const std::array<double, 6>& a) {
  return {a[0], a[1], a[2]};
}

}  // namespace

ThesisKeeper::ThesisKeeper(const ThesisKeeperConfig& config)
    : config_(config),
      arm_(config.arm),
      law_(thesis_motion_integral(ThesisWeights::code, config.X_WN.R * config.X_BR.R)),
      observer_(config.servo, config.observer_gain_per_s) {}

void ThesisKeeper::sent(LabTime t, const topic::ArmCommand& command) {
  qd_sent_ = command.follow ? crane_joints(command.qd_wanted_radps) : Eigen::Vector3d::Zero();
  observer_.sent(t + from_seconds(config_.command_latency_s), command.follow,
                 crane_joints(command.qd_wanted_radps));
}

std::optional<Wish> ThesisKeeper::step(const KeeperInputs& in) {
  if (in.arm.sequence_number != arm_seen_) {
    arm_seen_ = in.arm.sequence_number;
    observer_.measured(from_ns(in.arm.t_measured_ns), crane_joints(in.arm.q_rad),
                       crane_joints(in.arm.qd_radps));
  }
  const double dt = stepped_ ? std::clamp(seconds(in.t - *stepped_), 0.0, 0.05) : 0.0;
  stepped_ = in.t;
  const Eigen::Vector3d q = observer_.at(in.t);
  if (!in.engaged || !running_) {
    p_RT_home_ = arm_.position(q);
    memory_.setZero();
    running_ = in.engaged;
    return Wish{};
  }
  const Eigen::Matrix3d J = arm_.jacobian(q);
  if (std::abs(J.determinant()) < kLeastDeterminant) return std::nullopt;
  ThesisLoadIntegral::State x;
  x << arm_.position(q) - p_RT_home_, J * qd_sent_, in.estimate.swing_rad[0], in.estimate.swing_rad[1],
      in.estimate.swing_rate_radps[0], in.estimate.swing_rate_radps[1];
  const Eigen::Vector3d home = Eigen::Vector3d::Zero();
  const Eigen::Vector3d a = law_.command(x, memory_, home);
  memory_ += dt * law_.memory_rate(x, memory_, home);
  const Eigen::Vector3d qdd = J.inverse() * (a - arm_.jacobian_dot(q, qd_sent_) * qd_sent_);
  const Eigen::Vector3d qd = qd_sent_ + config_.command_period_s * qdd;
  Wish wish;
  for (std::size_t i = 0; i < 3; ++i) wish.qd_radps[i] = qd[static_cast<Eigen::Index>(i)];
  return wish;
}

}  // namespace motionlab::controller
