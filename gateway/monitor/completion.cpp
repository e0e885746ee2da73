#include "gateway/monitor/completion.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <sstream>
#include <string_view>
#include <utility>

namespace motionlab::monitor {
namespace {

struct Word {
  std::vector<std::string> names;  ///< "--json", "-h"; empty for a positional
  std::string kind;                ///< "INT", "TOPIC"; empty for a flag
  std::string what;
  std::vector<std::string> choices;
  bool repeats = false;
};

/// "TEXT:{world,em1500}" -> world, em1500
std::vector<std::string> choices_in(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.find('}', open);
  if (open == std::string::npos || close == std::string::npos) return {};
  std::vector<std::string> choices;
  std::istringstream list{type.substr(open + 1, close - open - 1)};
  for (std::string one; std::getline(list, one, ',');) choices.push_back(one);
  return choices;
}

std::vector<Word> words_of(const CLI::App& app, const ChoicesByKind& by_kind) {
  std::vector<Word> words;
  for (const CLI::Option* const option : app.get_options()) {
    Word word;
    for (const std::string& name : option->get_snames()) word.names.push_back("-" + name);
    for (const std::string& name : option->get_lnames()) word.names.push_back("--" + name);
    word.what = option->get_description();
    word.repeats = option->get_items_expected_max() > 1 ||
                   option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
    if (option->get_items_expected_max() > 0) {
      const std::string type = option->get_type_name();
      word.kind = type.substr(0, type.find(':'));
      word.choices = choices_in(type);
      if (const auto found = by_kind.find(word.kind); found != by_kind.end()) word.choices = found->second;
    }
    words.push_back(std::move(word));
  }
  return words;
}

/// Options of the programs above may follow the name of a command.
std::vector<Word> all_words_of(const CLI::App& app, const ChoicesByKind& by_kind) {
  std::vector<Word> words = words_of(app, by_kind);
  for (const CLI::App* above = app.get_parent(); above; above = above->get_parent()) {
    for (Word& word : words_of(*above, by_kind)) {
      const bool help = std::ranges::find(word.names, "--help") != word.names.end();
      if (!word.names.empty() && !help) words.push_back(std::move(word));
    }
  }
  return words;
}

template <class F>
void for_each_command(const CLI::App& app, const std::string& path, F&& f) {
  f(app, path);
  for (const CLI::App* const sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    for_each_command(*sub, path + " " + sub->get_name(), f);
  }
}

std::vector<const CLI::App*> subcommands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::string joined(const std::vector<std::string>& texts, std::string_view between) {
  std::string all;
  for (const std::string& text : texts) all.append(all.empty() ? "" : between).append(text);
  return all;
}

/// Within single quotes, in an `_arguments` specification.
std::string zsh_text(const std::string& text) {
  std::string safe;
  for (const char character : text) {
    if (character == '\'') {
      safe += "'\\''";
    } else if (character == '[' || character == ']' || character == ':' || character == '\\') {
      safe += '\\';
      safe += character;
    } else {
      safe += character == '\n' ? ' ' : character;
    }
  }
  return safe;
}

/// ":TOPIC:(motionlab/mru …)"
std::string zsh_value(const Word& word) {
  if (word.kind.empty()) return "";
  const std::string action =
      word.choices.empty() ? word.kind == "FILE" ? "_files" : " " : "(" + joined(word.choices, " ") + ")";
  return ":" + zsh_text(word.kind) + ":" + action;
}

std::string zsh_function(std::string path) {
  for (char& character : path) {
    if (character == ' ' || character == '-') character = '_';
  }
  return "_" + path;
}

}  // namespace

std::string bash_completion(const CLI::App& app, const ChoicesByKind& choices) {
  const std::string name = app.get_name();
  std::string walk, cases;
  for_each_command(app, name, [&](const CLI::App& command, const std::string& path) {
    if (path != name) walk += "      '" + path + "') path+=\" $word\" ;;\n";
    std::vector<std::string> offered;
    std::string values;
    for (const CLI::App* const sub : subcommands(command)) offered.push_back(sub->get_name());
    for (const Word& word : all_words_of(command, choices)) {
      offered.insert(offered.end(), word.names.begin(), word.names.end());
      if (word.names.empty()) offered.insert(offered.end(), word.choices.begin(), word.choices.end());
      if (word.names.empty() || word.kind.empty()) continue;
      values += "        " + joined(word.names, " | ") + ") words='" + joined(word.choices, " ") + "' ;;\n";
    }
    cases += "    '" + path + "')\n      case \"$previous\" in\n" + values + "        *) words='" +
             joined(offered, " ") + "' ;;\n      esac ;;\n";
  });
  return "# Completion of " + name + " for bash; made by \"" + name + R"( completion bash".
_)" + name +
         R"(() {
  local current="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD - 1]}"
  local path=')" +
         name + R"(' words='' word i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    word="${COMP_WORDS[i]}"
    case "$path $word" in
)" + walk +
         R"(    esac
  done
  case "$path" in
)" + cases +
         R"(  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}
complete -o default -F _)" +
         name + " " + name + "\n";
}

std::string zsh_completion(const CLI::App& app, const ChoicesByKind& choices) {
  const std::string name = app.get_name();
  std::string functions;
  for_each_command(app, name, [&](const CLI::App& command, const std::string& path) {
    std::string text =
        zsh_function(path) + "() {\n  local curcontext=\"$curcontext\" state line\n  _arguments -C";
    int position = 0;
    for (const Word& word : all_words_of(command, choices)) {
      text += " \\\n    '";
      if (word.names.empty()) {
        text += (word.repeats ? "*" : std::to_string(++position)) + zsh_value(word) + "'";
        continue;
      }
      if (word.repeats) {
        text += "*'";
      } else {
        text += "(" + joined(word.names, " ") + ")'";
      }
      text += word.names.size() > 1 ? "{" + joined(word.names, ",") + "}" : word.names.front();
      text += "'[" + zsh_text(word.what) + "]" + zsh_value(word) + "'";
    }
    const auto subs = subcommands(command);
    if (!subs.empty()) {
      text +=
          " \\\n    '1: :->command' '*:: :->arguments'\n  case $state in\n    command)\n      local -a "
          "commands\n"
          "      commands=(";
      for (const CLI::App* const sub : subs) {
        text += "\n        '" + sub->get_name() + ":" + zsh_text(sub->get_description()) + "'";
      }
      text += ")\n      _describe 'command' commands ;;\n    arguments)\n      case $line[1] in\n";
      for (const CLI::App* const sub : subs) {
        text += "        " + sub->get_name() + ") " + zsh_function(path + " " + sub->get_name()) + " ;;\n";
      }
      text += "      esac ;;\n  esac";
    }
    functions += text + "\n}\n\n";
  });
  return "#compdef " + name + "\n# Completion of " + name + " for zsh; made by \"" + name +
         " completion zsh\".\n\n" + functions + zsh_function(name) + " \"$@\"\n";
}

}  // namespace motionlab::monitor
