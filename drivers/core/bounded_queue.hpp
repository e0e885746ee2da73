/// @file  A bounded queue from one thread to one other. Nobody waits, nothing is allocated.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <type_traits>

namespace motionlab {

/// A ring of `Capacity` items, first in, first out. Wait-free on both sides.
///
/// When it is full the new item is refused and counted: what is queued already is older and was promised
/// first.
template <class T, std::size_t Capacity>
requires std::is_trivially_copyable_v<T> &&(std::has_single_bit(Capacity)) class BoundedQueue {
 public:
  /// Producer only. False when the queue is full.
  [[nodiscard]] bool push(const T& item) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_seen_ == Capacity) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail - head_seen_ == Capacity) {
        overruns_.fetch_add(1, std::memory_order_relaxed);
        return false;
      }
    }
    items_[tail % Capacity] = item;
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consumer only. The oldest item; nothing when the queue is empty.
  [[nodiscard]] std::optional<T> pop() noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_seen_) {
      tail_seen_ = tail_.load(std::memory_order_acquire);
      if (head == tail_seen_) return std::nullopt;
    }
    std::optional<T> item{items_[head % Capacity]};
    head_.store(head + 1, std::memory_order_release);
    return item;
  }

  /// How many items were refused so far. Any thread.
  [[nodiscard]] std::uint64_t overruns() const noexcept { return overruns_.load(std::memory_order_relaxed); }

 private:
  static constexpr std::size_t kCacheLine = 64;

  // Each side keeps what it last saw of the other next to its own index, and looks again only when it must.
  alignas(kCacheLine) std::atomic<std::size_t> tail_{0};
  std::size_t head_seen_ = 0;
  std::atomic<std::uint64_t> overruns_{0};
  alignas(kCacheLine) std::atomic<std::size_t> head_{0};
  std::size_t tail_seen_ = 0;
  alignas(kCacheLine) std::array<T, Capacity> items_{};
};

}  // namespace motionlab
