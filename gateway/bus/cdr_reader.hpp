/// @file  Reads a sample from the bytes that DDS carries, and says what is wrong with them.
///
/// Written by hand because the generated reader trusts its peer: it cuts long texts silently, takes any
/// number for an enumerator and any double, and a boolean of 2 leaves it as an exception that ends the
/// process.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <string_view>
#include <type_traits>

#include "drivers/core/text.hpp"
#include "gateway/bus/refusal.hpp"
#include "gateway/bus/topics.hpp"

namespace motionlab::bus {

namespace detail {

/// Visits the fields of a plain struct in order and fills them. After the first refusal it leaves the rest as
/// it is.
template <class T>
class CdrReader {
 public:
  explicit CdrReader(eprosima::fastcdr::Cdr& cdr) : cdr_{cdr} {}

  template <class Field>
  void operator()(std::string_view name, Field& field) {
    nan_allowed_ = std::ranges::find(TopicTraits<T>::may_be_nan, name) != TopicTraits<T>::may_be_nan.end();
    read(field);
  }

  [[nodiscard]] Refusal refusal() const noexcept { return refusal_; }

 private:
  // A number out of its range does not stop the reading: the key must still be found.
  void refuse(Refusal refusal) noexcept {
    if (refusal_ == Refusal::none) refusal_ = refusal;
  }

  template <class Value>
  void read(Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      std::uint32_t number{};
      cdr_ >> number;
      value = static_cast<Value>(number);
      if (to_string(value) == "?") refuse(Refusal::unknown_enum);
    } else {
      cdr_ >> value;
      if constexpr (std::is_floating_point_v<Value>) {
        if (!std::isfinite(value) && !(std::isnan(value) && nan_allowed_)) refuse(Refusal::not_finite);
      }
    }
  }

  template <std::size_t N>
  void read(Text<N>& text) {
    std::uint32_t size{};  // with the terminator
    cdr_ >> size;
    if (size == 0) return;  // some implementations send an empty text so
    std::array<char, N + 1> characters{};
    const std::uint32_t kept = std::min(size, static_cast<std::uint32_t>(N + 1));
    cdr_.deserializeArray(characters.data(), kept);
    if (size > kept) {
      if (!cdr_.jump(size - kept)) throw eprosima::fastcdr::exception::NotEnoughMemoryException{""};
      refuse(Refusal::text_too_long);
    } else if (characters[size - 1] != '\0') {
      refuse(Refusal::malformed);
    }
    text.assign({characters.data(), std::min<std::size_t>(kept, N)});
  }

  template <class Value, std::size_t N>
  void read(std::array<Value, N>& values) {
    for (Value& value : values) read(value);
  }

  eprosima::fastcdr::Cdr& cdr_;
  Refusal refusal_ = Refusal::none;
  bool nan_allowed_ = false;
};

}  // namespace detail

/// Fills `sample` from one serialized payload, encapsulation header first, either byte order. On a refusal
/// the fields that could be read are filled (so that the key names the instance); the others are zero. Never
/// throws.
template <class T>
Refusal read_cdr(char* bytes, std::size_t size, T& sample) noexcept {
  sample = T{};
  try {
    eprosima::fastcdr::FastBuffer buffer{bytes, size};
    eprosima::fastcdr::Cdr cdr{buffer, eprosima::fastcdr::Cdr::DEFAULT_ENDIAN,
                               eprosima::fastcdr::Cdr::DDS_CDR};
    cdr.read_encapsulation();
    detail::CdrReader<T> reader{cdr};
    T::fields(sample, reader);
    return reader.refusal();
  } catch (const std::exception&) {
    return Refusal::malformed;
  }
}

}  // namespace motionlab::bus
