/// @file  The secret that stands between looking and moving.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace motionlab::console {

/// 128 bits from the kernel, as 32 letters and digits. @throws StartupError when the kernel gives none
[[nodiscard]] std::string make_token();

/// The first line of a file that nobody but its owner can read.
/// @throws StartupError  with what to do: no such file, readable by others, shorter than 16 characters
[[nodiscard]] std::string read_token(const std::filesystem::path& file);

/// Whether they are the same. Takes as long for a wrong one as for a right one of its length.
[[nodiscard]] bool same_token(std::string_view given, std::string_view wanted) noexcept;

}  // namespace motionlab::console
