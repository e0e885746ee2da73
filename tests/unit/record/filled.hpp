/// @file  Samples with something in every field.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>

#include "drivers/core/text.hpp"

namespace motionlab::record {

/// Fills each field with another value; another seed, other values.
class Filler {
 public:
  explicit Filler(std::uint64_t seed) : next_(seed) {}

  template <class Value>
  void operator()(std::string_view, Value& value) {
    fill(value);
  }

 private:
  template <class Value>
  void fill(Value& value) {
    ++next_;
    if constexpr (std::is_enum_v<Value>) {
      value = static_cast<Value>(next_ % 2);
    } else if constexpr (std::is_same_v<Value, bool>) {
      value = next_ % 2 == 0;
    } else if constexpr (std::is_floating_point_v<Value>) {
      value = -1.0 / static_cast<double>(next_);
    } else {
      value = static_cast<Value>(next_ * 7919);
    }
  }
  template <std::size_t N>
  void fill(Text<N>& text) {
    text.assign("text " + std::to_string(++next_));
  }
  template <class Value, std::size_t N>
  void fill(std::array<Value, N>& values) {
    for (auto& value : values) fill(value);
  }

  std::uint64_t next_;
};

template <class T>
[[nodiscard]] T filled(std::uint64_t seed) {
  T sample{};
  Filler filler(seed);
  T::fields(sample, filler);
  return sample;
}

}  // namespace motionlab::record
