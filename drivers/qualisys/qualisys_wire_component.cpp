#include "drivers/qualisys/qualisys_wire_component.hpp"

#include <algorithm>

#include "drivers/qualisys/qualisys_wire_text.hpp"

namespace motionlab::qualisys {

std::optional<Component> component_of(std::string_view word) noexcept {
  word = word.substr(0, word.find(':'));
  const auto found = std::find_if(kComponentWords.begin(), kComponentWords.end(),
                                  [&](const ComponentWord& entry) { return same_name(entry.word, word); });
  return found == kComponentWords.end() ? std::nullopt : std::optional{found->component};
}

std::string_view word_of(Component component) noexcept {
  const auto found = std::find_if(kComponentWords.begin(), kComponentWords.end(),
                                  [&](const ComponentWord& entry) { return entry.component == component; });
  return found == kComponentWords.end() ? std::string_view{} : found->word;
}

}  // namespace motionlab::qualisys
