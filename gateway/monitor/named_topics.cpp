#include "gateway/monitor/named_topics.hpp"

#include <algorithm>

#include "drivers/core/error.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/monitor/nearest_name.hpp"
#include "gateway/monitor/safe_text.hpp"

namespace motionlab::monitor {

std::vector<std::size_t> rows_named(const std::vector<std::string>& names) {
  std::vector<std::size_t> rows;
  for (const std::string& name : names) {
    const auto found = std::ranges::find_if(bus::kTopicList, [&](const bus::TopicRow& row) {
      return row.name == name || row.name == "motionlab/" + name;
    });
    if (found == bus::kTopicList.end()) {
      std::vector<std::string> known;
      for (const bus::TopicRow& row : bus::kTopicList) known.emplace_back(row.name);
      throw StartupError{"there is no topic " + escaped(name) + did_you_mean(name, known) +
                         " See motionlab topics for what is on the bus"};
    }
    rows.push_back(static_cast<std::size_t>(found - bus::kTopicList.begin()));
  }
  return rows;
}

}  // namespace motionlab::monitor
