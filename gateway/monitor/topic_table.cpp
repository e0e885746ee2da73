#include "gateway/monitor/topic_table.hpp"

#include <algorithm>

namespace motionlab::monitor {
namespace {

template <class T>
TopicDescription described() {
  using Traits = bus::TopicTraits<T>;
  TopicDescription topic{.name = Traits::name,
                         .type = T::kTypeName,
                         .qos = Traits::qos,
                         .partition = Traits::partition,
                         .paced = Traits::paced,
                         .keyed = T::kKeyed,
                         .fields = {}};
  const T sample{};
  T::fields(sample, [&topic](std::string_view name, const auto& field) {
    using Shape = detail::Shape<std::remove_cvref_t<decltype(field)>>;
    topic.fields.push_back({name, topic.value_count, Shape::kCount, Shape::kIsArray});
    topic.value_count += Shape::kCount;
  });
  return topic;
}

template <class Key>
const TopicDescription* find(std::string_view wanted, Key key) {
  const auto found = std::ranges::find(every_topic(), wanted, key);
  return found == every_topic().end() ? nullptr : &*found;
}

}  // namespace

const std::vector<TopicDescription>& every_topic() {
  static const std::vector<TopicDescription> topics{
#define MOTIONLAB_DESCRIBE(Type) described<topic::Type>(),
      MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_DESCRIBE)
#undef MOTIONLAB_DESCRIBE
  };
  return topics;
}

const TopicDescription* topic_named(std::string_view name) {
  return find(name, &TopicDescription::name);
}

const TopicDescription* topic_of_type(std::string_view type) {
  return find(type, &TopicDescription::type);
}

const Field* TopicDescription::field(std::string_view wanted) const {
  const auto found = std::ranges::find(fields, wanted, &Field::name);
  return found == fields.end() ? nullptr : &*found;
}

std::optional<std::int64_t> integer_in(const TopicDescription& topic, const Values& values,
                                       std::string_view field) {
  const Field* const found = topic.field(field);
  if (!found) return std::nullopt;
  const Value& value = values[found->first];
  if (const auto* const number = std::get_if<std::int64_t>(&value)) return *number;
  if (const auto* const number = std::get_if<std::uint64_t>(&value))
    return static_cast<std::int64_t>(*number);
  return std::nullopt;
}

std::optional<std::int64_t> stamp_in(const TopicDescription& topic, const Values& values,
                                     std::string_view field) {
  constexpr std::int64_t kYear2096 = 4'000'000'000'000'000'000;
  const auto stamp = integer_in(topic, values, field);
  return stamp && *stamp >= 0 && *stamp <= kYear2096 ? stamp : std::nullopt;
}

}  // namespace motionlab::monitor
