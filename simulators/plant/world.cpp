#include "simulators/plant/world.hpp"

#include <algorithm>

namespace motionlab::plant {

using Eigen::Vector3d;

namespace {

/// Two ships meet other waves of the same sea.
constexpr std::uint64_t kSecondSea = 1'000'003;
constexpr double kTick_s = seconds(World::kTick);

ArmServoConfig slowed(ArmServoConfig arm, double factor) {
  for (double& omega : arm.omega_radps) omega *= factor;
  return arm;
}

Vector3d crane_joints(const Joints& q) {
  return {q[0], q[1], q[2]};
}

/// Cubic through values and slopes at both ends of an interval h, at the share x of it; value and slope.
template <class T>
struct Cubic {
  T value;
  T slope;
};

template <class T>
Cubic<T> cubic(const T& p0, const T& v0, const T& p1, const T& v1, double h, double x) {
  const T d = p1 - p0;
  const T c2 = 3 * d - h * (2 * v0 + v1), c3 = -2 * d + h * (v0 + v1);
  return {T(p0 + x * (h * v0 + x * (c2 + x * c3))), T(v0 + x / h * (2 * c2 + 3 * x * c3))};
}

}  // namespace

WorldConfig WorldConfig::as_believed() const {
  WorldConfig c = *this;
  c.differences = Differences::none();
  c.load.wire_ea_n *= 10;  // 0.12 mm of stretch, still easily integrated
  c.load.rigid_body = false;
  c.arm_mode = ArmMode::rigid();
  c.mru1 = c.mru1.with_white_noise_only();
  c.mru2 = c.mru2.with_white_noise_only();
  c.camera.correlated_rms_m = 0;
  return c;
}

WorldConfig WorldConfig::with_perfect_sensors() const {
  WorldConfig c = *this;
  c.mru1 = c.mru1.without_errors();
  c.mru2 = c.mru2.without_errors();
  c.camera = c.camera.without_errors();
  c.encoder = EncoderConfig::perfect();
  return c;
}

World::World(const WorldConfig& config, const Scenario& scenario, std::uint64_t seed, LabTime start)
    : config_(config),
      seed_(seed),
      ship_starts_(start + from_seconds(scenario.delay_s)),
      calibration_(disturbed(config.calibration, config.differences.calibration_offset_m,
                             config.differences.calibration_angle_rad, seed)),
      ship_(scenario, seed),
      second_ship_(config.second_ship, seed + kSecondSea),
      geometry_(config.arm_geometry),
      load_(config.load, config.arm_mode),
      arm_(slowed(config.arm, config.differences.joint_bandwidth_factor), config.home_rad, kTick_s),
      winch_(config.winch, config.start_wire_length_m, kTick_s),
      joint_set_points_(config.home_rad),
      wire_set_point_(config.start_wire_length_m),
      extra_wire_m_(config.differences.wire_extra_m),
      p_RT_home_(geometry_.position(crane_joints(config.home_rad))),
      sag_R_((calibration_.world_to_em8000.R * calibration_.em8000_to_comau.R).transpose() *
             (-config.arm_mode.own_sag_m(config.load.gravity_mps2) * Vector3d::UnitZ())) {
  end_.t = start;
  end_.q = arm_.q_rad();
  end_.qd = arm_.qd_radps();
  end_.length = winch_.length_m();
  end_.length_rate = winch_.speed_mps();
  hang(end_, platform_at(start));
  end_.load = load_.at_rest(end_.crane.p_WT, end_.crane.free_length_m);
  end_.twin_load = load_.at_rest(end_.twin.p_WT, end_.twin.free_length_m);
  begin_ = end_;
}

PlatformState World::platform_at(LabTime t) {
  return platform_state(calibration_.world_to_em8000, ship_.at(seconds(t - ship_starts_)));
}

void World::advance(LabTime t) {
  while (end_.t + kTick <= t) tick();
}

/// Where the posture puts the tool. The calibration holds on the neutral ship; the arm's own sag keeps
/// hanging down while the ship turns.
PointMotion World::posture_point(const PlatformState& platform, const Vector3d& p_RT, const Vector3d& v_BT,
                                 const Vector3d& a_BT) const {
  PointMotion tool = point_of(platform, calibration_.em8000_to_comau * (p_RT - sag_R_), v_BT, a_BT);
  tool.p_W.z() -= config_.arm_mode.own_sag_m(config_.load.gravity_mps2);
  return tool;
}

void World::hang(Knot& knot, const PlatformState& platform) const {
  const Vector3d q = crane_joints(knot.q);
  const Vector3d v_BT = calibration_.em8000_to_comau.R * (geometry_.jacobian(q) * crane_joints(knot.qd));
  const PointMotion tool = posture_point(platform, geometry_.position(q), v_BT, Vector3d::Zero());
  const PointMotion twin_tool = posture_point(platform, p_RT_home_, Vector3d::Zero(), Vector3d::Zero());
  knot.crane = {tool.p_W, tool.v_W, knot.length + extra_wire_m_, knot.length_rate};
  knot.twin = {twin_tool.p_W, twin_tool.v_W, config_.start_wire_length_m + extra_wire_m_, 0};
}

void World::tick() {
  begin_ = end_;
  end_.t += kTick;
  arm_.step(joint_set_points_);
  winch_.step(wire_set_point_);
  end_.q = arm_.q_rad();
  end_.qd = arm_.qd_radps();
  end_.length = winch_.length_m();
  end_.length_rate = winch_.speed_mps();
  hang(end_, platform_at(end_.t));
  end_.load = load_.step(begin_.load, begin_.crane, end_.crane, kTick_s, push_n_);
  end_.twin_load = load_.step(begin_.twin_load, begin_.twin, end_.twin, kTick_s, push_n_);
}

HangingState World::hanging(const PointMotion& posture, double free_length, double rate,
                            const LoadState& load) const {
  const Suspension at{posture.p_W, posture.v_W, free_length, rate};
  const LoadRates rates = load_.rates(load, at, posture.a_W, push_n_);
  const PointMotion tool{posture.p_W + load.tip_m, posture.v_W + load.tip_mps, posture.a_W + rates.tip_mps};
  const Eigen::Vector2d swing = swing_angles_rad(tool.p_W, load.p_WL);
  return {tool,
          load.p_WL,
          load.v_WL,
          swing,
          config_.load.rigid_body ? tilt_angles_rad(load) : swing,
          free_length,
          rate,
          load_.tension_n(load, at)};
}

WorldState World::sample(LabTime wanted) {
  const LabTime t = std::clamp(wanted, begin_.t, end_.t);
  const double x = begin_.t == end_.t ? 1.0 : seconds(t - begin_.t) / kTick_s;
  WorldState s;
  s.t = t;
  s.platform = platform_at(t);
  s.second = platform_state(calibration_.world_to_em1500, second_ship_.at(seconds(t - ship_starts_)));
  s.qdd_radps2 = arm_.qdd_radps2();
  for (std::size_t j = 0; j < s.q_rad.size(); ++j) {
    const auto c = cubic(begin_.q[j], begin_.qd[j], end_.q[j], end_.qd[j], kTick_s, x);
    s.q_rad[j] = c.value;
    s.qd_radps[j] = c.slope;
  }
  const auto wire = cubic(begin_.length, begin_.length_rate, end_.length, end_.length_rate, kTick_s, x);
  s.winch_length_m = wire.value;
  s.winch_speed_mps = wire.slope;

  const auto between = [&](const LoadState& b, const LoadState& e) {
    const auto centre = cubic(b.p_WL, b.v_WL, e.p_WL, e.v_WL, kTick_s, x);
    const auto tip = cubic(b.tip_m, b.tip_mps, e.tip_m, e.tip_mps, kTick_s, x);
    return LoadState{centre.value,
                     centre.slope,
                     Vector3d((1 - x) * b.up + x * e.up).normalized(),
                     (1 - x) * b.omega_radps + x * e.omega_radps,
                     tip.value,
                     tip.slope};
  };
  const Vector3d q = crane_joints(s.q_rad), qd = crane_joints(s.qd_radps), qdd = crane_joints(s.qdd_radps2);
  const math::RigidTransform& X_BR = calibration_.em8000_to_comau;
  const Eigen::Matrix3d J = geometry_.jacobian(q);
  const PointMotion posture = posture_point(s.platform, geometry_.position(q), X_BR.R * (J * qd),
                                            X_BR.R * (J * qdd + geometry_.jacobian_dot(q, qd) * qd));
  s.crane = hanging(posture, wire.value + extra_wire_m_, wire.slope, between(begin_.load, end_.load));
  s.twin = hanging(posture_point(s.platform, p_RT_home_, Vector3d::Zero(), Vector3d::Zero()),
                   config_.start_wire_length_m + extra_wire_m_, 0, between(begin_.twin_load, end_.twin_load));
  s.winch_torque_nm = winch_.torque_nm(s.crane.tension_n);
  return s;
}

}  // namespace motionlab::plant
