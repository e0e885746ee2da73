/// @file  How often something took how long, in buckets of a quarter octave: `motionlab/timing` carries them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace motionlab::service {

/// Counts durations. Adding never allocates and takes no lock; one thread.
class TimeHistogram {
 public:
  static constexpr std::size_t kBuckets = 72;  ///< the last begins at 0.19 s
  using Counts = std::array<std::uint64_t, kBuckets>;

  void add(double us) noexcept {
    ++counts_[bucket(us)];
    max_us_ = std::max(max_us_, us);
  }
  [[nodiscard]] const Counts& counts() const noexcept { return counts_; }
  [[nodiscard]] double max_us() const noexcept { return max_us_; }

  /// Bucket 0 is below 1 us, bucket i from 2^((i-1)/4) us up to 2^(i/4) us.
  [[nodiscard]] static std::size_t bucket(double us) noexcept {
    if (!(us >= 1.0)) return 0;
    return std::min(kBuckets - 1, static_cast<std::size_t>(4.0 * std::log2(us)) + 1);
  }
  /// Upper end of a bucket [us].
  [[nodiscard]] static double upper_us(std::size_t bucket) noexcept {
    return std::exp2(0.25 * static_cast<double>(bucket));
  }
  /// The time that a share q of all did not exceed, as if what lies in a bucket were spread evenly in it (in
  /// octaves); 0 when nothing was counted.
  [[nodiscard]] static double quantile_us(const Counts& counts, double q) noexcept {
    std::uint64_t all = 0, below = 0;
    for (const auto count : counts) all += count;
    if (all == 0) return 0.0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      const double wanted = q * static_cast<double>(all) - static_cast<double>(below);
      below += counts[i];
      if (counts[i] > 0 && wanted <= static_cast<double>(counts[i]))
        return upper_us(i) * std::exp2(0.25 * (wanted / static_cast<double>(counts[i]) - 1.0));
    }
    return upper_us(kBuckets - 1);
  }

 private:
  Counts counts_{};
  double max_us_ = 0.0;
};

}  // namespace motionlab::service
