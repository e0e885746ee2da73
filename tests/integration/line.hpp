/// @file  The whole line in lockstep with its eyes open: what the integration tests have in common.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/monitor/motion_score.hpp"
#include "gateway/service/gateway_config.hpp"
#include "simulators/lab/lockstep/lockstep.hpp"

namespace motionlab::integration {

inline std::filesystem::path config_file(std::string_view name) {
  return std::filesystem::path(MOTIONLAB_SOURCE_DIR) / "deploy" / "config" / name;
}

/// The laboratory's freshness limits on the loopback's addresses: a virtual clock never stands still.
inline lockstep::Config configure(std::string_view scenario, std::uint64_t seed = 1, bool tracked = true) {
  lockstep::Config config;
  config.gateway = service::load_gateway_config(config_file("lab.toml"), {config_file("loopback.toml")});
  config.lab = lab::LabConfig::load(config_file("world.toml"));
  config.lab.set_scenario(scenario);
  config.lab.seed = seed;
  config.lab.set_platform_tracked(tracked);
  config.gateway.set_platform_tracked(tracked);
  return config;
}

/// Mode and command of one control step.
struct Step {
  LabTime t{};
  topic::ModeState state{};
  bool following = false;
  std::array<double, 6> qd_radps{};
  double wire_speed_mps = 0;

  [[nodiscard]] bool at_rest() const {
    return wire_speed_mps == 0 &&
           std::all_of(qd_radps.begin(), qd_radps.end(), [](double v) { return v == 0; });
  }
  [[nodiscard]] bool finite() const {
    return std::isfinite(wire_speed_mps) &&
           std::all_of(qd_radps.begin(), qd_radps.end(), [](double v) { return std::isfinite(v); });
  }
};

/// FNV-1a over the fields of topics.
class Hash {
 public:
  template <class T>
  void add(const T& sample) {
    T::fields(sample, [this](std::string_view, const auto& value) { bytes(&value, sizeof(value)); });
  }
  void bytes(const void* data, std::size_t size) {
    const auto* const byte = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value_ = (value_ ^ byte[i]) * 0x100000001b3;
  }
  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325;
};

/// A lockstep run that remembers every command, every mode and how the load hung.
class Line {
 public:
  explicit Line(const lockstep::Config& config)
      : config_(config),
        line_(config),
        control_(line_.bus().subscribe<topic::Control>()),
        mode_(line_.bus().subscribe<topic::Mode>()),
        requests_(line_.bus().advertise<topic::ModeRequest>()) {}

  void step() {
    line_.step();
    while (const auto mode = mode_.next()) {
      if (modes_.empty() || modes_.back().sequence_number != mode->sequence_number) modes_.push_back(*mode);
    }
    while (const auto control = control_.next()) {
      commands_.add(*control);
      steps_.push_back({from_ns(control->t_snapshot_ns), mode().state, control->following,
                        control->qd_command_radps, control->wire_speed_command_mps});
    }
    const topic::TruthWorld truth = line_.lab().truth();
    monitor::MotionSample sample;
    sample.swing_rad = truth.swing_rad;
    for (std::size_t i = 0; i < 3; ++i) {
      sample.load_error_m[i] = truth.p_world_load_m[i] - config_.gateway.p_world_load_reference_m[i];
    }
    motion_.add(sample);
  }
  void run_to(double t_s) {
    while (now_s() < t_s - 1e-9) step();
  }
  void run_for(double s) { run_to(now_s() + s); }
  /// Steps until `done()` holds. @returns false when it did not within `patience_s`
  template <class Done>
  bool run_until(Done&& done, double patience_s) {
    const double end = now_s() + patience_s;
    while (!done()) {
      if (now_s() >= end) return false;
      step();
    }
    return true;
  }
  bool run_until_state(topic::ModeState state, double patience_s) {
    return run_until([&] { return mode().state == state; }, patience_s);
  }

  void ask(topic::ModeAction action) { line_.request(action); }
  void ask_authority(topic::Authority authority) {
    topic::ModeRequest request;
    request.requester = "test";
    request.action = topic::ModeAction::authority;
    request.authority = authority;
    requests_.publish(request);
  }
  /// Engages at 10 s, as `lab.sh` does, and runs on.
  void engage_and_run_to(double t_s) {
    run_to(10);
    ask(topic::ModeAction::engage);
    run_to(t_s);
  }
  void fault(std::string_view device, std::string_view name, bool active, double value = 0) {
    if (!line_.lab().set_fault(device, name, active, value)) throw StartupError("no such fault");
  }

