/// @file  Follows a device's own 32-bit counter (milliseconds, control cycles) across its wrap.
#pragma once

#include <cstdint>
#include <optional>

namespace motionlab {

/// Unwraps a counter that runs modulo 2^32 and says what each new reading means.
///
/// Differences are taken modulo 2^32 and read as signed, so neither the sign change at 2^31 nor the wrap at
/// 2^32 is seen. A step back by more than `restart_gap` counts is a restart of the device; a smaller one is
/// an old datagram.
class WrappingCounter {
 public:
  enum class Step : std::uint8_t { first, forward, repeated, backward, restarted };

  /// @param restart_gap  counts, > 0
  explicit constexpr WrappingCounter(std::int64_t restart_gap) noexcept : restart_gap_(restart_gap) {}

  /// What this reading would mean; changes nothing.
  [[nodiscard]] constexpr Step classify(std::uint32_t raw) const noexcept {
    if (!last_) return Step::first;
    const std::int64_t delta = difference(raw);
    if (delta == 0) return Step::repeated;
    if (delta > 0) return Step::forward;
    return delta < -restart_gap_ ? Step::restarted : Step::backward;
  }

  /// The unwrapped count that this reading stands for, given where the counter was; changes nothing.
  [[nodiscard]] constexpr std::int64_t unwrapped(std::uint32_t raw) const noexcept {
    return last_ ? total_ + difference(raw) : static_cast<std::int64_t>(raw);
  }

  /// Moves to this reading. @returns counts since the last one; 0 for the first.
  constexpr std::int64_t advance(std::uint32_t raw) noexcept {
    const std::int64_t delta = last_ ? difference(raw) : 0;
    total_ = unwrapped(raw);
    last_ = raw;
    return delta;
  }

  /// Forgets where it was: the next reading is the first.
  constexpr void reset() noexcept { last_.reset(); }

  [[nodiscard]] constexpr std::int64_t total() const noexcept { return total_; }

 private:
  /// @pre last_
  [[nodiscard]] constexpr std::int64_t difference(std::uint32_t raw) const noexcept {
    return static_cast<std::int32_t>(raw - *last_);
  }

  std::int64_t restart_gap_;
  std::optional<std::uint32_t> last_;
  std::int64_t total_ = 0;
};

}  // namespace motionlab
