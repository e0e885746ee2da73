/// @file  `Quantiles`: how a quantity is distributed, in bounded memory and the same on every machine.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace motionlab::monitor {

/// Counts samples in equal steps from zero. Everything it tells is a whole number of steps.
///
/// A sample beyond the last step is counted there, and a quantile that falls on it is told as the greatest
/// sample. Negative and non-finite samples are not counted.
class Quantiles {
 public:
  /// @param steps_per_unit  resolution: 10 tells tenths of the unit  @param range  in units, > 0
  Quantiles(double steps_per_unit, double range);

  void add(double sample);

  /// The smallest step that at least this share of the samples do not exceed. @pre not empty, 0 < share <= 1
  [[nodiscard]] double at(double share) const;
  /// The greatest sample, rounded to a step. @pre not empty
  [[nodiscard]] double max() const { return static_cast<double>(max_step_) / steps_per_unit_; }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  double steps_per_unit_;
  std::vector<std::uint64_t> counts_;
  std::uint64_t count_ = 0;
  std::uint64_t max_step_ = 0;
};

}  // namespace motionlab::monitor
