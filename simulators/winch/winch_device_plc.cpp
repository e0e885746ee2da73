#include "simulators/winch/winch_device_plc.hpp"

#include <algorithm>
#include <cmath>

namespace motionlab::winch {

namespace {

constexpr std::uint32_t kDriveNotReady = 0x4650;  // NC error: drive hardware not ready to operate
constexpr double kNearLimitM = 0.001;
constexpr double kLongestStepPeriods = 10.0;  // a host that stalled must not make the set point jump
constexpr auto kTimeoutDefault = std::chrono::milliseconds{100};
constexpr auto kTimeoutMin = std::chrono::milliseconds{20};
constexpr auto kTimeoutMax = std::chrono::milliseconds{500};

// S-0-0135, S-0-0011
constexpr std::uint16_t kDriveShutDown = 1U << 13;
constexpr std::uint16_t kDriveReadyForPower = 1U << 14;
constexpr std::uint16_t kDriveEnabled = 3U << 14;
constexpr std::uint16_t kClass1Manufacturer = 1U << 15;

std::chrono::milliseconds watchdog_time(const PlcCommand& command) noexcept {
  if (command.timeout.count() == 0) return kTimeoutDefault;
  return std::clamp(command.timeout, kTimeoutMin, kTimeoutMax);
}

}  // namespace

PlcProgram::PlcProgram(const PlcConfig& config) : config_(config) {
  // The declared initial value of nLayoutVersion; all else is zero until the first cycle, the time stamp too.
  store<std::endian::little>(memory().subspan(kStatusAt), kLayoutVersion);
}

double PlcProgram::set_point_m() const noexcept {
  return config_.wire_at_zero_travel_m + config_.pay_out_sign * position_m_;
}

void PlcProgram::lose_power() {
  PlcProgram fresh{config_};
  fresh.position_m_ = fresh.measured_position_m_ = measured_position_m_;
  fresh.t_last_ = t_last_;
  fresh.running_ = false;
  fresh.drive_fault_ = drive_fault_;
  fresh.frozen_ = frozen_;
  fresh.watchdog_tripped_ = watchdog_tripped_;
  *this = fresh;
}

void PlcProgram::cycle(LabTime t, const Measurement& is, const Measurement& seen) {
  const double dt_s =
      t_last_ ? std::clamp(seconds(t - *t_last_), 0.0, kLongestStepPeriods * config_.task_period_s)
              : config_.task_period_s;
  t_ = t;
  t_last_ = t;
  sensed_ = seen;
  measured_position_m_ = config_.pay_out_sign * (is.wire_length_m - config_.wire_at_zero_travel_m);

  if (running_) {
    take_command();
    watch_heartbeat();
    decide();
  } else {
    enable_seen_low_ = false;
    state_ = PlcState::off;
    if (at_rest()) power(false);
  }
  move(dt_s);
  switch_brake();
  if (running_) write_status();
}

void PlcProgram::take_command() {
  previous_ = command_;
  const Bytes bytes = memory().subspan(kCommandAt, kCommandSize);
  if (std::equal(bytes.begin(), bytes.end(), seen_.begin())) return;
  std::copy(bytes.begin(), bytes.end(), seen_.begin());
  const auto decoded = PlcCommand::decode(bytes);
  command_refused_ = !decoded || std::abs(decoded->velocity_mps) > config_.speed_max_mps ||
                     std::abs(decoded->acceleration_mps2) > config_.acceleration_max_mps2;
  if (command_refused_) {
    ++refused_;
    return;
  }
  if (!t_beat_ || decoded->heartbeat != command_.heartbeat) t_beat_ = t_;
  command_ = *decoded;
}

void PlcProgram::watch_heartbeat() {
  communication_ok_ = !watchdog_tripped_ && t_beat_ && t_ - *t_beat_ < watchdog_time(command_);
}

void PlcProgram::decide() {
  const PlcState before = state_;
  const bool restart = communication_ok_ && !command_.enable && reset_edge();
  if (drive_fault_) {
    diagnosis_ = *drive_fault_;
    velocity_mps_ = 0;
    power(false);
    state_ = PlcState::fault;
  }
  switch (state_) {
    case PlcState::off:
      if (!communication_ok_) break;
      if (!command_.enable) {
        enable_seen_low_ = true;
        limited_ = false;
      } else if (enable_seen_low_ && command_.mode != PlcMode::off) {
        const bool agrees =
            command_.mode != PlcMode::position ||
            std::abs(command_.position_m - measured_position_m_) <= config_.enable_agreement_m;
        limited_ = !agrees;
        if (!agrees) break;
        power(true);
        state_ = PlcState::enabling;
      }
      break;
    case PlcState::enabling:
      if (!communication_ok_) {
        lose_communication();
      } else if (!command_.enable) {
        power(false);
        state_ = PlcState::off;
      } else if (t_ - t_state_ >= from_seconds(config_.enabling_s)) {
        state_ = PlcState::hold;
      }
      break;
    case PlcState::hold:
    case PlcState::velocity:
    case PlcState::position:
    case PlcState::stopping:
      obey_or_stop();
      break;
    case PlcState::fault:
      if (restart && !drive_fault_) {
        diagnosis_ = 0;
        state_ = PlcState::off;
      }
      break;
    case PlcState::communication_lost:
      if (!communication_ok_ && t_ - *t_beat_ >= from_seconds(config_.power_off_after_s)) power(false);
      if (restart && at_rest()) {
        power(false);
        state_ = PlcState::off;
      }
      break;
  }
  if (state_ != before) t_state_ = t_;
}

void PlcProgram::obey_or_stop() {
  if (!communication_ok_) {
    lose_communication();
    return;
  }
  const bool off = !command_.enable || command_.mode == PlcMode::off;
  if (off || command_.quick_stop) {
    if (!at_rest()) {
      state_ = PlcState::stopping;
    } else if (off) {
      power(false);
      state_ = PlcState::off;
    } else {
      state_ = PlcState::hold;
    }
    return;
  }
  switch (command_.mode) {
    case PlcMode::off:
    case PlcMode::hold:
      state_ = PlcState::hold;
      break;
    case PlcMode::velocity:
      state_ = PlcState::velocity;
      break;
    case PlcMode::position:
      state_ = PlcState::position;
      break;
  }
}

void PlcProgram::lose_communication() {
  state_ = PlcState::communication_lost;
  ++watchdog_trips_;
}

void PlcProgram::power(bool on) {
  if (powered_ == on) return;
  powered_ = on;
  t_power_ = t_;
  enable_seen_low_ = false;
}

double PlcProgram::velocity_wanted(double dt_s) const {
  if (!running_ || !communication_ok_ || dt_s <= 0) return 0.0;
  if (state_ == PlcState::velocity) return command_.velocity_mps;
  if (state_ != PlcState::position) return 0.0;
  const double age_s = std::min(seconds(t_ - *t_beat_), 2.0 * config_.command_period_s);
  const double target_m = std::clamp(command_.position_m + command_.velocity_mps * age_s,
                                     config_.position_min_m, config_.position_max_m);
  const double error_m = target_m - position_m_;
  const double exact_mps = error_m / dt_s;
  if (std::abs(exact_mps - velocity_mps_) <= config_.acceleration_max_mps2 * dt_s) return exact_mps;
  const double approach_mps = std::sqrt(2.0 * config_.stop_deceleration_mps2 * std::abs(error_m));
  return command_.velocity_mps + std::copysign(std::min(approach_mps, std::abs(exact_mps)), error_m);
}

/// The fastest velocity from which the axis still stops before its soft limit, one cycle ahead.
double PlcProgram::within_braking_distance(double velocity_mps, double dt_s) {
  // The way of this cycle plus v^2 / 2a must fit into the distance; the way depends on how `move` integrates.
  const double a = config_.stop_deceleration_mps2;
  const double half = (state_ == PlcState::position ? 1.0 : 0.5) * a * dt_s;
  const auto allowed = [&](double distance_m, double velocity_now_mps) {
    const double begun = state_ == PlcState::position ? 0.0 : a * dt_s * velocity_now_mps;
    return std::max(std::sqrt(std::max(half * half + 2.0 * a * distance_m - begun, 0.0)) - half, 0.0);
  };
  const double up = allowed(config_.position_max_m - position_m_, velocity_mps_);
  const double down = allowed(position_m_ - config_.position_min_m, -velocity_mps_);
  limited_ = velocity_mps > up || velocity_mps < -down;
  return std::clamp(velocity_mps, -down, up);
}

void PlcProgram::move(double dt_s) {
  if (!powered_) {
    velocity_mps_ = 0;
    if (brake_closed_) position_m_ = measured_position_m_;
    return;
  }
  double wanted_mps = std::clamp(velocity_wanted(dt_s), -config_.speed_max_mps, config_.speed_max_mps);
  wanted_mps = within_braking_distance(wanted_mps, dt_s);
  const bool stopping = state_ != PlcState::velocity && state_ != PlcState::position;
  const double rate = stopping ? config_.stop_deceleration_mps2 : config_.acceleration_max_mps2;
  const double before_mps = velocity_mps_;
  velocity_mps_ += std::clamp(wanted_mps - velocity_mps_, -rate * dt_s, rate * dt_s);
  // A position stream names the point to be at; elsewhere the velocity is what is asked for.
  const double mean_mps = state_ == PlcState::position ? velocity_mps_ : 0.5 * (before_mps + velocity_mps_);
  const double next_m = position_m_ + mean_mps * dt_s;
  // Outside its limits (they may have been moved) the axis may come back, but go no further.
  const double low_m = std::min(config_.position_min_m, position_m_);
  const double high_m = std::max(config_.position_max_m, position_m_);
  position_m_ = std::clamp(next_m, low_m, high_m);
  if (position_m_ != next_m) velocity_mps_ = 0;
}

void PlcProgram::switch_brake() {
  if (!t_power_) return;
  const double since_s = seconds(t_ - *t_power_);
  brake_closed_ = powered_ ? since_s < config_.brake_opens_after_s : since_s >= config_.brake_closes_after_s;
}

void PlcProgram::write_status() {
  if (!frozen_) {
    ++cycle_count_;
    t_plc_ = clock(t_);
  }
  const bool error = state_ == PlcState::fault;
  const double seen_position_m =
      config_.pay_out_sign * (sensed_.wire_length_m - config_.wire_at_zero_travel_m);
  PlcStatus status;
  status.cycle_count = cycle_count_;
  status.heartbeat_echo = command_.heartbeat;
  status.sequence_echo = command_.sequence;
  status.t_plc = t_plc_;
  status.position_m = seen_position_m;
  status.velocity_mps = config_.pay_out_sign * sensed_.wire_speed_mps;
  status.set_position_m = position_m_;
  status.following_error_m = position_m_ - seen_position_m;
  status.torque_nm = sensed_.motor_torque_nm;
  status.motor_temperature_degc = sensed_.motor_temperature_degc;
  status.position_min_m = config_.position_min_m;
  status.position_max_m = config_.position_max_m;
  status.axis_state = axis_state::homed |
                      (powered_ ? axis_state::operational | axis_state::external_generator : 0U) |
                      (velocity_mps_ == 0  ? axis_state::not_moving
                       : velocity_mps_ > 0 ? axis_state::positive
                                           : axis_state::negative) |
                      (error ? axis_state::error : 0U);
  status.axis_error_id = error ? kDriveNotReady : 0U;
  status.drive_diagnosis = diagnosis_;
  status.watchdog_trips = watchdog_trips_;
  status.drive_status_word = error ? kDriveShutDown : powered_ ? kDriveEnabled : kDriveReadyForPower;
  status.class_1_diagnosis = error ? kClass1Manufacturer : std::uint16_t{0};
  status.state = state_;
  status.ready = !error;
  status.enabled = powered_ && state_ != PlcState::enabling;
  status.error = error;
  status.at_min = seen_position_m <= config_.position_min_m + kNearLimitM;
  status.at_max = seen_position_m >= config_.position_max_m - kNearLimitM;
  status.warning = command_refused_ || limited_;
  status.communication_ok = communication_ok_;
  status.homed = true;
  status_ = status;
  LittleWriter writer{memory().subspan(kStatusAt, kStatusSize)};
  status.encode(writer);
}

}  // namespace motionlab::winch
