/// @file  A laboratory in which gateways die: the arm's wire is tapped, and the plant says whether the arm
/// rests.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "drivers/comau/comau_driver_velocity.hpp"
#include "tests/integration/arm_tap.hpp"
#include "tests/integration/process_bench.hpp"

namespace motionlab::integration {

/// Every joint of the stopped arm brakes with this: lab.toml.
inline constexpr double kStopDeceleration = 1.0;
inline constexpr double kCommandPeriod = 0.005;

/// What is really so: the simulator's truth, by the door that the gateway never uses.
class Witness {
 public:
  explicit Witness(int domain)
      : dds_({.domain = domain,
              .interface_whitelist = {"127.0.0.1"},
              .participant = "witness",
              .join_truth = true},
             local_),
        truth_(local_.subscribe<topic::TruthWorld>()) {
    dds_.in<topic::TruthWorld>();
    dds_.start();
  }
  ~Witness() { dds_.stop(); }

  /// The plant's joints do not move for half a second of its own time.
  [[nodiscard]] bool arm_rests() {
    return eventually(
        [this] {
          while (const auto now = truth_.next()) look(*now);
          return rest_began_ && newest_.t_ns - rest_began_->t_ns > 500'000'000;
        },
        kPatience);
  }
  /// Forgets what it saw; what it sees from now on counts.
  void look_anew() {
    while (truth_.next()) {
    }
    rest_began_.reset();
    fastest_radps_ = hardest_radps2_ = 0;
    window_.clear();
  }
  /// Of any joint since it was told to look anew, over a tenth of a second: speed and its fall.
  [[nodiscard]] double fastest_radps() const { return fastest_radps_; }
  [[nodiscard]] double hardest_braking_radps2() const { return hardest_radps2_; }
  [[nodiscard]] const topic::TruthWorld& newest() const { return newest_; }

 private:
  static constexpr double kStill = 2e-4;  // rad in half a second

  void look(const topic::TruthWorld& now) {
    newest_ = now;
    if (!rest_began_ || !std::ranges::equal(now.q_rad, rest_began_->q_rad,
                                            [](double a, double b) { return std::abs(a - b) < kStill; })) {
      rest_began_ = now;
    }
    window_.push_back(now);
    while (seconds_between(window_.front(), now) > 0.1) window_.erase(window_.begin());
    const double span = seconds_between(window_.front(), now);
    if (span < 0.08 || window_.size() < 10) return;
    const topic::TruthWorld& middle = window_[window_.size() / 2];
    const double first = seconds_between(window_.front(), middle), second = seconds_between(middle, now);
    for (std::size_t i = 0; i < now.q_rad.size(); ++i) {
      const double before = (middle.q_rad[i] - window_.front().q_rad[i]) / first;
      const double after = (now.q_rad[i] - middle.q_rad[i]) / second;
      fastest_radps_ = std::max(fastest_radps_, std::abs(after));
      hardest_radps2_ = std::max(hardest_radps2_, (std::abs(before) - std::abs(after)) / (0.5 * span));
    }
  }
  static double seconds_between(const topic::TruthWorld& a, const topic::TruthWorld& b) {
    return 1e-9 * static_cast<double>(b.t_ns - a.t_ns);
  }

  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Subscription<topic::TruthWorld> truth_;
  topic::TruthWorld newest_;
  std::optional<topic::TruthWorld> rest_began_;
  std::vector<topic::TruthWorld> window_;
  double fastest_radps_ = 0;
  double hardest_radps2_ = 0;
};

/// The datagram of a ramp that follows this one.
inline comau::Command braked(const comau::Command& before) {
  comau::VelocityShaper::Config config;
  config.period_s = kCommandPeriod;
  config.stop_deceleration_radps2.fill(kStopDeceleration);
  return comau::VelocityShaper(config, before).brake();
}

/// The first datagram of the ramp: one step of braking below the one before it, to the last bit; or, when a
/// robot computer with a watchdog was left alone for longer than that waits, the one from which the ramp goes
/// down.
inline std::optional<std::size_t> first_braking(const std::vector<Seen>& seen, std::int64_t t_from_ns) {
  constexpr std::int64_t kWatchdog_ns = 20'000'000;
  for (std::size_t i = 1; i < seen.size(); ++i) {
    if (seen[i].t_ns < t_from_ns || !seen[i].follows() || !seen[i - 1].follows()) continue;
    if (seen[i].command == braked(seen[i - 1].command)) return i;
    const bool after_a_pause = seen[i].t_ns - seen[i - 1].t_ns > kWatchdog_ns;
    if (after_a_pause && i + 1 < seen.size() && seen[i + 1].command == braked(seen[i].command)) return i;
  }
  return std::nullopt;
}

/// From there on: every datagram is the braked one of the one before, until mode 0, which is never left.
inline bool brakes_to_the_end(const std::vector<Seen>& seen, std::size_t from) {
  for (std::size_t i = from + 1; i < seen.size(); ++i) {
    if (!seen[i - 1].follows() && seen[i].follows()) return false;
    for (std::size_t joint = 0; joint < comau::kJointCount; ++joint) {
      const double before = static_cast<double>(seen[i - 1].command.qd_radps[joint]);
      const double after = static_cast<double>(seen[i].command.qd_radps[joint]);
      if (std::abs(after) > std::abs(before)) return false;
      if (std::abs(before - after) > kStopDeceleration * kCommandPeriod + 1e-6) return false;
    }
  }
  return !seen.empty() && !seen.back().follows() && seen.back().fastest_radps() == 0.0;
}

/// Gateway and simulator with a tapped arm.
class DeadmanBench : public ProcessBench {
 public:
  /// @param faithful  the robot computer's program with its defects, without a watchdog
  void set_up(const std::string& name, bool faithful) {
    ProcessBench::set_up(name);
    fast_enough_radps_ = faithful ? 0.05 : 0.15;  // without a watchdog 0.1 is the most
    port_["tap"] = RawSocket(SOCK_DGRAM).port();
    std::string overlay = gateway_overlay();
    const std::string robot = at("robot");
    overlay.replace(overlay.find(robot), robot.size(),
                    at("tap") + (faithful ? "watchdog = \"none\"\n" : "watchdog = \"patched\"\n"));
    write("gateway.toml", overlay);
    std::string world = world_overlay();
    world.replace(world.find(robot), robot.size(), robot + "hardened = " + (faithful ? "false\n" : "true\n"));
    write("world.toml", world + "\n[devices.arm.pendant]\ndriving_on_s = 0.0\nstart_after_s = 0.0\n");
    tap_ = std::make_unique<ArmTap>(port_.at("tap"), port_.at("robot"));
  }
  void tear_down() {
    gateway_.reset();
    simulator_.reset();
    // The last gateway's deadman may still be at work in the folder's ports.
    (void)port_is_free();
    tap_.reset();
    ProcessBench::tear_down();
  }

