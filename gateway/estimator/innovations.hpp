/// @file  What the filter was told against what it expected.
#pragma once

#include <cstddef>
#include <cstdint>

#include "gateway/math/sparse_kalman.hpp"

namespace motionlab::estimator {

/// The kinds of scalar readings that the filter takes in.
enum class Reading {
  mru_angle,
  mru_rate,
  mru_acceleration,
  load_place,   ///< horizontal
  load_height,  ///< against the tool's
  platform_place,
  platform_angle,
};
inline constexpr std::size_t kReadings = 7;

/// Counts of one kind of reading since the filter was made.
///
/// The mean of normalised squares (NIS) is 1 when what the filter believes of the reading's noise and of its
/// own state is so. Well below: it trusts the reading less than its scatter asks for, which is right where
/// the noise is slow, for then many readings err alike. Well above: it trusts itself or the reading too much.
struct Innovations {
  std::uint64_t taken = 0;
  std::uint64_t refused = 0;  ///< by the gate
  double sum_of_squares = 0;  ///< of normalised innovations, of the taken ones

  void add(const math::SparseUpdate& update) {
    if (!update) {
      ++refused;
      return;
    }
    ++taken;
    sum_of_squares += update.nis;
  }
  /// Zero before the first.
  [[nodiscard]] double mean_nis() const {
    return taken == 0 ? 0.0 : sum_of_squares / static_cast<double>(taken);
  }
};

}  // namespace motionlab::estimator
