/// @file  Puts MCAP records together: little-endian numbers, texts and maps with their lengths in front.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "gateway/record/mcap_format.hpp"

namespace motionlab::record {

/// A buffer that grows. Holds any number of records, one after another; keeps its memory when it is cleared.
class RecordBuilder {
 public:
  void clear() noexcept { buffer_.clear(); }
  void begin(Opcode opcode) {
    put(static_cast<std::uint8_t>(opcode));
    begun_ = buffer_.size();
    put(std::uint64_t{0});
  }
  /// Fills in the length of the record that was begun last.
  void end() noexcept { end_with(0); }
  /// Likewise, when so many more bytes of it follow elsewhere.
  void end_with(std::uint64_t more) noexcept {
    const std::uint64_t length = buffer_.size() - begun_ - 8 + more;
    store<std::endian::little>(MutableBytes{buffer_}.subspan(begun_), length);
  }

  template <WireScalar T>
  void put(T value) {
    const std::size_t at = buffer_.size();
    buffer_.resize(at + sizeof(T));
    store<std::endian::little>(MutableBytes{buffer_}.subspan(at), value);
  }
  void put_bytes(Bytes bytes) {
    const std::size_t at = buffer_.size();
    buffer_.resize(at + bytes.size());
    std::ranges::copy(bytes, std::next(buffer_.begin(), static_cast<std::ptrdiff_t>(at)));
  }
  /// 32 bits of length, then the text.
  void put_text(std::string_view text) {
    put(static_cast<std::uint32_t>(text.size()));
    put_bytes(as_bytes(text));
  }
  /// Writes a value's length, in bytes and 32 bits, before what `body` puts.
  template <class Body>
  void put_sized(Body&& body) {
    const std::size_t at = buffer_.size();
    put(std::uint32_t{0});
    body();
    store<std::endian::little>(MutableBytes{buffer_}.subspan(at),
                               static_cast<std::uint32_t>(buffer_.size() - at - 4));
  }
  void put_map(const StringMap& map) {
    put_sized([&] {
      for (const auto& [key, value] : map) {
        put_text(key);
        put_text(value);
      }
    });
  }

  [[nodiscard]] Bytes bytes() const noexcept { return buffer_; }
  [[nodiscard]] std::size_t size() const noexcept { return buffer_.size(); }
  [[nodiscard]] bool empty() const noexcept { return buffer_.empty(); }

 private:
  ByteBuffer buffer_;
  std::size_t begun_ = 0;  ///< where the length of the record is
};

}  // namespace motionlab::record
