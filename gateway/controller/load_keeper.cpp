#include "gateway/controller/load_keeper.hpp"

#include <algorithm>
#include <array>

namespace motionlab::controller {
namespace {

Eigen::Vector3d vector(const std::array<double, 3>& a) {
  return Eigen::Map<const Eigen::Vector3d>(a.data());
}
Eigen::Vector3d crane_joints(const std::array<double, 6>& a) {
  return {a[0], a[1], a[2]};
}

math::BodyMotion second_ship_of(const topic::Estimate& e) {
  return {math::RigidTransform::from_quaternion(Eigen::Map<const Eigen::Vector4d>(e.q_world_second.data()),
                                                vector(e.p_world_second_m)),
          vector(e.v_world_second_mps), vector(e.a_world_second_mps2), vector(e.omega_world_second_radps),
          vector(e.alpha_world_second_radps2)};
}
math::BodyMotion ship_of(const topic::Estimate& e) {
  return {math::RigidTransform::from_quaternion(Eigen::Map<const Eigen::Vector4d>(e.q_world_platform.data()),
                                                vector(e.p_world_platform_m)),
          vector(e.v_world_platform_mps), vector(e.a_world_platform_mps2),
          vector(e.omega_world_platform_radps), vector(e.alpha_world_platform_radps2)};
}

}  // namespace

LoadKeeper::LoadKeeper(const LoadKeeperConfig& config)
    : config_(config),
      arm_(config.arm),
      law_(config.law),
      reference_(config.reference),
      carried_(config.X_WN_second),
      observer_(config.servo, config.observer_gain_per_s, config.identifier) {}

void LoadKeeper::sent(LabTime t, const topic::ArmCommand& command) {
  observer_.sent(t + from_seconds(config_.command_latency_s), command.follow,
                 crane_joints(command.qd_wanted_radps));
}

std::optional<Eigen::Vector3d> LoadKeeper::wanted_joints(const math::BodyMotion& ship, double ahead) const {
  const Vector3d p_WT = law_.p_WT() + ahead * law_.v_WT() + 0.5 * ahead * ahead * law_.a_WT();
  const math::RigidTransform X_WR = ship.after(ahead).X_WB * config_.X_BR;
  return arm_.inverse(X_WR.inverse() * p_WT);
}

std::optional<Wish> LoadKeeper::step(const KeeperInputs& in) {
  if (in.arm.sequence_number != arm_seen_) {
    arm_seen_ = in.arm.sequence_number;
    observer_.measured(from_ns(in.arm.t_measured_ns), crane_joints(in.arm.q_rad),
                       crane_joints(in.arm.qd_radps));
  }
  const double dt = stepped_ ? std::clamp(seconds(in.t - *stepped_), 0.0, 0.05) : 0.0;
  stepped_ = in.t;
  const topic::Estimate& e = in.estimate;
  if (!in.engaged || !running_) {
    law_.start(vector(e.p_world_tool_m), vector(e.v_world_tool_mps), in.reference.p_WL.z() + e.wire_length_m);
    reference_.reset(in.reference.p_WL);
    carried_.reset();
    running_ = in.engaged;
    return Wish{};
  }
  const math::BodyMotion ship = ship_of(e);
  const Vector3d p_BT = ship.X_WB.inverse() * law_.p_WT();
  if (dt > 0) reference_.step(dt, in.reference.p_WL, in.reference.v_WL);
  math::PointMotion place{reference_.p(), reference_.v(), reference_.a()};
  carried_.step(dt, in.reference.on_second_ship && e.second_valid);
  if (e.second_valid) place = carried_.motion(place, second_ship_of(e));
  law_.step(dt, {.reference = place,
                 .p_WL = vector(e.p_world_load_m),
                 .v_WL = vector(e.v_world_load_mps),
                 .wire_length_m = e.wire_length_m,
                 .share = in.horizontal_share,
                 .v_ship = math::carried(ship, {p_BT, Vector3d::Zero(), Vector3d::Zero()}).v});

  // Wanted joints at four times one hold apart; the middle two are when the coming hold begins and ends to
  // act.
  const double T = config_.command_period_s;
  const double begin = seconds(in.t_send - in.t) + config_.command_latency_s + config_.servo.delay_s;
  std::array<Vector3d, 4> q;
  for (std::size_t i = 0; i < q.size(); ++i) {
    const auto joints = wanted_joints(ship, begin + (static_cast<double>(i) - 1.0) * T);
    if (!joints) return std::nullopt;
    q[i] = *joints;
  }
  const Vector3d w = observer_.omega_radps();
  const double zeta = config_.servo.zeta;
  const auto set_point = [&](std::size_t i) -> Vector3d {
    const Vector3d qd = (q[i + 1] - q[i - 1]) / (2 * T);
    const Vector3d qdd = (q[i + 1] - 2 * q[i] + q[i - 1]) / (T * T);
    return q[i] + (2 * zeta * qd + qdd.cwiseQuotient(w)).cwiseQuotient(w);
  };
  const Vector3d s_begin = set_point(1), s_end = set_point(2);
  const Vector3d observed = observer_.at(in.t_send + from_seconds(config_.command_latency_s));
  const Vector3d qd = (s_end - s_begin) / T + config_.set_point_gain_per_s * (s_begin - observed);

  Wish wish;
  for (std::size_t i = 0; i < 3; ++i) wish.qd_radps[i] = qd[static_cast<Eigen::Index>(i)];
  // The winch carries a moving place, its lag inverted, and takes out what height error is left.
  const double too_high = e.p_world_load_m[2] - place.p.z();
  const double trim = std::clamp(config_.height_gain_per_s * too_high, -config_.height_speed_max_mps,
                                 config_.height_speed_max_mps);
  const double lead = 2 * config_.winch.zeta / config_.winch.omega_radps + config_.winch.delay_s;
  wish.wire_speed_mps = trim - (place.v.z() + lead * place.a.z());
  return wish;
}

}  // namespace motionlab::controller
