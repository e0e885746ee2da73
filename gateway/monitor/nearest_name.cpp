#include "gateway/monitor/nearest_name.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

namespace motionlab::monitor {
namespace {

/// Levenshtein's distance.
std::size_t changes(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= from.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const std::size_t replaced = diagonal + (from[i - 1] == to[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, replaced}));
    }
  }
  return row.back();
}

}  // namespace

std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& names) {
  const std::string* nearest = nullptr;
  std::size_t fewest = 0;
  for (const std::string& name : names) {
    // A part of a name counts as one change only.
    const bool part = wrong.size() >= 3 && name.find(wrong) != std::string::npos;
    const std::size_t needed = part ? 1 : changes(wrong.substr(0, 256), name);
    if (!part && 3 * needed > std::max(name.size(), wrong.size())) continue;
    if (!nearest || needed < fewest) {
      nearest = &name;
      fewest = needed;
    }
  }
  return nearest ? "; do you mean " + *nearest + "?" : "";
}

}  // namespace motionlab::monitor
