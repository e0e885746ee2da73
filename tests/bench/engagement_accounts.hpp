/// @file  What a gateway says of a long engagement, from one moment to a later one, and whether it adds up.
#pragma once

#include <sys/types.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "gateway/service/gateway_config.hpp"
#include "gateway/service/time_histogram.hpp"
#include "idl/topics.hpp"

namespace motionlab::test {

/// Resident memory of a process [kB]; 0 when it is gone.
inline double resident_kb(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string word; status >> word;) {
    double kb = 0;
    if (word == "VmRSS:" && status >> kb) return kb;
  }
  return 0;
}

/// The memory of one process over time, looked at in equal steps.
class MemoryWatch {
 public:
  void add(double kb) { kb_.push_back(kb); }
  /// From the second quarter to the last one, between medians: what start-up and caches took is left out.
  /// [kB]
  [[nodiscard]] double growth_kb() const { return median(3, 4) - median(1, 2); }
  [[nodiscard]] double newest_kb() const { return kb_.empty() ? 0 : kb_.back(); }

 private:
  [[nodiscard]] double median(std::size_t from_quarter, std::size_t to_quarter) const {
    std::vector<double> part(kb_.begin() + static_cast<std::ptrdiff_t>(from_quarter * kb_.size() / 4),
                             kb_.begin() + static_cast<std::ptrdiff_t>(to_quarter * kb_.size() / 4));
    if (part.empty()) return 0;
    std::sort(part.begin(), part.end());
    return part[part.size() / 2];
  }
  std::vector<double> kb_;
};

/// One device between two looks at its row of `motionlab/health`.
struct DeviceAccount {
  std::string device;
  double seconds = 0;
  double expected = 0;  ///< samples, by the period of the configuration
  std::uint64_t received = 0, lost = 0, rejected = 0, reconnects = 0;
  double age_max_s = 0;

  DeviceAccount(const topic::Health& before, const topic::Health& after, double period_s)
      : device(after.device.view()),
        seconds(1e-9 * static_cast<double>(after.t_ns - before.t_ns)),
        expected(seconds / period_s),
        received(after.received - before.received),
        lost(after.lost - before.lost),
        rejected(sum(after.rejected) - sum(before.rejected)),
        reconnects(after.reconnects - before.reconnects),
        age_max_s(after.age_max_s) {}

  void print() const {
    const auto count = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
    std::printf("%-10s %10.0f %10llu %7llu %9llu %11llu %12.1f\n", device.c_str(), expected, count(received),
                count(lost), count(rejected), count(reconnects), 1e3 * age_max_s);
  }

  /// Samples of which nobody says where they are: neither accepted, nor refused for a reason, nor missed by
  /// the device's own counter. The devices' clocks are some 10⁻⁴ off ours.
  /// @param slept_through  so many may never have been asked for: this machine stood still
  [[nodiscard]] double unaccounted(double slept_through = 0) const {
    const double missing = expected - static_cast<double>(received + lost + rejected);
    const double most = 5.0 + 2e-4 * expected;
    return missing >= -most && missing <= most + slept_through ? 0.0 : missing;
  }

 private:
  template <class Counts>
  static std::uint64_t sum(const Counts& counts) {
    return std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  }
};

/// The control thread between two looks at `motionlab/timing`.
struct ThreadAccount {
  using Counts = service::TimeHistogram::Counts;
  Counts period{}, wakeup{}, step{}, age{};
  std::uint64_t steps = 0, page_faults = 0;

  ThreadAccount(const topic::Timing& before, const topic::Timing& after)
      : steps(after.steps - before.steps), page_faults(after.page_faults - before.page_faults) {
    for (std::size_t i = 0; i < step.size(); ++i) {
      period[i] = after.period_count[i] - before.period_count[i];
      wakeup[i] = after.wakeup_count[i] - before.wakeup_count[i];
      step[i] = after.step_time_count[i] - before.step_time_count[i];
      age[i] = after.age_at_actuation_count[i] - before.age_at_actuation_count[i];
    }
  }

  void print() const {
    std::printf("%-28s %9s %9s %9s %9s %9s\n", "control thread [us]", "p50", "p90", "p99", "p99.9",
                "longest");
    const auto row = [](const char* what, const Counts& counts) {
      std::printf("%-28s", what);
      for (const double share : {0.5, 0.9, 0.99, 0.999, 1.0}) {
        std::printf(" %9.0f", service::TimeHistogram::quantile_us(counts, share));
      }
      std::printf("\n");
    };
    row("step, snapshot to guard", step);
    row("late wake-up", wakeup);
    row("period", period);
    row("MRU's age at actuation", age);
  }
};

/// Every device of the configuration with the period at which it sends.
inline std::vector<std::pair<std::string, double>> periods(const service::GatewayConfig& config) {
  std::vector<std::pair<std::string, double>> rows;
  for (const auto& mru : config.mrus) {
    rows.emplace_back(mru.driver.device, mru.driver.period_s);
  }
  rows.emplace_back("qualisys", config.qualisys.driver.frame_period_s);
  rows.emplace_back("arm", config.comau.driver.command_period_s);
  rows.emplace_back("winch", config.winch.driver.status_period_s);
  return rows;
}

}  // namespace motionlab::test
