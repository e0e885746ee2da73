/// @file  Whether a reading can be one at all. What is not goes into no filter.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "idl/mru.hpp"

namespace motionlab::estimator {

/// No reading of any laboratory is larger, in SI units.
inline constexpr double kLargest = 1e3;

/// Whether every value is finite and of a possible size.
template <std::size_t N>
[[nodiscard]] bool sane(const std::array<double, N>& values) {
  return std::all_of(values.begin(), values.end(), [](double v) { return std::abs(v) <= kLargest; });
}
/// Likewise of the variables that an estimator uses.
[[nodiscard]] inline bool sane(const topic::Mru& mru) {
  return sane(mru.euler_heading_mru_rad) && sane(mru.omega_mru_radps) && sane(mru.a_heading_origin_mps2);
}

}  // namespace motionlab::estimator
