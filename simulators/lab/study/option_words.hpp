/// @file  Options that do not go together, refused with those that do.
#pragma once

#include <CLI/CLI.hpp>
#include <string_view>
#include <vector>

namespace motionlab::study {

/// @param option  the one that decides, without dashes. @param with  it and its value, as typed
/// @param these   names of the options that go with it
/// @throws StartupError when any other was given
void allow_only(const CLI::App& app, std::string_view option, std::string_view with,
                const std::vector<std::string_view>& these);

}  // namespace motionlab::study
