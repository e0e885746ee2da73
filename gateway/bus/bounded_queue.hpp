/// @file  `BoundedQueue<T>`: many threads put in, one takes out, nobody waits, nothing is allocated after
/// birth.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <optional>
#include <type_traits>
#include <vector>

namespace motionlab::bus {

/// A ring of cells, each with a turn that says whose it is. A producer draws a ticket, fills its cell and
/// passes the turn to the consumer, which passes it on to the producer of the next round. After D. Vyukov's
/// bounded queue. Full: the new sample is refused, the old ones stay.
template <class T>
requires std::is_trivially_copyable_v<T>
class BoundedQueue {
 public:
  /// @param capacity  rounded up to a power of two
  explicit BoundedQueue(std::size_t capacity) : cells_(std::bit_ceil(capacity)) {
    for (std::size_t i = 0; i < cells_.size(); ++i) cells_[i].turn.store(i, std::memory_order_relaxed);
  }

  /// Puts a value in; false when full. Any thread. Lock-free.
  /// @param left_free  cells that shall stay free behind it, for values that matter more; less than the
  /// capacity
  [[nodiscard]] bool push(const T& value, std::size_t left_free = 0) noexcept {
    std::size_t ticket = next_ticket_.load(std::memory_order_relaxed);
    for (;;) {
      Cell& cell = cells_[ticket % cells_.size()];
      const std::size_t turn = cell.turn.load(std::memory_order_acquire);
      if (turn == ticket) {
        const std::size_t behind = ticket + left_free;
        if (cells_[behind % cells_.size()].turn.load(std::memory_order_acquire) < behind) return false;
        if (!next_ticket_.compare_exchange_weak(ticket, ticket + 1, std::memory_order_relaxed)) continue;
        cell.value = value;
        cell.turn.store(ticket + 1, std::memory_order_release);
        return true;
      }
      if (turn < ticket) return false;
      ticket = next_ticket_.load(std::memory_order_relaxed);
    }
  }

  /// The oldest value; nothing when empty. One thread. Wait-free.
  [[nodiscard]] std::optional<T> pop() noexcept {
    Cell& cell = cells_[taken_ % cells_.size()];
    if (cell.turn.load(std::memory_order_acquire) != taken_ + 1) return std::nullopt;
    const std::optional<T> value{cell.value};
    cell.turn.store(taken_ + cells_.size(), std::memory_order_release);
    ++taken_;
    return value;
  }

  [[nodiscard]] std::size_t capacity() const noexcept { return cells_.size(); }

 private:
  struct Cell {
    std::atomic<std::size_t> turn{0};
    T value{};
  };

  std::vector<Cell> cells_;
  alignas(64) std::atomic<std::size_t> next_ticket_{0};
  alignas(64) std::size_t taken_ = 0;
};

}  // namespace motionlab::bus
