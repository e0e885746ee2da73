/// @file  How long to wait before the next try.
#pragma once

#include <algorithm>
#include <cstdint>

#include "drivers/core/time.hpp"

namespace motionlab::winch {

/// A wait that doubles with every use from a least to a greatest, spread by a quarter so that gateways which
/// lost the same controller do not come back together.
class Backoff {
 public:
  Backoff(double min_s, double max_s, std::uint32_t seed) noexcept
      : min_s_(min_s), max_s_(max_s), wait_s_(min_s), jitter_(seed) {}

  [[nodiscard]] Nanoseconds next() noexcept {
    jitter_ = jitter_ * 1664525U + 1013904223U;  // Numerical Recipes' generator
    const double spread = 0.75 + 0.5 * static_cast<double>(jitter_ >> 8) / static_cast<double>(1U << 24);
    const double wait_s = wait_s_ * spread;
    wait_s_ = std::min(2.0 * wait_s_, max_s_);
    return from_seconds(wait_s);
  }
  /// It worked: the next wait is the least.
  void reset() noexcept { wait_s_ = min_s_; }

 private:
  double min_s_;
  double max_s_;
  double wait_s_;
  std::uint32_t jitter_;
};

}  // namespace motionlab::winch
