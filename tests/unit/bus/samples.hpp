/// @file  Samples with every field different, for every topic type, and how to compare them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "drivers/core/text.hpp"
#include "gateway/bus/topics.hpp"

namespace motionlab::bus {

/// A generator of our own, so that the same seed gives the same sample everywhere.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_{seed * 2 + 1} {}
  std::uint64_t next() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return state_;
  }
  std::uint64_t below(std::uint64_t n) { return next() % n; }

 private:
  std::uint64_t state_;
};

class FillAtRandom {
 public:
  explicit FillAtRandom(std::uint64_t seed) : dice_{seed} {}

  template <class Field>
  void operator()(std::string_view, Field& field) {
    fill(field);
  }

 private:
  template <class Value>
  void fill(Value& value) {
    if constexpr (std::is_enum_v<Value>) {
      std::uint32_t count = 0;
      while (to_string(static_cast<Value>(count)) != "?") ++count;
      value = static_cast<Value>(dice_.below(count));
    } else if constexpr (std::is_same_v<Value, bool>) {
      value = dice_.below(2) == 1;
    } else if constexpr (std::is_floating_point_v<Value>) {
      value = static_cast<Value>(static_cast<std::int64_t>(dice_.next())) * 1e-12;
    } else {
      value = static_cast<Value>(dice_.next());
    }
  }
  template <std::size_t N>
  void fill(Text<N>& text) {
    std::string characters(1 + dice_.below(N), 'a');  // often full to the last character
    if (dice_.below(3) == 0) characters.resize(N, 'z');
    for (char& c : characters) c = static_cast<char>('a' + dice_.below(26));
    text.assign(characters);
  }
  template <class Value, std::size_t N>
  void fill(std::array<Value, N>& values) {
    for (Value& value : values) fill(value);
  }

  Dice dice_;
};

template <class T>
T random_sample(std::uint64_t seed) {
  T sample;
  T::fields(sample, FillAtRandom{seed});
  return sample;
}

/// The names of the fields that differ.
template <class T>
std::vector<std::string> differences(const T& a, const T& b) {
  std::vector<std::string> names;
  // zip asks its second argument for accessors, fields for values: walk both by position.
  std::vector<const void*> fields_of_b;
  T::fields(b, [&](std::string_view, const auto& value) { fields_of_b.push_back(&value); });
  std::size_t i = 0;
  T::fields(a, [&](std::string_view name, const auto& value) {
    if (!(value == *static_cast<const std::remove_reference_t<decltype(value)>*>(fields_of_b[i++]))) {
      names.emplace_back(name);
    }
  });
  return names;
}

struct AllTopics {
#define MOTIONLAB_NAME(Type) , topic::Type
  template <class, class... Types>
  struct List {
    template <template <class...> class To>
    using Into = To<Types...>;
  };
  using Types = List<void MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_NAME)>;
#undef MOTIONLAB_NAME
};

}  // namespace motionlab::bus
