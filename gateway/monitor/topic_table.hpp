/// @file  Every topic of the house described at run time, from the one description: the visitors that idl/
/// makes.
///
/// Who prints, records or measures samples works on these tables and needs no code per type.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "drivers/core/text.hpp"
#include "gateway/bus/topics.hpp"

namespace motionlab::monitor {

/// One number, text or choice of a sample. Enumerators are texts: their names.
using Value = std::variant<bool, std::int64_t, std::uint64_t, double, std::string>;
/// All of a sample, arrays flattened, in the order of the IDL.
using Values = std::vector<Value>;

struct Field {
  std::string_view name;
  std::size_t first = 0;  ///< place of its first value in `Values`
  std::size_t count = 1;
  bool is_array = false;
};

struct TopicDescription {
  std::string_view name;
  std::string_view type;  ///< as on DDS, e.g. "motionlab::Mru"
  bus::QosClass qos{};
  std::string_view partition;
  bool paced = false;  ///< sent on at a slower pace than it is made: gaps in its numbers are no loss
  bool keyed = false;
  std::vector<Field> fields;
  std::size_t value_count = 0;

  [[nodiscard]] const Field* field(std::string_view wanted) const;
};

/// One for each .idl file, in their order.
[[nodiscard]] const std::vector<TopicDescription>& every_topic();
[[nodiscard]] const TopicDescription* topic_named(std::string_view name);
[[nodiscard]] const TopicDescription* topic_of_type(std::string_view type);

namespace detail {

template <class T>
struct Shape {
  static constexpr std::size_t kCount = 1;
  static constexpr bool kIsArray = false;
};
template <class T, std::size_t N>
struct Shape<std::array<T, N>> {
  static constexpr std::size_t kCount = N;
  static constexpr bool kIsArray = true;
};

template <class T>
Value value_of(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return std::string{to_string(value)};
  } else if constexpr (std::is_same_v<T, bool>) {
    return value;
  } else if constexpr (std::is_floating_point_v<T>) {
    return static_cast<double>(value);
  } else if constexpr (std::is_signed_v<T>) {
    return static_cast<std::int64_t>(value);
  } else {
    return static_cast<std::uint64_t>(value);
  }
}
template <std::size_t N>
Value value_of(const Text<N>& text) {
  return text.str();
}

}  // namespace detail

template <class T>
[[nodiscard]] Values values_of(const T& sample) {
  Values values;
  T::fields(sample, [&values](std::string_view, const auto& field) {
    if constexpr (detail::Shape<std::remove_cvref_t<decltype(field)>>::kIsArray) {
      for (const auto& element : field) values.push_back(detail::value_of(element));
    } else {
      values.push_back(detail::value_of(field));
    }
  });
  return values;
}

/// Which of the topic's instances: the values of its keys, "qualisys/load". Empty for a topic without keys.
template <class T>
[[nodiscard]] std::string instance_of(const T& sample) {
  std::string name;
  if constexpr (T::kKeyed) {
    for (const std::string_view part : sample.key()) {
      if (!name.empty()) name += '/';
      name += part;
    }
  }
  return name;
}

/// The number in a field, when there is such a field and it holds a whole one. Of an array: the first.
[[nodiscard]] std::optional<std::int64_t> integer_in(const TopicDescription& topic, const Values& values,
                                                     std::string_view field);
/// A stamp of the sample in ns, when it has this one and the stamp can be one: from 0 to the year 2096. So
/// the difference of two stamps is always a number, whatever a stranger sends.
[[nodiscard]] std::optional<std::int64_t> stamp_in(const TopicDescription& topic, const Values& values,
                                                   std::string_view field);

}  // namespace motionlab::monitor
