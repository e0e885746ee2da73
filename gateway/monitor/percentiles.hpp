/// @file  The percentiles of a list of numbers, exactly.
#pragma once

#include <cstddef>
#include <vector>

namespace motionlab::monitor {

struct Percentiles {
  std::size_t count = 0;
  double min = 0, p50 = 0, p95 = 0, p99 = 0, max = 0;
};

/// Nearest rank: the smallest sample that at least this share of the samples do not exceed. All zero of no
/// samples.
[[nodiscard]] Percentiles percentiles_of(std::vector<double> samples);

}  // namespace motionlab::monitor
