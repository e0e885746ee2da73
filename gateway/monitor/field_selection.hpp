/// @file  Which fields of a topic somebody wants to see.
#pragma once

#include <string>
#include <vector>

#include "gateway/monitor/topic_table.hpp"

namespace motionlab::monitor {

/// A field, or one element of an array.
struct Selected {
  std::string path;  ///< "swing_rad" or "swing_rad[1]"
  std::size_t first = 0;
  std::size_t count = 1;
  bool is_array = false;  ///< all of an array
};

/// Finds each path, in the order given: "wire_length_m", "p_world_load_m" (all of it), "p_world_load_m[2]"
/// (its third element). Without paths: every field.
/// @throws StartupError  naming the field that does not exist and the nearest one that does, or how long the
/// array is
[[nodiscard]] std::vector<Selected> select_fields(const TopicDescription& topic,
                                                  const std::vector<std::string>& paths);

}  // namespace motionlab::monitor
