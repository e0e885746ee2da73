/// @file  `SequenceLedger`: what a counter in the samples says about how many of them are missing.
#pragma once

#include <cstdint>

namespace motionlab::record {

/// Fed with the numbers of one stream in the order of arrival. A number up to 63 behind the newest that has
/// not been there is late and no longer missing; one that has been there is a repetition. One further behind,
/// or more than a million ahead, is a new start: nothing is said to be missing before it.
class SequenceLedger {
 public:
  void take(std::uint64_t number) noexcept;

  [[nodiscard]] std::uint64_t heard() const noexcept { return heard_; }  ///< without repetitions
  [[nodiscard]] std::uint64_t missing() const noexcept { return missing_; }
  [[nodiscard]] std::uint64_t late() const noexcept { return late_; }
  [[nodiscard]] std::uint64_t repeated() const noexcept { return repeated_; }
  [[nodiscard]] std::uint64_t restarts() const noexcept { return restarts_; }

 private:
  void begin(std::uint64_t number) noexcept;

  std::uint64_t newest_ = 0;
  std::uint64_t seen_ = 0;  ///< bit n: newest - n has been there, or belongs to before the start
  std::uint64_t heard_ = 0, missing_ = 0, late_ = 0, repeated_ = 0, restarts_ = 0;
};

}  // namespace motionlab::record
