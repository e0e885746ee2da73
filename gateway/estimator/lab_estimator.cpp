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

double square(double v) {
  return v * v;
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
      ship_model_(belief.ship, belief.mru),
      R_WD_(level_frame(belief.calibration.X_WN.R)) {
  begin();
}

void LabEstimator::begin() {
  filter_ = Filter{};
  started_ = winch_heard_ = mru_heard_ = load_tracked_ = platform_tracked_ = false;
  arm_ = ArmHistory{};
  pending_ = {};
  load_refusals_ = 0;
  filter_.P.topLeftCorner<ShipStates::kSize, ShipStates::kSize>() = ship_model_.prior();
  filter_.P.diagonal().segment<3>(kToolOffset).setConstant(square(belief_.load.tool_offset_sd_m));
}

topic::Estimate LabEstimator::step(const Inputs& inputs) {
  if (std::chrono::abs(inputs.t - now_) > kLongestGap) begin();
  now_ = inputs.t;
  collect(inputs);
  const LabTime due = inputs.t - from_seconds(belief_.fusion_delay_s);
  const bool busy = take_due(due);
  second_.step(inputs.t, busy ? std::nullopt : inputs.second_mru);
  if (started_ && due - t_ > kAloneAfter) predict_to(due - kAloneAfter);
  return estimate_at(inputs.t);
}

bool LabEstimator::take_due(LabTime due) {
  const auto is_due = [due](const Pending& pending) {
    return pending.kind != Pending::Kind::none && pending.t <= due;
  };
  // Of two at the same time the kind decides, so that the order of arrival never does.
  const auto before = [&](const Pending& a, const Pending& b) {
    if (is_due(a) != is_due(b)) return is_due(a);
    return std::tie(a.t, a.kind) < std::tie(b.t, b.kind);
  };
  const auto waiting = std::count_if(pending_.begin(), pending_.end(), is_due);
  for (auto left = (waiting + 2) / 3; left > 0; --left) {
    Pending& earliest = *std::min_element(pending_.begin(), pending_.end(), before);
    process(earliest);
    earliest.kind = Pending::Kind::none;
  }
  return waiting > 0;
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
  const ShipModel::Step step = ship_model_.over(dt);
  const double offset_decay = std::exp(-dt / belief_.load.tool_offset_correlation_s);

  // The load: pulled towards the tool, with the tool's place taken in the middle of the step.
  const Tool before = tool(ship(), arm_.at(t_));
  const Vector2d load = filter_.x.segment<2>(kLoad), velocity = filter_.x.segment<2>(kLoadVelocity);
  const double stiff = stiffness(load, velocity, before.motion);
  const Vector2d middle =
      load + 0.5 * dt * velocity - (before.motion.p + 0.5 * dt * before.motion.v).head<2>();
  const Vector2d acceleration = -stiff * middle;

  step.carry(filter_.x);
  filter_.x.segment<2>(kLoad) += dt * velocity + 0.5 * dt * dt * acceleration;
  filter_.x.segment<2>(kLoadVelocity) += dt * acceleration;
  filter_.x.segment<3>(kToolOffset) *= offset_decay;

  // The load's columns of P Fᵀ; their own corner of F P Fᵀ; and as they stand, its rows.
  auto& P = filter_.P;
  const Eigen::Matrix<double, 2, 3> pull = dt * stiff * before.d_euler.topRows<2>();
  const auto pulled = [&](const auto& of) {
    for (int k = 0; k < 2; ++k) {
      of(kLoad + k) += dt * of(kLoadVelocity + k);
      of(kLoadVelocity + k) += dt * stiff * (of(axis(k)) + of(kToolOffset + k) - of(kLoad + k));
      for (int j = 0; j < 3; ++j) of(kLoadVelocity + k) += pull(k, j) * of(axis(3 + j));
    }
  };
  pulled([&P](int i) { return P.col(i); });
  pulled([&P](int i) { return P.block<1, 4>(i, kLoad); });
  P.middleRows<4>(kLoad) = P.middleCols<4>(kLoad).transpose();
  step.carry_covariance(P);
  P.middleCols<3>(kToolOffset) *= offset_decay;
  P.middleRows<3>(kToolOffset) *= offset_decay;

  step.add_noise(P);
  P.diagonal().segment<3>(kToolOffset).array() +=
      square(belief_.load.tool_offset_sd_m) * (1 - square(offset_decay));
  // Noise on the load: a little always, and what its swing loses to air and wire, in proportion to its speed.
  const double swing_speed = (velocity - before.motion.v.head<2>()).norm();
  const double lost = 2 * belief_.load.swing_damping_doubt * std::sqrt(stiff) * swing_speed;
  P.diagonal().segment<2>(kLoadVelocity).array() +=
      dt *
      (square(belief_.load.acceleration_noise) + square(lost) * belief_.load.swing_damping_correlation_s);
}

bool LabEstimator::update(Updates& updates, Reading kind, const SparseRow& row, double innovation,
                          double sd) {
  const math::SparseUpdate update = updates.update(row, innovation, sd * sd, belief_.gate_sigma);
  innovations_[static_cast<std::size_t>(kind)].add(update);
  if (!update) ++refused_;
  return update.taken;
}

void LabEstimator::take(const topic::Mru& mru) {
  if (!mru.stable) {
    ++refused_;
    return;
  }
  const MruReadings readings = compare(mru, view(), mount_, belief_.mru, belief_.load.gravity_mps2);
  Updates updates(filter_);
  for (const auto& r : readings) update(updates, r.kind, r.row, r.innovation, r.sd);
}

void LabEstimator::take_load(const topic::Bodies& body) {
  load_seen_ = t_;
  const Vector3d p_WL = belief_.calibration.X_WQ * vector(body.p_camera_body_m);
  const Vector2d load = filter_.x.segment<2>(kLoad);
  const Tool tool_now = tool(ship(), arm_.at(t_));
  bool taken = true;
  {
    Updates updates(filter_);
    for (int k = 0; k < 2; ++k) {
      SparseRow row;
      row.add(kLoad + k, 1.0);
      taken &= update(updates, Reading::load_place, row, p_WL[k] - load[k], belief_.camera.load_sd_m);
    }
    // The load's height is that of the tool less the hanging height of a taut wire.
    const double height = hanging_height(load, tool_now.motion.p);
    const Vector2d slope = (load - tool_now.motion.p.head<2>()) / height;
    SparseRow row;
    add_tool_terms(row, tool_now, {-slope.x(), -slope.y(), 1.0});
    row.add(kLoad, slope.x());
    row.add(kLoad + 1, slope.y());
    update(updates, Reading::load_height, row, p_WL.z() - (tool_now.motion.p.z() - height),
           belief_.camera.load_height_sd_m);
  }
  load_refusals_ = taken ? 0 : load_refusals_ + 1;
  // Somebody pushed the load, or the first sighting was a wrong one: believe the cameras again.
  if (load_refusals_ >= kRefusalsToReplace) place_load(p_WL);
}

void LabEstimator::take_platform(const topic::Bodies& body) {
  platform_seen_ = t_;
  const math::RigidTransform X_QP = math::RigidTransform::from_quaternion(
      Eigen::Map<const Eigen::Vector4d>(body.q_camera_body.data()), vector(body.p_camera_body_m));
  const math::RigidTransform X_WB = belief_.calibration.X_WQ * X_QP * belief_.calibration.X_BP.inverse();
  const Vector3d offset = X_WB.p - belief_.calibration.X_WN.p;
  const Vector3d rpy = math::to_euler(R_WD_.transpose() * X_WB.R, math::EulerOrder::zyx);
  const Vector3d place = triple(0, 0), turn = triple(0, 3);
  Updates updates(filter_);
  for (int i = 0; i < 3; ++i) {
    SparseRow on_place, on_turn;
    on_place.add(axis(i), 1.0);
    update(updates, Reading::platform_place, on_place, offset[i] - place[i], belief_.camera.platform_sd_m);
    on_turn.add(axis(3 + i), 1.0);
    update(updates, Reading::platform_angle, on_turn, wrapped(rpy[i] - turn[i]),
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
  ship_model_.over(ahead).carry(filter_.x);
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
