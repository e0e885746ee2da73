#include "gateway/deadman/winch_settler.hpp"

#include <cmath>

namespace motionlab::deadman {
namespace {

constexpr double kAtRest_mps = 0.005;

}  // namespace

WinchSettler::WinchSettler(const winch::DriverConfig& config, StreamOut& out, LabTime now)
    : driver_(config, out, [this](const topic::WinchState& state) { newest_ = state; }),
      give_up_(now + kContactPatience),
      end_(config.commands() ? End::not_yet : End::nothing_to_settle) {}

void WinchSettler::step(LabTime now) {
  if (end_ != End::not_yet) return;
  driver_.step(now);
  if (!stopping_ && newest_ && driver_.health().phase() == LinkPhase::up) {
    stopping_ = true;
    give_up_ = now + kStopPatience;
    driver_.orderly_stop();
  }
  if (driver_.stopped() || driver_.halted() || now >= give_up_) end_ = judged();
}

WinchSettler::End WinchSettler::judged() const noexcept {
  if (!stopping_) return End::unreachable;
  const bool moves = newest_->drive_state == topic::WinchDriveState::velocity ||
                     newest_->drive_state == topic::WinchDriveState::position ||
                     newest_->drive_state == topic::WinchDriveState::stopping;
  return !moves && std::abs(newest_->wire_speed_mps) < kAtRest_mps ? End::at_rest : End::moving;
}

}  // namespace motionlab::deadman
