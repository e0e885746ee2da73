#include "gateway/monitor/field_selection.hpp"

#include <charconv>

#include "drivers/core/error.hpp"
#include "gateway/monitor/nearest_name.hpp"
#include "gateway/monitor/safe_text.hpp"

namespace motionlab::monitor {
namespace {

std::string in_topic(const TopicDescription& topic) {
  return std::string{" in "}.append(topic.name);
}

std::string last_index(const Field& field) {
  return std::to_string(field.count - 1);
}

Selected find_path(const TopicDescription& topic, const std::string& path) {
  const std::size_t bracket = path.find('[');
  const std::string name = path.substr(0, bracket);
  const Field* const field = topic.field(name);
  if (!field) {
    std::vector<std::string> names;
    for (const Field& each : topic.fields) names.emplace_back(each.name);
    std::string all;
    for (const std::string& each : names) all += (all.empty() ? "" : " ") + each;
    throw StartupError{"there is no field " + escaped(name) + in_topic(topic) + did_you_mean(name, names) +
                       " It has: " + all};
  }
  if (bracket == std::string::npos) return {path, field->first, field->count, field->is_array};
  if (!field->is_array)
    throw StartupError{name + in_topic(topic) + " is a single value: leave the [...] away"};

  std::size_t index = 0;
  const char* const begin = path.data() + bracket + 1;
  const char* const end = path.data() + path.size();
  const auto [rest, error] = std::from_chars(begin, end, index);
  if (error != std::errc{} || rest + 1 != end || *rest != ']') {
    throw StartupError{escaped(path) + " is no path to a field: write it like " + name + "[" +
                       last_index(*field) + "]"};
  }
  if (index >= field->count) {
    throw StartupError{name + in_topic(topic) + " has the elements [0] to [" + last_index(*field) +
                       "], not [" + std::to_string(index) + "]"};
  }
  return {path, field->first + index, 1, false};
}

}  // namespace

std::vector<Selected> select_fields(const TopicDescription& topic, const std::vector<std::string>& paths) {
  std::vector<Selected> selected;
  if (paths.empty()) {
    for (const Field& field : topic.fields) {
      selected.push_back({std::string{field.name}, field.first, field.count, field.is_array});
    }
  }
  for (const std::string& path : paths) selected.push_back(find_path(topic, path));
  return selected;
}

}  // namespace motionlab::monitor
