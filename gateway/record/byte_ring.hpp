/// @file  `ByteRing`: pieces of bytes of any size from one thread to one other. Nobody waits, nothing is
/// allocated after birth.
#pragma once

#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdint>
#include <cstring>

#include "drivers/core/bytes.hpp"

namespace motionlab::record {

/// First in, first out; each piece comes out whole. A piece that finds no room is refused: what is queued
/// already is older and was promised first. Wait-free on both sides.
class ByteRing {
 public:
  /// @param capacity  in bytes, rounded up to a power of two; touched at once, so that pushing meets no new
  /// page
  explicit ByteRing(std::size_t capacity) : bytes_(std::bit_ceil(capacity)) {}

  /// Producer only. False when it does not fit.
  [[nodiscard]] bool push(Bytes piece) noexcept {
    const std::uint64_t tail = tail_.load(std::memory_order_relaxed);
    const std::uint64_t needed = kHead + piece.size();
    if (tail + needed - head_seen_ > bytes_.size()) {
      head_seen_ = head_.load(std::memory_order_acquire);
      if (tail + needed - head_seen_ > bytes_.size()) return false;
    }
    const auto size = static_cast<Size>(piece.size());
    write(tail, {reinterpret_cast<const std::uint8_t*>(&size), kHead});
    write(tail + kHead, piece);
    tail_.store(tail + needed, std::memory_order_release);
    return true;
  }

  /// Consumer only. Moves the oldest piece into `piece`; false when there is none.
  [[nodiscard]] bool pop(ByteBuffer& piece) {
    const std::uint64_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    Size size = 0;
    read(head, {reinterpret_cast<std::uint8_t*>(&size), kHead});
    piece.resize(size);
    read(head + kHead, piece);
    head_.store(head + kHead + size, std::memory_order_release);
    return true;
  }

  [[nodiscard]] std::size_t capacity() const noexcept { return bytes_.size(); }

 private:
  using Size = std::uint32_t;
  static constexpr std::size_t kHead = sizeof(Size);

  void write(std::uint64_t at, Bytes from) noexcept {
    const std::size_t begin = at % bytes_.size();
    const std::size_t first = std::min(from.size(), bytes_.size() - begin);
    if (first > 0) std::memcpy(bytes_.data() + begin, from.data(), first);
    if (first < from.size()) std::memcpy(bytes_.data(), from.data() + first, from.size() - first);
  }
  void read(std::uint64_t at, MutableBytes to) const noexcept {
    const std::size_t begin = at % bytes_.size();
    const std::size_t first = std::min(to.size(), bytes_.size() - begin);
    if (first > 0) std::memcpy(to.data(), bytes_.data() + begin, first);
    if (first < to.size()) std::memcpy(to.data() + first, bytes_.data(), to.size() - first);
  }

  // Positions count up for ever; a place in the buffer is one modulo its size.
  alignas(64) std::atomic<std::uint64_t> tail_{0};
  std::uint64_t head_seen_ = 0;
  alignas(64) std::atomic<std::uint64_t> head_{0};
  alignas(64) ByteBuffer bytes_;
};

}  // namespace motionlab::record
