#include "simulators/lab/fault_matrix/cell_watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "simulators/lab/fault_matrix/servo_speed.hpp"

namespace motionlab::matrix {

namespace {

constexpr double kRestJoint_radps = 1e-3, kRestWire_mps = 1e-3;
/// What rests does not creep further than this.
constexpr double kCreepJoint_rad = 2e-3, kCreepWire_m = 2e-3;
/// From the fastest that the guard allows everything rests within half of this.
constexpr Nanoseconds kStopping = 2s;
/// Longer than half a period of the servos' ringing (0.19 s).
constexpr Nanoseconds kStanding = 250ms;
/// The driver may let go of the arm for a moment while a few answers are missing.
constexpr Nanoseconds kDip = 300ms;

LabTime at(double t_s) {
  return LabTime{} + from_seconds(t_s);
}

bool moves(const Truth& truth) {
  return std::abs(truth.wire_speed_mps) > kRestWire_mps ||
         std::any_of(truth.qd_radps.begin(), truth.qd_radps.end(),
                     [](double qd) { return std::abs(qd) > kRestJoint_radps; });
}

bool creeps(const Truth& truth, const Truth& from) {
  bool far = std::abs(truth.wire_length_m - from.wire_length_m) > kCreepWire_m;
  for (std::size_t j = 0; j < truth.q_rad.size(); ++j) {
    far = far || std::abs(truth.q_rad[j] - from.q_rad[j]) > kCreepJoint_rad;
  }
  return far;
}

/// How fast the speed of the joint's set point may change: as the guard lets it, but where the wire or the
/// robot computer are at fault, as its program lets it. The published one knows no such limit.
double acceleration_of_set_point(const Cell& cell, std::size_t joint, const service::GatewayConfig& gateway,
                                 const lab::LabConfig& lab) {
  if (cell.fault.device != lab::kArm) return gateway.limits.qdd_max_radps2[joint];
  if (cell.fault.program == Program::faithful) return std::numeric_limits<double>::infinity();
  return lab.arm.acceleration_max_radps2[joint];
}

std::array<double, 6> fastest_joints(const Cell& cell, const service::GatewayConfig& gateway,
                                     const lab::LabConfig& lab) {
  std::array<double, 6> fastest{};
  for (std::size_t j = 0; j < fastest.size(); ++j) {
    const double limit = gateway.limits.qd_max_radps[j];
    const ServoLoop loop{lab.world.differences.joint_bandwidth_factor * lab.world.arm.omega_radps[j],
                         lab.world.arm.zeta[j]};
    fastest[j] = limit * servo_speed_share(loop, limit, acceleration_of_set_point(cell, j, gateway, lab));
  }
  return fastest;
}

/// What the winch's controller makes of a command is its own affair: only the speed counts.
double fastest_wire(const service::GatewayConfig& gateway, const lab::LabConfig& lab) {
  const double limit = gateway.limits.wire_speed_max_mps;
  const ServoLoop loop{lab.world.winch.omega_radps, lab.world.winch.zeta};
  return limit * servo_speed_share(loop, limit, std::numeric_limits<double>::infinity());
}

std::uint64_t refused(const topic::Health& health) {
  return std::accumulate(health.rejected.begin(), health.rejected.end(), std::uint64_t{0});
}

}  // namespace

CellWatch::CellWatch(const Cell& cell, const service::GatewayConfig& gateway, const lab::LabConfig& lab)
    : state_(cell.state),
      limits_(gateway.limits),
      qdd_max_radps2_(gateway.comau.driver.qdd_max_radps2),
      servo_qd_max_radps_(fastest_joints(cell, gateway, lab)),
      servo_wire_speed_max_mps_(fastest_wire(gateway, lab)),
      command_period_(from_seconds(gateway.comau.driver.command_period_s)),
      fault_(at(Timetable::of(cell).fault_s)),
      fault_ends_(at(Timetable::of(cell).fault_ends_s)),
      asked_(at(Timetable::of(cell).engage_s)) {}

void CellWatch::detect(LabTime t, std::string by) {
  if (detected_ || t < fault_) return;
  detected_ = t;
  outcome_.detected_by = std::move(by);
}

void CellWatch::sent(LabTime t, bool follow, const std::array<double, 6>& qd_radps) {
  std::array<double, 6> qd{};
  if (follow) qd = qd_radps;
  Overshoot& most = outcome_.overshoot;
  for (std::size_t j = 0; j < qd.size(); ++j) {
    most.joint_speed = std::max(most.joint_speed, std::abs(qd[j]) / limits_.qd_max_radps[j]);
  }
  if (sent_) {
    const double dt = seconds(std::max(t - *sent_, command_period_));
    for (std::size_t j = 0; j < qd.size(); ++j) {
      most.joint_acceleration =
          std::max(most.joint_acceleration, std::abs(qd[j] - qd_sent_radps_[j]) / dt / qdd_max_radps2_[j]);
    }
  }
  sent_ = t;
  qd_sent_radps_ = qd;
  if (follow) {
    let_go_.reset();
  } else if (!let_go_) {
    let_go_ = t;
  }
}

void CellWatch::take(LabTime t, const topic::Mode& mode) {
  using topic::ModeState;
  const bool engaged = mode.state == ModeState::engaged;
  if (t < fault_) {
    was_engaged_ = engaged;
    outcome_.in_state = state_ == State::settled ? mode.state == ModeState::ready : engaged;
    mode_ = mode;
    return;
  }
  if (mode.fault_latched && mode.fault_code.view() != mode_.fault_code.view()) {
    outcome_.code = mode.fault_code.str();
    detect(t, "mode " + outcome_.code);
  }
  if (mode.state != mode_.state && !engaged && mode.state != ModeState::ready) {
    detect(t, "mode " + std::string(mode.fault_code.empty() ? topic::to_string(mode.state)
                                                            : mode.fault_code.view()));
  }
  if (state_ == State::settled && !was_engaged_ && t >= asked_ && t < fault_ends_ && !engaged &&
      outcome_.code.empty()) {
    outcome_.code = mode.fault_code.str();
  }
  const bool asked = state_ == State::settled && t >= asked_ && t < fault_ends_;
  if (engaged && mode_.state != ModeState::engaged && (ended_ || !asked)) outcome_.moved_by_itself = true;
  if (was_engaged_ && !engaged && !ended_) ended_ = moved_ = t;
  was_engaged_ |= engaged;
  if (engaged && mode_.state != ModeState::engaged) engaged_ = t;
  mode_ = mode;
}

void CellWatch::take(LabTime t, const topic::WinchCommand& command) {
  outcome_.overshoot.wire_speed = std::max(
      outcome_.overshoot.wire_speed, std::abs(command.wire_speed_wanted_mps) / limits_.wire_speed_max_mps);
  if (winch_told_ && t > *winch_told_) {
    outcome_.overshoot.wire_acceleration =
        std::max(outcome_.overshoot.wire_acceleration,
                 std::abs(command.wire_speed_wanted_mps - wire_speed_told_mps_) / seconds(t - *winch_told_) /
                     limits_.wire_acceleration_max_mps2);
  }
  winch_told_ = t;
  wire_speed_told_mps_ = command.wire_speed_wanted_mps;
}

void CellWatch::take(LabTime t, const topic::Health& health) {
  if (t < fault_) {
    health_before_ = health;
    return;
  }
  if (health.link != topic::LinkState::up) detect(t, "link " + std::string(topic::to_string(health.link)));
  if (during_fault(t)) outcome_.advised = !health.advice.empty();
  if (!health.advice.empty() && health.advice.view() != health_before_.advice.view()) detect(t, "advice");
  const bool counts = refused(health) > refused(health_before_) || health.lost > health_before_.lost ||
                      health.reconnects > health_before_.reconnects;
  if (counts && !counted_) counted_ = t;
}

void CellWatch::quality(LabTime t, bool good) {
  if (t < fault_) {
    good_before_ = good;
  } else if (good_before_ && !good) {
    detect(t, "quality");
  }
}

void CellWatch::take(LabTime t, const Truth& truth) {
  watch_limits(truth);
  watched_ = t;
  if (t < fault_) return;
  watch_swing(t, truth);
  watch_motion(t, truth);
}

void CellWatch::watch_limits(const Truth& truth) {
  Overshoot& most = outcome_.overshoot;
  for (std::size_t j = 0; j < truth.q_rad.size(); ++j) {
    most.joint_position_rad = std::max({most.joint_position_rad, truth.q_rad[j] - limits_.q_max_rad[j],
                                        limits_.q_min_rad[j] - truth.q_rad[j]});
    const double qd = std::abs(truth.qd_radps[j]);
    most.plant_joint_speed = std::max(most.plant_joint_speed, qd / limits_.qd_max_radps[j]);
    most.plant_joint_speed_of_servo = std::max(most.plant_joint_speed_of_servo, qd / servo_qd_max_radps_[j]);
  }
  most.wire_length_m = std::max({most.wire_length_m, truth.wire_length_m - limits_.wire_max_m,
                                 limits_.wire_min_m - truth.wire_length_m});
  const double speed = std::abs(truth.wire_speed_mps);
  most.plant_wire_speed = std::max(most.plant_wire_speed, speed / limits_.wire_speed_max_mps);
  most.plant_wire_speed_of_servo =
      std::max(most.plant_wire_speed_of_servo, speed / servo_wire_speed_max_mps_);
}

void CellWatch::watch_swing(LabTime t, const Truth& truth) {
  outcome_.swing_max_deg = std::max(outcome_.swing_max_deg, truth.swing_deg);
  outcome_.twin_swing_max_deg = std::max(outcome_.twin_swing_max_deg, truth.twin_swing_deg);
  if (!during_fault(t)) return;
  squares_deg2_ += truth.swing_deg * truth.swing_deg;
  ++samples_;
}

bool CellWatch::rests(LabTime t) const {
  return rest_ && t - rest_->since > kStanding;
}

void CellWatch::watch_motion(LabTime t, const Truth& truth) {
  const bool engaged = mode_.state == topic::ModeState::engaged;
  if (engaged && during_fault(t) && let_go_ && t - std::max({*let_go_, fault_, engaged_}) > kDip) {
    outcome_.ending = Ending::brakes_engaged;
  }
  if (was_engaged_ && !ended_) {
    rest_.reset();
    return;
  }
  const bool moving = moves(truth) || (rest_ && creeps(truth, rest_->where));
  if (!moving) {
    if (!rest_) rest_ = Rest{t, truth};
    return;
  }
  if (ended_) {
    moved_ = t;
    for (const double qd : truth.qd_radps) {
      outcome_.joint_speed_max_radps = std::max(outcome_.joint_speed_max_radps, std::abs(qd));
    }
    if (during_fault(t) && t - *ended_ > kStopping) outcome_.ending = Ending::not_stoppable;
  }
  // Before the engagement nothing may move at all; after it, nothing that has come to rest.
  if (!ended_ || (rests(t) && outcome_.ending != Ending::not_stoppable)) {
    outcome_.moved_by_itself = true;
  }
  rest_.reset();
}

Outcome CellWatch::outcome() const {
  Outcome outcome = outcome_;
  const bool special =
      outcome.ending == Ending::not_stoppable || (outcome.ending == Ending::brakes_engaged && !ended_);
  if (!special) {
    if (state_ == State::settled && !was_engaged_) {
      outcome.ending = Ending::refuses;
    } else if (ended_) {
      outcome.ending = rests(watched_) ? Ending::rests : Ending::not_stoppable;
    } else {
      outcome.ending = state_ == State::settled ? Ending::engages : Ending::rides_through;
    }
  }
  if (detected_) {
    outcome.detected_after_s = seconds(*detected_ - fault_);
  } else if (counted_) {
    outcome.detected_after_s = seconds(*counted_ - fault_);
    outcome.detected_by = "counted";
  }
  if (outcome.ending == Ending::rests) outcome.at_rest_after_s = seconds(moved_ - fault_);
  if (samples_ > 0) outcome.swing_rms_deg = std::sqrt(squares_deg2_ / static_cast<double>(samples_));
  return outcome;
}

}  // namespace motionlab::matrix
