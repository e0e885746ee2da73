/// @file  Where configuration files are looked for when a program is not told.
#pragma once

#include <filesystem>
#include <string_view>

namespace motionlab {

/// The first that exists of $MOTIONLAB_CONFIG_DIR/NAME, ./deploy/config/NAME (a source tree) and
/// /etc/motionlab/NAME.
/// @throws StartupError that names all places
[[nodiscard]] std::filesystem::path find_config(std::string_view name);

}  // namespace motionlab
