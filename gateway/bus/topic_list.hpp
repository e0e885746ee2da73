/// @file  Every topic as a row of one table, for those who treat all topics alike: taps, recorders, bridges.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

#include "gateway/bus/topics.hpp"
#include "idl/schemas.hpp"

namespace motionlab::bus {

struct TopicRow {
  std::string_view name;       ///< "motionlab/mru"
  std::string_view type_name;  ///< "motionlab::Mru"
  std::string_view idl;        ///< the .idl text, includes inlined
  QosClass qos = QosClass::sensor;
  double period_s = 0;
  std::string_view partition;
  bool keyed = false;
  bool every_sample_counts = false;
};

namespace detail {

template <class T>
inline constexpr TopicRow kRow{TopicTraits<T>::name,
                               T::kTypeName,
                               topic::kSchema<T>,
                               TopicTraits<T>::qos,
                               TopicTraits<T>::period_s,
                               TopicTraits<T>::partition,
                               T::kKeyed,
                               kEverySampleCounts<T>};

}  // namespace detail

#define MOTIONLAB_ROW(Type) detail::kRow<topic::Type>,
inline constexpr auto kTopicList = std::to_array<TopicRow>({MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_ROW)});
#undef MOTIONLAB_ROW

/// Its place in `kTopicList`.
template <class T>
[[nodiscard]] constexpr std::size_t topic_index() {
  std::size_t index = 0;
  while (kTopicList[index].name != TopicTraits<T>::name) ++index;
  return index;
}

}  // namespace motionlab::bus
