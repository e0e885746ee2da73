/// @file  Texts from the bus, made harmless for a terminal.
#pragma once

#include <string>
#include <string_view>

namespace motionlab::monitor {

/// Printable UTF-8 stays as it is. Control characters (also the ones from U+0080 to U+009F), characters that
/// turn the direction of writing, and bytes that are no UTF-8 become \n, \t, \xNN or \u{N}; a backslash
/// becomes two. So nobody on the bus can move the cursor, change colours or fake a line.
[[nodiscard]] std::string escaped(std::string_view text);

}  // namespace motionlab::monitor
