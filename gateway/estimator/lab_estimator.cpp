#include "gateway/estimator/lab_estimator.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "gateway/estimator/sane.hpp"

namespace motionlab::estimator {
namespace {

using Eigen::Vector2d;
using math::Matrix3d;
using math::SparseRow;

Eigen::Vector3d vector(const std::array<double, 3>& a) {
  return Eigen::Map<const Eigen::Vector3d>(a.data());
}

template <class Vector, std::size_t N>
void copy_to(std::array<double, N>& to, const Vector& from) {
  for (std::size_t i = 0; i < N; ++i) to[i] = from[static_cast<Eigen::Index>(i)];
}

/// A body that was not seen for this long is no longer called tracked.
constexpr Nanoseconds kSeenFor = 100ms;
/// A measurement this much older than the filter's state is still used, as if it were of that time.
constexpr Nanoseconds kLateTolerance = 3ms;
/// Longest step of the covariance prediction; longer gaps are crossed in several.
constexpr double kLongestStep = 0.01;
/// When nothing at all was heard for this long, the filter goes on alone, so that its deviations tell.
constexpr Nanoseconds kAloneAfter = 50ms;
/// A jump of time longer than this is not crossed: everything begins anew.
constexpr Nanoseconds kLongestGap = 2s;
/// Stamps further from the present than this are wrong, not early or late.
constexpr Nanoseconds kAheadTolerance = 10ms;
constexpr Nanoseconds kOldest = 10s;
/// A wire outside of these is no pendulum.
constexpr double kShortestWire = 0.1, kLongestWire = 100.0;
/// So many sightings of the load refused in a row say that the state is wrong, not they.
constexpr int kRefusalsToReplace = 40;

using estimator::sane;  // beside those that follow
bool sane(const topic::ArmState& arm) {
  return sane(arm.q_rad) && sane(arm.qd_radps);
}
bool sane(const topic::WinchState& winch) {
  return winch.wire_length_m >= kShortestWire && winch.wire_length_m <= kLongestWire &&
         std::abs(winch.wire_speed_mps) <= kLargest;
}
/// Of a point only the place counts; the pose of a lost body means nothing.
bool sane_point(const topic::Bodies& body) {
  return !body.tracked || sane(body.p_camera_body_m);
}
bool sane_pose(const topic::Bodies& body) {
  const double norm = Eigen::Map<const Eigen::Vector4d>(body.q_camera_body.data()).norm();
  return !body.tracked || (sane(body.p_camera_body_m) && std::abs(norm - 1) < 0.01);
}

}  // namespace

LabEstimator::LabEstimator(const Belief& belief)
    : belief_(belief),
      mount_(belief.calibration.mount()),
      second_(belief.calibration.second, belief.second_ship, belief.mru, belief.load.gravity_mps2),
      axis_model_(belief.ship.period_s, belief.ship.damping),
      R_WD_(level_frame(belief.calibration.X_WN.R)) {
  begin();
}

void LabEstimator::begin() {
  filter_ = Filter{};
  started_ = winch_heard_ = mru_heard_ = load_tracked_ = platform_tracked_ = false;
  arm_ = ArmHistory{};
  pending_ = {};
  load_refusals_ = 0;
  for (int i = 0; i < kAxes; ++i) {
    const double sd = i < 3 ? belief_.ship.translation_sd_m : belief_.ship.rotation_sd_rad;
    const double density = sd * sd / axis_model_.stationary()(0, 0);
    noise_density_[static_cast<std::size_t>(i)] = density;
    filter_.P.block<4, 4>(axis(i), axis(i)) = density * axis_model_.stationary();
  }
  const auto set_sd = [this](int first, int count, double sd) {
    for (int i = first; i < first + count; ++i) filter_.P(i, i) = sd * sd;
  };
  set_sd(kAccelerationBias, 3, belief_.mru.acceleration_bias_sd_mps2);
  set_sd(kRateBias, 3, belief_.mru.rate_bias_sd_radps);
  set_sd(kTiltError, 2, belief_.mru.tilt_error_sd_rad);
  set_sd(kYawError, 1, belief_.mru.yaw_start_sd_rad);
  set_sd(kToolOffset, 3, belief_.load.tool_offset_sd_m);
}

topic::Estimate LabEstimator::step(const Inputs& inputs) {
  if (std::chrono::abs(inputs.t - now_) > kLongestGap) begin();
  now_ = inputs.t;
  collect(inputs);
  second_.step(inputs.t, inputs.second_mru);
  const LabTime due = inputs.t - from_seconds(belief_.fusion_delay_s);
  for (;;) {
    Pending* earliest = nullptr;
    for (auto& pending : pending_) {
      if (pending.kind == Pending::Kind::none || pending.t > due) continue;
      // Of two at the same time the kind decides, so that the order of arrival never does.
      if (earliest == nullptr || std::tie(pending.t, pending.kind) < std::tie(earliest->t, earliest->kind)) {
        earliest = &pending;
      }
    }
    if (earliest == nullptr) break;
    process(*earliest);
    earliest->kind = Pending::Kind::none;
  }
  if (started_ && due - t_ > kAloneAfter) predict_to(due - kAloneAfter);
  return estimate_at(inputs.t);
}

void LabEstimator::collect(const Inputs& inputs) {
  const auto is_new = [](const auto& sample, std::uint64_t& seen) {
    if (!sample || sample->sequence_number == seen) return false;
    seen = sample->sequence_number;
    return true;
  };
  const auto usable = [&](const auto& sample, bool is_sane) {
    const LabTime t = from_ns(sample.t_measured_ns);
    const bool in_time = t <= inputs.t + kAheadTolerance && t >= inputs.t - kOldest;
    if (!is_sane || !in_time) ++refused_;
    return is_sane && in_time;
  };
  if (is_new(inputs.arm, arm_sequence_) && usable(*inputs.arm, sane(*inputs.arm))) {
    const auto& a = *inputs.arm;
    arm_.add(from_ns(a.t_measured_ns), {a.q_rad[0], a.q_rad[1], a.q_rad[2]},
             {a.qd_radps[0], a.qd_radps[1], a.qd_radps[2]});
  }
  if (is_new(inputs.winch, winch_sequence_) && usable(*inputs.winch, sane(*inputs.winch))) {
    wire_length_m_ = inputs.winch->wire_length_m;
    wire_speed_mps_ = inputs.winch->wire_speed_mps;
    wire_t_ = from_ns(inputs.winch->t_measured_ns);
    winch_heard_ = true;
  }
  if (is_new(inputs.mru, mru_seen_) && usable(*inputs.mru, sane(*inputs.mru))) {
    enqueue({Pending::Kind::mru, from_ns(inputs.mru->t_measured_ns), *inputs.mru, {}});
    mru_heard_ = true;
  }
  if (is_new(inputs.load, load_sequence_) && usable(*inputs.load, sane_point(*inputs.load))) {
    enqueue({Pending::Kind::load, from_ns(inputs.load->t_measured_ns), {}, *inputs.load});
  }
  if (belief_.use_platform_body && is_new(inputs.platform, platform_sequence_) &&
      usable(*inputs.platform, sane_pose(*inputs.platform))) {
    enqueue({Pending::Kind::platform, from_ns(inputs.platform->t_measured_ns), {}, *inputs.platform});
  }
}

void LabEstimator::enqueue(Pending&& pending) {
  for (auto& slot : pending_) {
    if (slot.kind != Pending::Kind::none) continue;
    slot = std::move(pending);
    return;
  }
  ++refused_;
}

void LabEstimator::process(const Pending& pending) {
  if (pending.kind == Pending::Kind::load) load_tracked_ = pending.body.tracked;
  if (pending.kind == Pending::Kind::platform) platform_tracked_ = pending.body.tracked;
  if (pending.kind != Pending::Kind::mru && !pending.body.tracked) return;
  if (!started_) {
    start(pending);
    return;
  }
  if (pending.t < t_ - kLateTolerance) {
    ++refused_;
    return;
  }
  predict_to(pending.t);
  if (pending.kind == Pending::Kind::mru) take(pending.mru);
  if (pending.kind == Pending::Kind::load) take_load(pending.body);
  if (pending.kind == Pending::Kind::platform) take_platform(pending.body);
}

void LabEstimator::start(const Pending& pending) {
  // The load's place is the one thing that has no prior: the filter starts when it is first seen.
  if (pending.kind != Pending::Kind::load || arm_.empty() || !winch_heard_ || !mru_heard_) return;
  t_ = pending.t;
  load_seen_ = t_;
  place_load(belief_.calibration.X_WQ * vector(pending.body.p_camera_body_m));
  started_ = true;
}

void LabEstimator::place_load(const Vector3d& p_WL) {
  filter_.x.segment<2>(kLoad) = p_WL.head<2>();
  filter_.x.segment<2>(kLoadVelocity).setZero();
  filter_.P.middleCols<4>(kLoad).setZero();
  filter_.P.middleRows<4>(kLoad).setZero();
  for (int k = 0; k < 2; ++k) {
    filter_.P(kLoad + k, kLoad + k) = 0.05 * 0.05;
    filter_.P(kLoadVelocity + k, kLoadVelocity + k) = 1.0;
  }
  load_refusals_ = 0;
}

LabEstimator::Tool LabEstimator::tool(const math::BodyMotion& ship, const JointMotion& joints) const {
  const math::CraneArm arm(belief_.calibration.arm);
  const auto& X_BR = belief_.calibration.X_BR;
  const Matrix3d J = arm.jacobian(joints.q);
  const math::PointMotion in_B{X_BR * arm.position(joints.q), X_BR.R * (J * joints.qd),
                               X_BR.R * (J * joints.qdd + arm.jacobian_dot(joints.q, joints.qd) * joints.qd)};
  Tool tool;
  tool.motion = math::carried(ship, in_B);
  tool.motion.p += filter_.x.segment<3>(kToolOffset);
  tool.p_BT = in_B.p;
  // A turn by d(rpy) is a body rotation T d(rpy), which moves the point by R hat(T d(rpy)) p.
  tool.d_euler = -ship.X_WB.R * math::hat(in_B.p) * math::euler_zyx_rates_to_body(triple(0, 3));
  return tool;
}

double LabEstimator::hanging_height(const Vector2d& load, const Vector3d& p_WT) const {
  const double reach2 = (load - p_WT.head<2>()).squaredNorm();
  // A load further out than half the wire is no pendulum any more; the floor keeps the filter finite.
  const double floor = 0.5 * wire_length_m_;
  return std::sqrt(std::max(wire_length_m_ * wire_length_m_ - reach2, floor * floor));
}

double LabEstimator::stiffness(const Vector2d& load, const Vector2d& velocity,
                               const math::PointMotion& tool) const {
  // The pull that keeps the wire's length: the second derivative of |p_WL − p_WT|² = L².
  const double g = belief_.load.gravity_mps2;
  const double h = hanging_height(load, tool.p);
  const Vector2d d = load - tool.p.head<2>(), d_dot = velocity - tool.v.head<2>();
  const double h_dot = (wire_length_m_ * wire_speed_mps_ - d.dot(d_dot)) / h;
  const double bent = d_dot.squaredNorm() + h_dot * h_dot - wire_speed_mps_ * wire_speed_mps_;
  const double pull = (h * (g + tool.a.z()) - d.dot(tool.a.head<2>()) + bent) / (d.squaredNorm() + h * h);
  // The wire cannot push, and a pull beyond twice the weight is a fault of the joint speeds.
  return std::clamp(pull, 0.0, 2 * g / h);
}

void LabEstimator::add_tool_terms(SparseRow& row, const Tool& tool, const Vector3d& weight) const {
  const Vector3d on_euler = tool.d_euler.transpose() * weight;
  for (int i = 0; i < 3; ++i) {
    row.add(axis(i), weight[i]);
    row.add(axis(3 + i), on_euler[i]);
    row.add(kToolOffset + i, weight[i]);
  }
}

void LabEstimator::predict_to(LabTime t) {
  double left = seconds(t - t_);
  if (left <= 0) return;
  while (left > 0) {
    const double dt = std::min(left, kLongestStep);
    predict(dt);
    t_ += from_seconds(dt);
    left -= dt;
  }
  t_ = t;
}

void LabEstimator::predict(double dt) {
  const Eigen::Matrix4d A = axis_model_.transition(dt);
  const Eigen::Matrix4d Q = ShipAxis::noise(dt);
  const auto decay = [dt](double correlation_s) { return std::exp(-dt / correlation_s); };
  const double tilt_decay = decay(belief_.mru.tilt_error_correlation_s);
  const double offset_decay = decay(belief_.load.tool_offset_correlation_s);

  // The load: pulled towards the tool, with the tool's place taken in the middle of the step.
  const Tool before = tool(ship(), arm_.at(t_));
  const Vector2d load = filter_.x.segment<2>(kLoad), velocity = filter_.x.segment<2>(kLoadVelocity);
  const double stiff = stiffness(load, velocity, before.motion);
  const Vector2d middle =
      load + 0.5 * dt * velocity - (before.motion.p + 0.5 * dt * before.motion.v).head<2>();
  const Vector2d acceleration = -stiff * middle;

  for (int i = 0; i < kAxes; ++i) filter_.x.segment<4>(axis(i)) = A * filter_.x.segment<4>(axis(i)).eval();
  filter_.x.segment<2>(kTiltError) *= tilt_decay;
  filter_.x.segment<3>(kToolOffset) *= offset_decay;
  filter_.x.segment<2>(kLoad) += dt * velocity + 0.5 * dt * dt * acceleration;
  filter_.x.segment<2>(kLoadVelocity) += dt * acceleration;

  // P ← F P Fᵀ as two passes of column operations, since F is nearly block-diagonal.
  const auto times_F_transposed = [&](Filter::Matrix& M) {
    for (int k = 0; k < 2; ++k) {
      auto load_column = M.col(kLoad + k);
      auto velocity_column = M.col(kLoadVelocity + k);
      auto& pull = before.d_euler;
      load_column += dt * velocity_column;
      velocity_column -= dt * stiff * load_column;
      velocity_column += dt * stiff * (M.col(axis(k)) + M.col(kToolOffset + k));
      for (int j = 0; j < 3; ++j) velocity_column += dt * stiff * pull(k, j) * M.col(axis(3 + j));
    }
    for (int i = 0; i < kAxes; ++i) {
      const Eigen::Matrix<double, kStates, 4> block = M.middleCols<4>(axis(i));
      M.middleCols<4>(axis(i)).noalias() = block * A.transpose();
    }
    M.middleCols<2>(kTiltError) *= tilt_decay;
    M.middleCols<3>(kToolOffset) *= offset_decay;
  };
  times_F_transposed(filter_.P);
  filter_.P.transposeInPlace();
  times_F_transposed(filter_.P);

  const auto add = [this](int first, int count, double variance) {
    for (int i = first; i < first + count; ++i) filter_.P(i, i) += variance;
  };
  for (int i = 0; i < kAxes; ++i) {
    filter_.P.block<4, 4>(axis(i), axis(i)) += noise_density_[static_cast<std::size_t>(i)] * Q;
  }
  const auto wander = [](double sd, double decayed) { return sd * sd * (1 - decayed * decayed); };
  add(kTiltError, 2, wander(belief_.mru.tilt_error_sd_rad, tilt_decay));
  add(kToolOffset, 3, wander(belief_.load.tool_offset_sd_m, offset_decay));
  add(kYawError, 1, belief_.mru.yaw_drift_rad_sqrt_s * belief_.mru.yaw_drift_rad_sqrt_s * dt);
  // Noise on the load: a little always, and what its swing loses to air and wire, in proportion to its speed.
  const auto square = [](double v) { return v * v; };
  const double swing_speed = (velocity - before.motion.v.head<2>()).norm();
  const double lost = 2 * belief_.load.swing_damping_doubt * std::sqrt(stiff) * swing_speed;
  add(kLoadVelocity, 2,
      dt * (square(belief_.load.acceleration_noise) +
            square(lost) * belief_.load.swing_damping_correlation_s));
}

bool LabEstimator::update(Reading kind, const SparseRow& row, double innovation, double sd) {
  const math::SparseUpdate update = filter_.update(row, innovation, sd * sd, belief_.gate_sigma);
  innovations_[static_cast<std::size_t>(kind)].add(update);
  if (!update) ++refused_;
  return update.taken;
}

void LabEstimator::take(const topic::Mru& mru) {
  if (!mru.stable) {
    ++refused_;
    return;
  }
  take_mru(mru, view(), mount_, belief_.mru, belief_.load.gravity_mps2,
           [this](Reading kind, const SparseRow& row, double innovation, double sd) {
             update(kind, row, innovation, sd);
           });
}

void LabEstimator::take_load(const topic::Bodies& body) {
  load_seen_ = t_;
  const Vector3d p_WL = belief_.calibration.X_WQ * vector(body.p_camera_body_m);
  bool taken = true;
  for (int k = 0; k < 2; ++k) {
    SparseRow row;
    row.add(kLoad + k, 1.0);
    taken &= update(Reading::load_place, row, p_WL[k] - filter_.x[kLoad + k], belief_.camera.load_sd_m);
  }
  load_refusals_ = taken ? 0 : load_refusals_ + 1;
  // Somebody pushed the load, or the first sighting was a wrong one: believe the cameras again.
  if (load_refusals_ >= kRefusalsToReplace) place_load(p_WL);
  // The load's height is that of the tool less the hanging height of a taut wire.
  const Tool tool_now = tool(ship(), arm_.at(t_));
  const Vector2d load = filter_.x.segment<2>(kLoad);
  const double height = hanging_height(load, tool_now.motion.p);
  const Vector2d slope = (load - tool_now.motion.p.head<2>()) / height;
  SparseRow row;
  add_tool_terms(row, tool_now, {-slope.x(), -slope.y(), 1.0});
  row.add(kLoad, slope.x());
  row.add(kLoad + 1, slope.y());
  update(Reading::load_height, row, p_WL.z() - (tool_now.motion.p.z() - height),
         belief_.camera.load_height_sd_m);
}

void LabEstimator::take_platform(const topic::Bodies& body) {
  platform_seen_ = t_;
  const math::RigidTransform X_QP = math::RigidTransform::from_quaternion(
      Eigen::Map<const Eigen::Vector4d>(body.q_camera_body.data()), vector(body.p_camera_body_m));
  const math::RigidTransform X_WB = belief_.calibration.X_WQ * X_QP * belief_.calibration.X_BP.inverse();
  const Vector3d offset = X_WB.p - belief_.calibration.X_WN.p;
  const Vector3d rpy = math::to_euler(R_WD_.transpose() * X_WB.R, math::EulerOrder::zyx);
  for (int i = 0; i < 3; ++i) {
    SparseRow place, turn;
    place.add(axis(i), 1.0);
    update(Reading::platform_place, place, offset[i] - filter_.x[axis(i)], belief_.camera.platform_sd_m);
    turn.add(axis(3 + i), 1.0);
    update(Reading::platform_angle, turn, wrapped(rpy[i] - filter_.x[axis(3 + i)]),
           belief_.camera.platform_sd_rad);
  }
}

void LabEstimator::tell_second(topic::Estimate& out) const {
  out.second_valid = second_.valid();
  if (!out.second_valid) return;
  const math::BodyMotion ship = second_.motion();
  copy_to(out.p_world_second_m, ship.X_WB.p);
  copy_to(out.q_world_second, ship.X_WB.quaternion_wxyz());
  copy_to(out.v_world_second_mps, ship.v_WB);
  copy_to(out.a_world_second_mps2, ship.a_WB);
  copy_to(out.omega_world_second_radps, ship.omega_B);
  copy_to(out.alpha_world_second_radps2, ship.alpha_B);
  copy_to(out.p_world_second_sd_m, second_.p_sd_m());
}

topic::Estimate LabEstimator::estimate_at(LabTime t) {
  topic::Estimate out;
  out.sequence_number = ++sequence_;
  out.t_estimated_ns = out.t_computed_ns = to_ns(t);
  out.load_tracked = load_tracked_ && t - load_seen_ < kSeenFor;
  out.platform_tracked = platform_tracked_ && t - platform_seen_ < kSeenFor;
  out.wire_length_m =
      wire_length_m_ + seconds(std::clamp(t - wire_t_, 0ns, Nanoseconds{50ms})) * wire_speed_mps_;
  out.wire_speed_mps = wire_speed_mps_;
  out.valid = started_;
  tell_second(out);
  if (!started_) return out;

  // Carry the mean to the present; what lies between is too short for the covariance to change much.
  const Filter::Vector kept = filter_.x;
  const double ahead = std::clamp(seconds(t - t_), 0.0, 0.1);
  const Tool tool_then = tool(ship(), arm_.at(t_));
  for (int i = 0; i < kAxes; ++i) {
    filter_.x.segment<4>(axis(i)) = axis_model_.propagate(filter_.x.segment<4>(axis(i)), ahead);
  }
  const math::BodyMotion ship_now = ship();
  const Tool tool_now = tool(ship_now, arm_.at(t));
  Vector2d load = filter_.x.segment<2>(kLoad), load_velocity = filter_.x.segment<2>(kLoadVelocity);
  constexpr int kSubsteps = 4;
  const double dt = ahead / kSubsteps;
  for (int i = 0; i < kSubsteps; ++i) {
    const double f = (i + 0.5) / kSubsteps;
    const auto between = [f](const Vector3d& then, const Vector3d& now) {
      return Vector3d((1 - f) * then + f * now);
    };
    const math::PointMotion motion{between(tool_then.motion.p, tool_now.motion.p),
                                   between(tool_then.motion.v, tool_now.motion.v),
                                   between(tool_then.motion.a, tool_now.motion.a)};
    const Vector2d middle = load + 0.5 * dt * load_velocity;
    const Vector2d acceleration = -stiffness(middle, load_velocity, motion) * (middle - motion.p.head<2>());
    load += dt * load_velocity + 0.5 * dt * dt * acceleration;
    load_velocity += dt * acceleration;
  }
  filter_.x = kept;

  const Vector3d& p_WT = tool_now.motion.p;
  const double height = hanging_height(load, p_WT);
  const Vector2d d = load - p_WT.head<2>(), d_dot = load_velocity - tool_now.motion.v.head<2>();
  const double height_dot = (wire_length_m_ * wire_speed_mps_ - d.dot(d_dot)) / height;
  const double L = std::hypot(d.norm(), height);

  copy_to(out.p_world_platform_m, ship_now.X_WB.p);
  copy_to(out.q_world_platform, ship_now.X_WB.quaternion_wxyz());
  copy_to(out.v_world_platform_mps, ship_now.v_WB);
  copy_to(out.a_world_platform_mps2, ship_now.a_WB);
  copy_to(out.omega_world_platform_radps, ship_now.omega_B);
  copy_to(out.alpha_world_platform_radps2, ship_now.alpha_B);
  copy_to(out.p_world_tool_m, p_WT);
  copy_to(out.v_world_tool_mps, tool_now.motion.v);
  // Thesis Eq 3.49 solved for the angles.
  const double alpha = std::asin(std::clamp(-d.x() / L, -1.0, 1.0));
  const double side2 = d.y() * d.y() + height * height;
  out.swing_rad = {alpha, std::atan2(d.y(), height)};
  out.swing_rate_radps = {-(d_dot.x() + wire_speed_mps_ * std::sin(alpha)) / (L * std::cos(alpha)),
                          (d_dot.y() * height - d.y() * height_dot) / side2};
  out.p_world_load_m = {load.x(), load.y(), p_WT.z() - height};
  out.v_world_load_mps = {load_velocity.x(), load_velocity.y(), tool_now.motion.v.z() - height_dot};
  tell_deviations(out, ship_now, tool_now);
  return out;
}

void LabEstimator::tell_deviations(topic::Estimate& out, const math::BodyMotion& ship,
                                   const Tool& tool) const {
  const SystematicDoubt& doubt = belief_.doubt;
  const auto square = [](double v) { return v * v; };
  const double frame2 = square(doubt.frame_sd_m), turn2 = square(doubt.frame_sd_rad);
  const double age2 = square(doubt.age_sd_s);
  // A frame that is turned moves what is seen in it across the line of sight.
  const auto seen_from_cameras = [&](const Vector3d& p_W, int k) {
    const Vector3d lever = p_W - belief_.calibration.X_WQ.p;
    return frame2 + turn2 * (lever.squaredNorm() - square(lever[k]));
  };
  const auto sd = [](double variance) { return std::sqrt(std::max(variance, 0.0)); };
  const auto variance = [this](int i) { return filter_.P(i, i); };
  const Vector3d v_WT_ship = math::carried(ship, {tool.p_BT, Vector3d::Zero(), Vector3d::Zero()}).v;
  const Vector3d p_WL = vector(out.p_world_load_m), v_WL = vector(out.v_world_load_mps);
  // Without its body the ship may be turned about the tool, and nobody would see.
  const double yaw2 = out.platform_tracked ? 0.0 : square(doubt.yaw_from_load_sd_rad);
  const Vector3d to_tool = tool.motion.p - ship.X_WB.p;
  const Vector3d shifted2(yaw2 * square(to_tool.y()), yaw2 * square(to_tool.x()), 0.0);
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    out.p_world_platform_sd_m[k] =
        sd(variance(axis(i)) + shifted2[i] + seen_from_cameras(ship.X_WB.p, i) + age2 * square(ship.v_WB[i]));
    // The unit's or the body's mounting on the ship, and that of the cameras.
    out.euler_platform_sd_rad[k] = sd(variance(axis(3 + i)) + (i == 2 ? yaw2 : 0.0) + 2 * turn2 +
                                      age2 * square(filter_.x[axis(3 + i, 1)]));
    SparseRow row;
    add_tool_terms(row, tool, Vector3d::Unit(i));
    double tool_variance = 0;
    for (const auto& a : row) {
      for (const auto& b : row) tool_variance += a.value * b.value * filter_.P(a.index, b.index);
    }
    const double seen = seen_from_cameras(p_WL, i);
    const double along_wire = i == 2 ? square(doubt.wire_length_sd_m) : 0.0;
    out.p_world_tool_sd_m[k] = sd(tool_variance + seen + along_wire + age2 * square(v_WT_ship[i]));
    out.p_world_load_sd_m[k] =
        sd((i < 2 ? variance(kLoad + i) : tool_variance) + seen + age2 * square(v_WL[i]));
  }
}

}  // namespace motionlab::estimator
