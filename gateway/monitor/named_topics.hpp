/// @file  The topics of the house that somebody named, as rows of `bus::kTopicList`.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace motionlab::monitor {

/// "mru" means "motionlab/mru" as well. In the order given.
/// @throws StartupError  naming the one that does not exist and the nearest that does
[[nodiscard]] std::vector<std::size_t> rows_named(const std::vector<std::string>& names);

}  // namespace motionlab::monitor
