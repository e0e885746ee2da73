/// @file  `Sequence<T, N>`: a few values by value, for topics and hand-over between threads. Never allocates.
#pragma once

#include <array>
#include <cassert>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace motionlab {

/// Up to N values in order. Trivially copyable. Empty at birth. To clear it costs nothing.
template <class T, std::size_t N>
requires std::is_trivially_copyable_v<T>
class Sequence {
 public:
  static constexpr std::size_t kCapacity = N;

  /// Appends a value. False when there is no room: the value is then not taken.
  constexpr bool push(const T& value) noexcept {
    if (full()) return false;
    items_[size_++] = value;
    return true;
  }
  constexpr void clear() noexcept { size_ = 0; }

  [[nodiscard]] constexpr std::size_t size() const noexcept { return size_; }
  [[nodiscard]] constexpr bool empty() const noexcept { return size_ == 0; }
  [[nodiscard]] constexpr bool full() const noexcept { return size_ == N; }
  [[nodiscard]] constexpr const T* begin() const noexcept { return items_.data(); }
  [[nodiscard]] constexpr const T* end() const noexcept { return items_.data() + size_; }
  /// @pre not empty
  [[nodiscard]] constexpr const T& back() const noexcept {
    assert(!empty());
    return items_[size_ - 1];
  }

 private:
  std::uint32_t size_ = 0;
  std::array<T, N> items_{};
};

}  // namespace motionlab