  /// Nobody speaks for the arm any more, no deadman either.
  [[nodiscard]] bool port_is_free() const {
    return eventually(
        [this] {
          try {
            const RawSocket arm(SOCK_DGRAM, port_.at("arm"));
            return true;
          } catch (const std::runtime_error&) {
            return false;
          }
        },
        kPatience);
  }

  /// Engaged in a sea, and the arm moves. The simulator is started if it does not run, after the gateway: the
  /// faithful program ends on remote mode before the first datagram. @returns empty, or what went wrong
  [[nodiscard]] std::string engage_in_a_sea() {
    gateway_ = start_gateway();
    if (!eventually([this] { return !tap_->seen().empty(); }, kPatience)) {
      return "the gateway sends nothing: " + gateway_->output();
    }
    if (!simulator_) simulator_ = start_simulator({"--scenario", "sea"});
    observer_ = std::make_unique<Observer>(domain_);
    if (!eventually([this] { return observer_->all_up(); }, kPatience)) {
      return "not everything is up: " + gateway_->output() + simulator_->output();
    }
    // The robot's drives take a second to come on; a machine that stands still for long lets go. Then once
    // more.
    for (int attempt = 0; attempt < 6; ++attempt) {
      if (!observer_->ask_until(topic::ModeAction::engage, topic::ModeState::engaged)) {
        return "does not engage: " + observer_->mode().reason.str();
      }
      tap_->clear();
      const auto moves = [this] {
        const auto seen = tap_->seen();
        return !seen.empty() && seen.back().follows() && seen.back().fastest_radps() > fast_enough_radps_;
      };
      if (eventually(moves, std::chrono::seconds{6})) return "";
      observer_->ask(topic::ModeAction::settle);
      (void)eventually([this] { return observer_->mode().state != topic::ModeState::engaged; }, kPatience);
      observer_->ask(topic::ModeAction::reset);
    }
    return "engaged, and the arm does not move: " + gateway_->output();
  }

  double fast_enough_radps_ = 0.05;
  std::unique_ptr<ArmTap> tap_;
  std::unique_ptr<Child> gateway_;
  std::unique_ptr<Child> simulator_;
  std::unique_ptr<Observer> observer_;
};

/// The child of that process which calls itself so.
inline std::optional<pid_t> child_named(pid_t parent, const std::string& name) {
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string number = entry.path().filename().string();
    if (number.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream file(entry.path() / "stat");
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    const auto close = text.rfind(')');
    if (close == std::string::npos || text.find("(" + name + ")") == std::string::npos) continue;
    std::istringstream fields(text.substr(close + 1));
    char state = 0;
    pid_t ppid = 0;
    if (fields >> state >> ppid && ppid == parent && state != 'Z') return std::stoi(number);
  }
  return std::nullopt;
}

}  // namespace motionlab::integration
