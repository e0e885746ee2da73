/// @file  The line cut between the drivers and the control room, so that a test can stand in between.
#pragma once

#include <functional>
#include <optional>

#include "tests/integration/line.hpp"

namespace motionlab::integration {

/// Laboratory and drivers share one bus, the control room has another; samples are carried over once per
/// period. What is carried can be changed, and the drivers can be taken away.
class TakenApart {
 public:
  explicit TakenApart(const lockstep::Config& config)
      : config_(config),
        lab_(config.lab, network_, LabTime{}),
        arm_out_(wires_.advertise<topic::ArmCommand>()),
        winch_out_(wires_.advertise<topic::WinchCommand>()),
        mru_in_(desk_.advertise<topic::Mru>()),
        bodies_in_(desk_.advertise<topic::Bodies>()),
        arm_in_(desk_.advertise<topic::ArmState>()),
        winch_in_(desk_.advertise<topic::WinchState>()),
        requests_(desk_.advertise<topic::ModeRequest>()),
        references_(desk_.advertise<topic::Reference>()),
        mru_(wires_.reader<topic::Mru>(config.gateway.mrus.front().driver.device)),
        load_(wires_.reader<topic::Bodies>(config.gateway.qualisys.driver.device,
                                           config.gateway.qualisys.load_body)),
        platform_(wires_.reader<topic::Bodies>(config.gateway.qualisys.driver.device,
                                               config.gateway.qualisys.platform_body)),
        arm_(wires_.reader<topic::ArmState>(config.gateway.comau.driver.device)),
        winch_(wires_.reader<topic::WinchState>(config.gateway.winch.driver.device)),
        arm_command_(
            desk_.reader<topic::ArmCommand>(config.gateway.comau.driver.device, service::kGatewayRequester)),
        winch_command_(desk_.reader<topic::WinchCommand>(config.gateway.winch.driver.device,
                                                         service::kGatewayRequester)),
        control_newest_(desk_.reader<topic::Control>()),
        mode_(desk_.reader<topic::Mode>()) {
    devices_.emplace(config.gateway, network_, wires_, schedule_);
    control_.emplace(config.gateway, desk_, schedule_);
  }

  /// Called with every sample that is carried to the control room.
  std::function<void(topic::Mru&)> change_mru;
  std::function<void(topic::Bodies&)> change_bodies;
  std::function<void(topic::ArmState&)> change_arm;
  std::function<void(topic::WinchState&)> change_winch;
  /// Called around the step of the control room.
  std::function<void()> before_control, after_control;
  /// The control room stands still: no step, no command. Drivers and laboratory go on.
  bool control_hangs = false;

  void step() {
    const LabTime end = clock_.now() + from_seconds(config_.gateway.control_period_s);
    while (clock_.now() < end) {
      LabTime next = std::min(end, std::max(lab_.next_event(), clock_.now() + 1ns));
      if (const auto due = network_.next_due()) next = std::min(next, std::max(*due, clock_.now()));
      if (devices_ && devices_->next_send() > clock_.now()) next = std::min(next, devices_->next_send());
      network_.run_until(next);
      lab_.step(next);
      if (devices_ && next >= devices_->next_send() && next < end) devices_->step(next);
      network_.deliver_due(next);
    }
    if (!devices_) return;
    devices_->step(end);
    network_.deliver_due(end);
    if (control_hangs) return;
    carry(mru_, mru_in_, change_mru);
    carry(load_, bodies_in_, change_bodies);
    carry(platform_, bodies_in_, change_bodies);
    carry(arm_, arm_in_, change_arm);
    carry(winch_, winch_in_, change_winch);
    if (before_control) before_control();
    control_->step(end);
    if (after_control) after_control();
    carry(arm_command_, arm_out_, {});
    carry(winch_command_, winch_out_, {});
    if (const auto control = control_newest_.newer()) {
      steps_.push_back({from_ns(control->t_snapshot_ns), control_->mode(), control->following,
                        control->qd_command_radps, control->wire_speed_command_mps});
    }
  }
  void run_to(double t_s) {
    while (now_s() < t_s - 1e-9) step();
  }
  void ask(topic::ModeAction action) {
    topic::ModeRequest request;
    request.requester = "test";
    request.action = action;
    requests_.publish(request);
  }
  /// As the io thread tells that nobody would brake the arm if this process died.
  void lose_deadman() { schedule_.deadman_lost = true; }
  void refer(const topic::Reference& reference) { references_.publish(reference); }
  /// The gateway is gone: no driver, no control, no farewell.
  void destroy_gateway() {
    control_.reset();
    devices_.reset();
  }

  [[nodiscard]] double now_s() const { return seconds(clock_.now().time_since_epoch()); }
  [[nodiscard]] topic::Mode mode() const { return mode_.newest().value_or(topic::Mode{}); }
  [[nodiscard]] lab::SimulatedLab& lab() { return lab_; }
  [[nodiscard]] MemoryNetwork& network() { return network_; }
  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }

 private:
  template <class T>
  static void carry(bus::Reader<T>& from, bus::Publisher<T>& to, const std::function<void(T&)>& change) {
    auto sample = from.newer();
    if (!sample) return;
    if (change) change(*sample);
    to.publish(*sample);
  }

  lockstep::Config config_;
  SteppedClock clock_;
  MemoryNetwork network_{clock_};
  bus::LocalBus wires_, desk_;
  service::ArmSchedule schedule_;
  lab::SimulatedLab lab_;
  bus::Publisher<topic::ArmCommand> arm_out_;
  bus::Publisher<topic::WinchCommand> winch_out_;
  bus::Publisher<topic::Mru> mru_in_;
  bus::Publisher<topic::Bodies> bodies_in_;
  bus::Publisher<topic::ArmState> arm_in_;
  bus::Publisher<topic::WinchState> winch_in_;
  bus::Publisher<topic::ModeRequest> requests_;
  bus::Publisher<topic::Reference> references_;
  bus::Reader<topic::Mru> mru_;
  bus::Reader<topic::Bodies> load_, platform_;
  bus::Reader<topic::ArmState> arm_;
  bus::Reader<topic::WinchState> winch_;
  bus::Reader<topic::ArmCommand> arm_command_;
  bus::Reader<topic::WinchCommand> winch_command_;
  bus::Reader<topic::Control> control_newest_;
  bus::Reader<topic::Mode> mode_;
  std::optional<service::Devices> devices_;
  std::optional<service::ControlLoop> control_;
  std::vector<Step> steps_;
};

}  // namespace motionlab::integration
