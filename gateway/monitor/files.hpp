/// @file  Files that the user names: opened to be read, or made, never written over.
#pragma once

#include <filesystem>
#include <fstream>

namespace motionlab::monitor {

/// @throws StartupError  there is no such file, or it may not be read
[[nodiscard]] std::ifstream open_recording(const std::filesystem::path& file);

/// @throws StartupError  it exists already, or cannot be made
[[nodiscard]] std::ofstream make_file(const std::filesystem::path& file);

/// With the folders above it, unless it is there. @throws StartupError  it cannot be made
void make_folder(const std::filesystem::path& folder);

}  // namespace motionlab::monitor
