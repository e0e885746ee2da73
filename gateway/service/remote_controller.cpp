#include "gateway/service/remote_controller.hpp"

namespace motionlab::service {

RemoteController::RemoteController(const GatewayConfig& config, bus::LocalBus& local, const Text<32>& name)
    : config_(config),
      name_(name),
      inputs_(config, local, schedule_),
      own_(config),
      readiness_(config),
      mode_(local.reader<topic::Mode>()),
      left_(local.reader<topic::ArmCommand>(config.comau.driver.device, kGatewayRequester)),
      arm_(local.advertise<topic::ArmCommand>()),
      winch_(local.advertise<topic::WinchCommand>()) {}

bool RemoteController::step(LabTime t) {
  hear_what_left();
  const topic::Snapshot& inputs = inputs_.gather(t);
  own_.take(inputs);
  const Snapshot& now = newest_.take(inputs);
  const topic::Estimate estimate = own_.estimate(now);
  const double dt_s = stepped_ ? seconds(t - *stepped_) : config_.control_period_s;
  stepped_ = t;
  const auto facts = readiness_.judge(
      {.now = now, .estimate = estimate, .dt_s = dt_s, .on_second_ship = own_.on_second_ship()});
  const auto wish = own_.wish(now, estimate, readiness_.load_seen(), owns_the_crane());
  if (!wish || facts.unsafe) return false;
  command(t, *wish);
  return true;
}

bool RemoteController::owns_the_crane() const {
  const auto mode = mode_.newest();
  return mode && mode->state == topic::ModeState::engaged && mode->external_controller &&
         mode->owner == name_;
}

void RemoteController::hear_what_left() {
  if (const auto command = left_.newer()) (void)schedule_.sent.push(*command);
}

void RemoteController::command(LabTime t, const controller::Wish& wish) {
  ++steps_;
  topic::ArmCommand arm;
  arm.device = config_.comau.driver.device;
  arm.requester = name_;
  arm.sequence_number = steps_;
  arm.t_created_ns = to_ns(t);
  arm.follow = true;
  arm.qd_wanted_radps = wish.qd_radps;
  arm_.publish(arm);
  topic::WinchCommand winch;
  winch.device = config_.winch.driver.device;
  winch.requester = name_;
  winch.sequence_number = steps_;
  winch.t_created_ns = arm.t_created_ns;
  winch.enable = true;
  winch.mode = topic::WinchCommandMode::velocity;
  winch.wire_speed_wanted_mps = wish.wire_speed_mps;
  winch_.publish(winch);
}

}  // namespace motionlab::service
