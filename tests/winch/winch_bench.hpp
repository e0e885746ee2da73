// Driver and simulated PLC joined by the memory network on stepped time.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "drivers/core/memory_network.hpp"
#include "drivers/winch/winch_driver.hpp"
#include "simulators/winch/winch_device.hpp"

namespace motionlab::winch {

/// The whole wire. The drive is ideal: what it holds is what is measured.
class Bench {
 public:
  static constexpr Endpoint kPlc{0xC0A85A96, 48898};  // 192.168.90.150
  static constexpr Endpoint kGateway{0xC0A85A46, 0};  // 192.168.90.70

  explicit Bench(DriverConfig driver_config = {}, DeviceConfig device_config = {}) : network_(clock_) {
    clock_.set(LabTime{100s});
    server_ = network_.server(kPlc);
    device_ = std::make_unique<WinchDevice>(std::move(device_config), *server_);
    server_->on_event(device_.get());
    device_->cycle(clock_.now(), Measurement{locked_length_m_, 0.0, 0.5, 41.0});
    start_gateway(std::move(driver_config));
  }

  /// A gateway that knows nothing of a former one, which vanishes without a word.
  void start_gateway(DriverConfig driver_config = {}) {
    driver_.reset();
    client_ = network_.client(kPlc, kGateway);
    driver_ = std::make_unique<WinchDriver>(std::move(driver_config), *client_,
                                            [this](const topic::WinchState& s) { states_.push_back(s); });
    client_->on_event(driver_.get());
  }

  /// Steps everything by whole milliseconds; the caller's command, if any, is renewed every 10 ms.
  void run(Nanoseconds duration) {
    const LabTime end = clock_.now() + duration;
    while (clock_.now() < end) {
      network_.run_until(clock_.now() + 1ms);
      const LabTime t = clock_.now();
      if (command && ++ticks_ % 10 == 0) (void)give(*command);
      driver_->step(t);
      device_->step(t);
      if (to_ns(t) % 5'000'000 == 0 && plc_alive) {
        const double length = device_->brake_closed() ? locked_length_m_ : device_->set_point_m();
        const double speed = (length - locked_length_m_) / 0.005;
        locked_length_m_ = length;
        device_->cycle(t, Measurement{length, speed, 0.5, 41.0});
      }
    }
  }

  Status give(topic::WinchCommand c) {
    c.t_created_ns = to_ns(clock_.now());
    return driver_->set_command(c);
  }

  static topic::WinchCommand make(topic::WinchCommandMode mode, bool enable, double value = 0.0,
                                  bool reset = false) {
    topic::WinchCommand c;
    c.device = "winch";
    c.mode = mode;
    c.enable = enable;
    c.reset = reset;
    if (mode == topic::WinchCommandMode::velocity) c.wire_speed_wanted_mps = value;
    if (mode == topic::WinchCommandMode::position) c.wire_length_wanted_m = value;
    return c;
  }

  /// Connects and enables, holding.
  void engage() {
    command = make(topic::WinchCommandMode::hold, false);
    run(200ms);
    command->enable = true;
    run(300ms);
  }

  [[nodiscard]] const topic::WinchState& last() const { return states_.back(); }
  [[nodiscard]] LabTime now() const { return clock_.now(); }

  std::optional<topic::WinchCommand> command;
  bool plc_alive = true;

  SteppedClock clock_;
  MemoryNetwork network_;
  std::unique_ptr<StreamServer> server_;
  std::unique_ptr<WinchDevice> device_;
  std::unique_ptr<StreamClient> client_;
  std::unique_ptr<WinchDriver> driver_;
  std::vector<topic::WinchState> states_;

 private:
  double locked_length_m_ = 2.0;
  std::uint64_t ticks_ = 0;
};

}  // namespace motionlab::winch
