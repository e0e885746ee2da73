#include "simulators/lab/study/option_words.hpp"

#include <algorithm>
#include <string>

#include "drivers/core/error.hpp"

namespace motionlab::study {

void allow_only(const CLI::App& app, std::string_view option, std::string_view with,
                const std::vector<std::string_view>& these) {
  for (const CLI::Option* given : app.get_options()) {
    const std::string name = given->get_single_name();
    if (given->count() == 0 || name == option || std::find(these.begin(), these.end(), name) != these.end()) {
      continue;
    }
    std::string sentence = "--" + name + " does not go with " + std::string(with) + "; these do: ";
    for (const auto& word : these) sentence.append(&word == &these.front() ? "--" : ", --").append(word);
    throw StartupError(sentence);
  }
}

}  // namespace motionlab::study
