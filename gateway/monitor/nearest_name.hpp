/// @file  What somebody may have meant who wrote a name that does not exist.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace motionlab::monitor {

/// "; do you mean NAME?" with the name that needs the fewest changes of single characters, or nothing when
/// every name would need more than a third of its characters changed and none contains the wrong one.
[[nodiscard]] std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& names);

}  // namespace motionlab::monitor
