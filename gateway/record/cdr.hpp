/// @file  Samples as CDR: the encoding of DDS, in which recordings keep them. Little endian, to the bit.
///
/// Unlike the bus, which refuses what no healthy peer would send, this takes every number as it is, NaN
/// included: what went into a control step comes out of its recording.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/sequence.hpp"
#include "drivers/core/text.hpp"

namespace motionlab::record {

/// Before each sample: plain CDR, little endian.
inline constexpr std::array<std::uint8_t, 4> kCdrLittle{0x00, 0x01, 0x00, 0x00};
/// DDS fills up the bytes of a sample to a multiple of four.
inline constexpr std::size_t kDdsPadding = 3;

namespace detail {

/// Visits the fields of a plain struct in order and writes them, each aligned to its own size.
class CdrWriter {
 public:
  explicit CdrWriter(MutableBytes to) noexcept : to_(to) {}

  template <class Value>
  void operator()(std::string_view, const Value& value) noexcept {
    write(value);
  }

  [[nodiscard]] bool ok() const noexcept { return to_.ok(); }
  [[nodiscard]] std::size_t size() const noexcept { return to_.position(); }

 private:
  template <class Value>
  void write(const Value& value) noexcept {
    if constexpr (std::is_enum_v<Value>) {
      write(static_cast<std::uint32_t>(value));
    } else if constexpr (std::is_same_v<Value, bool>) {
      write(static_cast<std::uint8_t>(value ? 1 : 0));
    } else if constexpr (std::is_arithmetic_v<Value>) {
      while (to_.ok() && to_.position() % sizeof(Value) != 0) to_.write(std::uint8_t{0});
      to_.write(value);
    } else {
      Value::fields(value, *this);
    }
  }
  template <std::size_t N>
  void write(const Text<N>& text) noexcept {
    const std::string_view view = text.view();
    write(static_cast<std::uint32_t>(view.size() + 1));
    to_.write_bytes(as_bytes(view));
    to_.write(std::uint8_t{0});
  }
  template <class Value, std::size_t N>
  void write(const std::array<Value, N>& values) noexcept {
    for (const Value& value : values) write(value);
  }
  template <class Value, std::size_t N>
  void write(const Sequence<Value, N>& values) noexcept {
    write(static_cast<std::uint32_t>(values.size()));
    for (const Value& value : values) write(value);
  }

  LittleWriter to_;
};

/// Likewise, and reads them.
class CdrReader {
 public:
  explicit CdrReader(Bytes from) noexcept : from_(from) {}

  template <class Value>
  void operator()(std::string_view, Value& value) noexcept {
    read(value);
  }

  /// @param padding  so many bytes may be left over
  [[nodiscard]] Status status(std::size_t padding) const noexcept {
    if (!from_.ok()) return Fault{Reason::too_short, "a sample is shorter than its fields"};
    if (!good_) return Fault{Reason::bad_value, "a sample has a value that its type cannot have"};
    if (from_.remaining() > padding) return Fault{Reason::too_long, "a sample is longer than its fields"};
    return Done{};
  }

 private:
  template <class Value>
  void read(Value& value) noexcept {
    if constexpr (std::is_enum_v<Value>) {
      std::uint32_t number{};
      read(number);
      value = static_cast<Value>(number);
      if (to_string(value) == "?") refuse(value);
    } else if constexpr (std::is_same_v<Value, bool>) {
      std::uint8_t number{};
      read(number);
      if (number > 1) good_ = false;
      value = number == 1;
    } else if constexpr (std::is_arithmetic_v<Value>) {
      from_.skip((sizeof(Value) - from_.position() % sizeof(Value)) % sizeof(Value));
      value = from_.read<Value>();
    } else {
      Value::fields(value, *this);
    }
  }
  template <std::size_t N>
  void read(Text<N>& text) noexcept {
    std::uint32_t size{};  // with the terminator
    read(size);
    const std::string_view characters = as_text(from_.take(size));
    if (size == 0 || size > N + 1 || characters.find('\0') + 1 != size) return refuse(text);
    text.assign(characters.substr(0, size - 1));
  }
  template <class Value, std::size_t N>
  void read(std::array<Value, N>& values) noexcept {
    for (Value& value : values) read(value);
  }
  template <class Value, std::size_t N>
  void read(Sequence<Value, N>& values) noexcept {
    std::uint32_t size{};
    read(size);
    values.clear();
    if (size > N) return refuse(values);
    for (std::uint32_t i = 0; i < size && from_.ok() && good_; ++i) {
      Value value{};
      read(value);
      values.push(value);
    }
  }
  template <class Value>
  void refuse(Value& value) noexcept {
    value = Value{};
    good_ = false;
  }

  LittleReader from_;
  bool good_ = true;
};

}  // namespace detail

/// Writes a sample, encapsulation header first. Allocates nothing. @returns its size; 0 when it does not fit
template <class T>
[[nodiscard]] std::size_t write_cdr(const T& sample, MutableBytes to) noexcept {
  if (to.size() < kCdrLittle.size()) return 0;
  std::copy(kCdrLittle.begin(), kCdrLittle.end(), to.begin());
  detail::CdrWriter writer(to.subspan(kCdrLittle.size()));
  T::fields(sample, writer);
  return writer.ok() ? kCdrLittle.size() + writer.size() : 0;
}

/// Reads what `write_cdr` writes, and refuses everything else; the sample is then not to be used.
/// @param padding  at most so many bytes may follow, as the header may then say: `kDdsPadding` for what came
/// by DDS
template <class T>
[[nodiscard]] Status read_cdr(Bytes from, T& sample, std::size_t padding = 0) noexcept {
  const std::ptrdiff_t checked = padding == 0 ? kCdrLittle.size() : 2;
  if (from.size() < kCdrLittle.size() ||
      !std::equal(kCdrLittle.begin(), kCdrLittle.begin() + checked, from.begin()))
    return Fault{Reason::bad_header, "a sample is not little-endian CDR"};
  detail::CdrReader reader(from.subspan(kCdrLittle.size()));
  T::fields(sample, reader);
  return reader.status(padding);
}

}  // namespace motionlab::record
