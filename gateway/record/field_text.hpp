/// @file  The fields of a sample by name, as texts: to say in which one two samples differ.
#pragma once

#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "drivers/core/sequence.hpp"
#include "drivers/core/text.hpp"

namespace motionlab::record {

/// "qd_radps[2]" and its value, so written that two numbers have the same text only if they have the same
/// bits.
using FieldTexts = std::vector<std::pair<std::string, std::string>>;

namespace detail {

class FieldWriter {
 public:
  explicit FieldWriter(FieldTexts& to) : to_(to) {}

  template <class Value>
  void operator()(std::string_view name, const Value& value) {
    write(prefix_ + std::string(name), value);
  }

 private:
  template <class Value>
  void write(const std::string& name, const Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      to_.emplace_back(name, to_string(value));
    } else if constexpr (std::is_same_v<Value, bool>) {
      to_.emplace_back(name, value ? "true" : "false");
    } else if constexpr (std::is_floating_point_v<Value>) {
      to_.emplace_back(name, number(value));
    } else if constexpr (std::is_arithmetic_v<Value>) {
      to_.emplace_back(name, std::to_string(value));
    } else {
      const std::string outer = std::exchange(prefix_, name + '.');
      Value::fields(value, *this);
      prefix_ = outer;
    }
  }
  template <std::size_t N>
  void write(const std::string& name, const Text<N>& text) {
    to_.emplace_back(name, '"' + text.str() + '"');
  }
  template <class Value, std::size_t N>
  void write(const std::string& name, const std::array<Value, N>& values) {
    write_each(name, values);
  }
  template <class Value, std::size_t N>
  void write(const std::string& name, const Sequence<Value, N>& values) {
    to_.emplace_back(name + ".size", std::to_string(values.size()));
    write_each(name, values);
  }
  template <class Values>
  void write_each(const std::string& name, const Values& values) {
    std::size_t i = 0;
    for (const auto& value : values) write(name + '[' + std::to_string(i++) + ']', value);
  }

  /// The shortest decimal that reads back as the same bits; a NaN with its bits.
  static std::string number(double value) {
    std::array<char, 32> text{};
    char* end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
    std::string result(text.data(), end);
    if (value == value) return result;
    end = std::to_chars(text.data(), text.data() + text.size(), std::bit_cast<std::uint64_t>(value), 16).ptr;
    return result.append(" 0x").append(text.data(), end);
  }

  FieldTexts& to_;
  std::string prefix_;
};

}  // namespace detail

template <class T>
[[nodiscard]] FieldTexts field_texts(const T& sample) {
  FieldTexts texts;
  detail::FieldWriter writer(texts);
  T::fields(sample, writer);
  return texts;
}

}  // namespace motionlab::record
