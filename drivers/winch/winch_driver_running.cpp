#include <chrono>
#include <cmath>

#include "drivers/winch/winch_driver.hpp"
#include "drivers/winch/winch_driver_advice.hpp"

namespace motionlab::winch {

namespace {

constexpr double kAtRestMps = 0.005;
constexpr Nanoseconds kRestPatience = 3s;
constexpr Nanoseconds kDisablePatience = 1s;

}  // namespace

void WinchDriver::write_command() {
  const auto period = from_seconds(config_.command_period_s);
  next_command_ += period;
  if (next_command_ <= now_) next_command_ += period * ((now_ - next_command_) / period + 1);
  if (stopping_ == Stopping::cleaning || !config_.commands()) return;
  if (requests_.waiting_for(Purpose::write_command)) {
    ++counters_.commands_skipped;
    return;
  }
  PlcCommand command = commands_.at(now_, status_ ? status_->set_position_m : 0.0);
  counters_.commands_stale = commands_.became_stale();
  const Arming::Bits bits = arming_.bits();
  command.enable = bits.enable;
  command.reset = bits.reset;
  command.torque_limit_nm = config_.torque_limit_nm;
  command.timeout = std::chrono::milliseconds{std::llround(1e3 * config_.plc_watchdog_s)};
  if (stopping_ != Stopping::no) {
    command.quick_stop = true;
    command.mode = written_.mode == PlcMode::off ? PlcMode::off : PlcMode::hold;
    command.velocity_mps = 0.0;
    command.acceleration_mps2 = 0.0;
    command.enable = written_.enable && stopping_ == Stopping::braking;
    command.reset = false;
  }
  const bool changed = command.mode != written_.mode || command.enable != written_.enable ||
                       command.reset != written_.reset || command.quick_stop != written_.quick_stop;
  command.heartbeat = heartbeat_.next();
  command.sequence = written_.sequence + (changed ? 1U : 0U);
  if (config_.legacy()) {
    write_legacy(command);
  } else {
    std::array<std::uint8_t, kCommandSize> bytes{};
    LittleWriter writer{bytes};
    command.encode(writer);
    request(Purpose::write_command, AdsCommand::write,
            WriteRequest{index_group::value_by_handle, command_handle_, bytes});
  }
  heartbeat_.sent(now_);
  arming_.written({command.enable, command.reset}, command.heartbeat);
  written_ = command;
  ++counters_.commands_written;
}

/// Asks for the status where no notification brings it: always in the legacy profile, else when they stay
/// away.
void WinchDriver::check_status_age() {
  const auto age = now_ - t_fresh_;
  if (age > from_seconds(config_.status_dead_after_s)) {
    lose_link(advice::kStandsStill, now_);
    return;
  }
  const bool stale = age > from_seconds(config_.status_stale_after_s);
  if (stale) health_.advice(advice::kStandsStill);
  if ((!stale && !config_.legacy()) || now_ < next_read_ || requests_.waiting_for(Purpose::read_status)) {
    return;
  }
  if (config_.legacy()) {
    next_read_ = now_ + from_seconds(config_.status_period_s);
    read_legacy();
  } else {
    next_read_ = now_ + from_seconds(config_.status_stale_after_s);
    request(Purpose::read_status, AdsCommand::read,
            ReadRequest{index_group::value_by_handle, status_handle_, kStatusSize});
  }
}

void WinchDriver::orderly_stop() {
  if (stopping_ != Stopping::no || stage_ == Stage::ended) return;
  if (stage_ != Stage::running) {
    finish();
    return;
  }
  t_stopping_ = now_;
  stop_heartbeat_ = heartbeat_.next();
  if (config_.commands()) {
    stopping_ = Stopping::braking;
  } else {  // what we never moved we need not stop
    stopping_ = Stopping::cleaning;
    clean_up();
  }
}

void WinchDriver::follow_stop() {
  const auto begin = [&](Stopping next) {
    stopping_ = next;
    t_stopping_ = now_;
    stop_heartbeat_ = heartbeat_.next();
  };
  const bool heard = status_ && static_cast<std::int32_t>(status_->heartbeat_echo - stop_heartbeat_) >= 0;
  const auto waited = now_ - t_stopping_;
  switch (stopping_) {
    case Stopping::no:
      break;
    case Stopping::braking: {
      const bool holding = heard && status_->state != PlcState::velocity &&
                           status_->state != PlcState::position && status_->state != PlcState::stopping;
      if ((holding && std::abs(status_->velocity_mps) < kAtRestMps) || waited > kRestPatience) {
        begin(Stopping::disabling);
      }
      break;
    }
    case Stopping::disabling:
      if ((heard && !status_->enabled) || waited > kDisablePatience) {
        begin(Stopping::cleaning);
        clean_up();
      }
      break;
    case Stopping::cleaning:
      if (!requests_.waiting_for(Purpose::clean_up)) finish();
      break;
  }
}

}  // namespace motionlab::winch
