/// @file  Completion of the command line in bash and zsh, made from the same description that reads it.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace motionlab::monitor {

/// What may stand for a value, by the name of its kind in the help ("TOPIC"). Values of other kinds are
/// completed from the choices that their option checks, or as file names.
using ChoicesByKind = std::map<std::string, std::vector<std::string>>;

/// A script for bash: put it where bash-completion looks, or `source` it. Needs nothing but bash.
[[nodiscard]] std::string bash_completion(const CLI::App& app, const ChoicesByKind& choices);

/// A function for zsh: a file `_motionlab` in a folder of its `fpath`.
[[nodiscard]] std::string zsh_completion(const CLI::App& app, const ChoicesByKind& choices);

}  // namespace motionlab::monitor