  [[nodiscard]] const lockstep::Config& config() const { return config_; }
  [[nodiscard]] lockstep::Lockstep& lockstep() { return line_; }
  [[nodiscard]] MemoryNetwork& network() { return line_.network(); }
  [[nodiscard]] LabTime now() const { return line_.now(); }
  [[nodiscard]] double now_s() const { return seconds(line_.now().time_since_epoch()); }
  [[nodiscard]] topic::Mode mode() const { return modes_.empty() ? topic::Mode{} : modes_.back(); }
  [[nodiscard]] const std::vector<topic::Mode>& modes() const { return modes_; }
  [[nodiscard]] const std::vector<Step>& steps() const { return steps_; }
  /// Of every control sample so far, in bits.
  [[nodiscard]] std::uint64_t commands_hash() const { return commands_.value(); }
  [[nodiscard]] topic::Health health(std::string_view device) {
    topic::Health found;
    line_.bus().for_each_newest<topic::Health>([&](const topic::Health& health) {
      if (health.device.view() == device) found = health;
    });
    return found;
  }
  [[nodiscard]] std::uint64_t rejected(std::string_view device, Reason reason) {
    return health(device).rejected[static_cast<std::size_t>(reason)];
  }
  /// How still the load hung since the last call.
  monitor::MotionScore take_motion() {
    const auto score = motion_.score();
    motion_ = {};
    return score.value_or(monitor::MotionScore{});
  }

 private:
  lockstep::Config config_;
  lockstep::Lockstep line_;
  bus::Subscription<topic::Control> control_;
  bus::Subscription<topic::Mode> mode_;
  bus::Publisher<topic::ModeRequest> requests_;
  std::vector<topic::Mode> modes_;
  std::vector<Step> steps_;
  Hash commands_;
  monitor::MotionStatistics motion_;
};

/// The last coming to rest in a record of commands.
struct Stop {
  LabTime t_ramp{};  ///< first step that does nothing but brake
  LabTime t_rest{};  ///< first step that asks nothing to move
};

/// Finds the last stop: at its end nothing moves, and before that every step brakes every joint and the winch
/// by no less and no more than the stop deceleration. Nothing when the record does not end at rest or never
/// moved.
inline std::optional<Stop> last_stop(const std::vector<Step>& steps, const controller::GuardLimits& limits,
                                     double period_s) {
  const auto brakes = [&](double before, double after, double deceleration) {
    const double slower = std::max(0.0, std::abs(before) - deceleration * period_s);
    return std::abs(std::abs(after) - slower) < 1e-12 && after * before >= 0;
  };
  if (steps.empty() || !steps.back().at_rest()) return std::nullopt;
  std::size_t rest = steps.size() - 1;
  while (rest > 0 && steps[rest - 1].at_rest()) --rest;
  if (rest == 0) return std::nullopt;
  std::size_t ramp = rest;
  const auto pure_brake = [&](std::size_t k) {
    for (std::size_t i = 0; i < 6; ++i) {
      if (!brakes(steps[k - 1].qd_radps[i], steps[k].qd_radps[i], limits.stop_deceleration_radps2))
        return false;
    }
    return brakes(steps[k - 1].wire_speed_mps, steps[k].wire_speed_mps, limits.wire_acceleration_max_mps2);
  };
  while (ramp > 0 && pure_brake(ramp)) --ramp;
  if (ramp == rest) return std::nullopt;
  return Stop{steps[ramp + 1].t, steps[rest].t};
}

/// The steps [from, end) in which a command changes faster than the guard's limits allow, is not finite, or
/// leaves the speed limits.
inline std::size_t steps_beyond_limits(const std::vector<Step>& steps, const controller::GuardLimits& limits,
                                       double period_s, std::size_t from = 1) {
  constexpr double kRounding = 1e-12;
  std::size_t beyond = 0;
  for (std::size_t k = std::max<std::size_t>(from, 1); k < steps.size(); ++k) {
    bool good = steps[k].finite();
    for (std::size_t i = 0; i < 6; ++i) {
      const double a = std::max(limits.qdd_max_radps2[i], limits.stop_deceleration_radps2);
      good = good && std::abs(steps[k].qd_radps[i] - steps[k - 1].qd_radps[i]) <= a * period_s + kRounding &&
             std::abs(steps[k].qd_radps[i]) <= limits.qd_max_radps[i] + kRounding;
    }
    good = good &&
           std::abs(steps[k].wire_speed_mps - steps[k - 1].wire_speed_mps) <=
               limits.wire_acceleration_max_mps2 * period_s + kRounding &&
           std::abs(steps[k].wire_speed_mps) <= limits.wire_speed_max_mps + kRounding;
    if (!good) ++beyond;
  }
  return beyond;
}

}  // namespace motionlab::integration
