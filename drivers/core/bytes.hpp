/// @file  Bytes in, numbers out: a bounds-checked cursor for reading and one for writing, either byte order.
/// Knows endianness and nothing else: no socket, no unit, no protocol.
#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace motionlab {

using Bytes = std::span<const std::uint8_t>;
using MutableBytes = std::span<std::uint8_t>;
using ByteBuffer = std::vector<std::uint8_t>;

/// The bytes of a text, without a terminator.
[[nodiscard]] inline Bytes as_bytes(std::string_view text) noexcept {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// The text of some bytes; the view lives as long as the bytes.
[[nodiscard]] inline std::string_view as_text(Bytes bytes) noexcept {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

template <class T>
concept WireScalar = (std::integral<T> || std::floating_point<T>)&&sizeof(T) <= 8;

namespace detail {
template <std::size_t N>
struct UnsignedOfSize;
template <>
struct UnsignedOfSize<1> {
  using Type = std::uint8_t;
};
template <>
struct UnsignedOfSize<2> {
  using Type = std::uint16_t;
};
template <>
struct UnsignedOfSize<4> {
  using Type = std::uint32_t;
};
template <>
struct UnsignedOfSize<8> {
  using Type = std::uint64_t;
};
}  // namespace detail

/// Reads one scalar of the given byte order. @pre from.size() >= sizeof(T)
template <WireScalar T, std::endian Order>
[[nodiscard]] T load(Bytes from) noexcept {
  using Unsigned = typename detail::UnsignedOfSize<sizeof(T)>::Type;
  Unsigned raw = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    const std::size_t shift = 8 * (Order == std::endian::little ? i : sizeof(T) - 1 - i);
    raw = static_cast<Unsigned>(raw | static_cast<Unsigned>(static_cast<Unsigned>(from[i]) << shift));
  }
  return std::bit_cast<T>(raw);
}

/// Writes one scalar in the given byte order. @pre to.size() >= sizeof(T)
template <std::endian Order, WireScalar T>
void store(MutableBytes to, T value) noexcept {
  using Unsigned = typename detail::UnsignedOfSize<sizeof(T)>::Type;
  const auto raw = std::bit_cast<Unsigned>(value);
  for (std::size_t i = 0; i < sizeof(T); ++i) {
    const std::size_t shift = 8 * (Order == std::endian::little ? i : sizeof(T) - 1 - i);
    to[i] = static_cast<std::uint8_t>(raw >> shift);
  }
}

/// Reads scalars one after another. A read beyond the end yields zero and makes `ok()` false for good, so
/// that a parser may read a whole layout and ask once.
template <std::endian Order>
class Reader {
 public:
  explicit Reader(Bytes bytes) noexcept : bytes_(bytes) {}

  template <WireScalar T>
  [[nodiscard]] T read() noexcept {
    if (remaining() < sizeof(T)) {
      fail();
      return T{};
    }
    const T value = load<T, Order>(bytes_.subspan(position_, sizeof(T)));
    position_ += sizeof(T);
    return value;
  }

  /// The next n bytes, or an empty span when fewer remain.
  [[nodiscard]] Bytes take(std::size_t n) noexcept {
    if (remaining() < n) {
      fail();
      return {};
    }
    const Bytes taken = bytes_.subspan(position_, n);
    position_ += n;
    return taken;
  }

  void skip(std::size_t n) noexcept { (void)take(n); }
  [[nodiscard]] std::size_t position() const noexcept { return position_; }
  [[nodiscard]] std::size_t remaining() const noexcept { return bytes_.size() - position_; }
  [[nodiscard]] bool ok() const noexcept { return ok_; }

 private:
  void fail() noexcept {
    ok_ = false;
    position_ = bytes_.size();
  }

  Bytes bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

/// Writes scalars one after another into a fixed buffer. A write beyond the end is dropped and makes `ok()`
/// false.
template <std::endian Order>
class Writer {
 public:
  explicit Writer(MutableBytes bytes) noexcept : bytes_(bytes) {}

  template <WireScalar T>
  void write(T value) noexcept {
    if (bytes_.size() - position_ < sizeof(T)) {
      ok_ = false;
      return;
    }
    store<Order>(bytes_.subspan(position_, sizeof(T)), value);
    position_ += sizeof(T);
  }

  void write_bytes(Bytes from) noexcept {
    if (bytes_.size() - position_ < from.size()) {
      ok_ = false;
      return;
    }
    if (!from.empty()) std::memcpy(bytes_.data() + position_, from.data(), from.size());
    position_ += from.size();
  }

  [[nodiscard]] std::size_t position() const noexcept { return position_; }
  [[nodiscard]] bool ok() const noexcept { return ok_; }
  [[nodiscard]] Bytes written() const noexcept { return bytes_.first(position_); }

 private:
  MutableBytes bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

using LittleReader = Reader<std::endian::little>;
using BigReader = Reader<std::endian::big>;
using LittleWriter = Writer<std::endian::little>;
using BigWriter = Writer<std::endian::big>;

}  // namespace motionlab
