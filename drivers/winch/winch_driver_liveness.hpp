/// @file  Is the command path alive, and how long do requests take?
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "drivers/core/time.hpp"

namespace motionlab::winch {

/// Compares the heartbeats we sent with those the PLC echoes.
class HeartbeatWatch {
 public:
  /// A new connection; the PLC's last accepted heartbeat is this.
  void restart(std::uint32_t heartbeat) noexcept {
    last_ = echo_ = heartbeat;
    sent_any_ = false;
  }
  /// The next heartbeat to send.
  [[nodiscard]] std::uint32_t next() const noexcept { return last_ + 1; }
  void sent(LabTime t) noexcept {
    ++last_;
    sent_any_ = true;
    t_sent_[last_ % kRemembered] = t;
  }
  void echoed(std::uint32_t heartbeat) noexcept { echo_ = heartbeat; }
  [[nodiscard]] std::uint32_t last() const noexcept { return last_; }
  [[nodiscard]] std::uint32_t echo() const noexcept { return echo_; }

  /// Whether the oldest heartbeat without echo is younger than the limit. False before the first was sent,
  /// and when the echo is not one of ours (somebody else commands the winch).
  [[nodiscard]] bool alive(LabTime now, Nanoseconds limit) const noexcept {
    const std::uint32_t missing = last_ - echo_;
    if (!sent_any_ || missing >= kRemembered) return false;
    return missing == 0 || now - t_sent_[(echo_ + 1) % kRemembered] <= limit;
  }

 private:
  static constexpr std::uint32_t kRemembered = 64;
  std::array<LabTime, kRemembered> t_sent_{};
  std::uint32_t last_ = 0;
  std::uint32_t echo_ = 0;
  bool sent_any_ = false;
};

/// Round trip times of requests.
class RoundTrip {
 public:
  void add(Nanoseconds d) noexcept {
    recent_[count_++ % kRecent] = d;
    max_ = std::max(max_, d);
  }
  /// The longest since the start.
  [[nodiscard]] Nanoseconds max() const noexcept { return max_; }
  /// The median of the last 128; zero before the first.
  [[nodiscard]] Nanoseconds p50() const noexcept {
    const auto n = static_cast<std::ptrdiff_t>(std::min(count_, kRecent));
    if (n == 0) return Nanoseconds{0};
    auto sorted = recent_;
    std::nth_element(sorted.begin(), sorted.begin() + n / 2, sorted.begin() + n);
    return sorted[static_cast<std::size_t>(n / 2)];
  }

 private:
  static constexpr std::size_t kRecent = 128;
  std::array<Nanoseconds, kRecent> recent_{};
  std::size_t count_ = 0;
  Nanoseconds max_{0};
};

}  // namespace motionlab::winch
