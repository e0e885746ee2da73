/// @file  Reads by DDS how a gateway's control thread keeps time, in stretches that can be compared.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/service/time_histogram.hpp"
#include "idl/topics.hpp"
#include "tests/integration/processes.hpp"

namespace motionlab::test {

inline constexpr std::chrono::seconds kPatience{120};

/// The value that a share of all does not exceed; 0 of none.
inline double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

/// What was seen of the control thread during a stretch of time.
struct Stretch {
  std::vector<double> step_cpu_us;                       ///< of the steps that were published, every fifth
  service::TimeHistogram::Counts step_time{}, wakeup{};  ///< of all steps
  double fastest_command = 0;                            ///< rad/s and m/s
  bool finite = true;                                    ///< all commands

  [[nodiscard]] double cpu_us(double share) const { return quantile(step_cpu_us, share); }
  [[nodiscard]] double step_us(double share) const {
    return service::TimeHistogram::quantile_us(step_time, share);
  }
  [[nodiscard]] double wakeup_us(double share) const {
    return service::TimeHistogram::quantile_us(wakeup, share);
  }
};

class GatewayMeter {
 public:
  GatewayMeter(int domain, const std::string& interface)
      : dds_({.domain = domain, .interface_whitelist = {interface}, .participant = "meter"}, local_),
        control_(local_.subscribe<topic::Control>()),
        mode_(local_.reader<topic::Mode>()),
        timing_(local_.reader<topic::Timing>()),
        requests_(local_.advertise<topic::ModeRequest>()) {
    dds_.in<topic::Control>();
    dds_.in<topic::Mode>();
    dds_.in<topic::Timing>();
    dds_.in<topic::Health>();
    dds_.out<topic::ModeRequest>();
    dds_.start();
  }
  ~GatewayMeter() { dds_.stop(); }

  [[nodiscard]] topic::Mode mode() const { return mode_.newest().value_or(topic::Mode{}); }
  [[nodiscard]] topic::Health health(std::string_view device) const {
    topic::Health found;
    local_.for_each_newest<topic::Health>([&](const topic::Health& health) {
      if (health.device.view() == device) found = health;
    });
    return found;
  }
  void ask(topic::ModeAction action) {
    topic::ModeRequest request;
    request.requester = "meter";
    request.sequence_number = ++asked_;
    request.t_created_ns = to_ns(clock_.now());
    request.action = action;
    requests_.publish(request);
  }
  /// Asks, after a fault for its reset first, until the gateway is engaged. @returns whether it is
  bool engage() {
    return integration::eventually(
        [this] {
          const auto state = mode().state;
          if (state == topic::ModeState::engaged) return true;
          ask(state == topic::ModeState::fault ? topic::ModeAction::reset : topic::ModeAction::engage);
          std::this_thread::sleep_for(std::chrono::milliseconds{90});
          return false;
        },
        kPatience);
  }

  /// Looks on for so long, and a second or two more: until the histograms are told that hold the end. On a
  /// machine that is busy elsewhere few samples arrive here, and it takes longer.
  Stretch look_on(std::chrono::milliseconds time) {
    const topic::Timing before = next_timing();
    while (control_.next()) {
    }
    Stretch stretch;
    const auto end = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < end ||
           (stretch.step_cpu_us.size() < kFewest && std::chrono::steady_clock::now() < end + kPatience)) {
      take_steps(stretch);
    }
    const topic::Timing after = next_timing();
    take_steps(stretch);
    for (std::size_t i = 0; i < stretch.wakeup.size(); ++i) {
      stretch.wakeup[i] = after.wakeup_count[i] - before.wakeup_count[i];
      stretch.step_time[i] = after.step_time_count[i] - before.step_time_count[i];
    }
    return stretch;
  }

  /// So many steps are looked at in a stretch.
  static constexpr std::size_t kFewest = 200;

  /// The next to be told, within a second or two.
  topic::Timing next_timing() {
    const std::uint64_t seen = timing_.newest().value_or(topic::Timing{}).sequence_number;
    (void)integration::eventually(
        [&] { return timing_.newest().value_or(topic::Timing{}).sequence_number != seen; }, kPatience);
    return timing_.newest().value_or(topic::Timing{});
  }

 private:
  void take_steps(Stretch& stretch) {
    while (const auto control = control_.next()) {
      stretch.step_cpu_us.push_back(control->step_cpu_us);
      const auto add = [&stretch](double speed) {
        stretch.finite = stretch.finite && std::isfinite(speed);
        stretch.fastest_command = std::max(stretch.fastest_command, std::abs(speed));
      };
      for (const double qd : control->qd_command_radps) add(qd);
      add(control->wire_speed_command_mps);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{20});
  }

  RealClock clock_;
  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Subscription<topic::Control> control_;
  bus::Reader<topic::Mode> mode_;
  bus::Reader<topic::Timing> timing_;
  bus::Publisher<topic::ModeRequest> requests_;
  std::uint64_t asked_ = 0;
};

}  // namespace motionlab::test
