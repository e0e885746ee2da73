// Any text as a configuration: it is read or refused with a StartupError, every question about every key
// likewise, and what `--check` prints of it is a configuration with the same content.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "drivers/core/error.hpp"
#include "drivers/core/toml_reader.hpp"

namespace {

using namespace motionlab;

/// The file that the text is laid over: it has one key of every kind, so that laying over is tried, too.
std::filesystem::path base() {
  static const std::filesystem::path path = [] {
    auto made = std::filesystem::temp_directory_path() / "motionlab-toml-fuzz.toml";
    std::ofstream(made) << "n = 1\n[t]\nx = 0.5\nw = 'a'\nl = [1, 2]\n[t.u]\nb = true\n";
    return made;
  }();
  return path;
}

TomlDocument load(std::string_view text) {
  return TomlDocument::load(base(), {}, {{"input", std::string{text}}});
}

template <class Question>
void ask(Question&& question) {
  try {
    (void)question();
  } catch (const StartupError& error) {
    if (std::string_view{error.what()}.find(':') == std::string_view::npos) std::abort();  // it says where
  }
}

/// One question to each key, another one in each table; asking each key everything takes a hundred times
/// longer than reading the text.
void ask_keys(const TomlTable& table, std::size_t which, int depth) {
  for (const std::string_view key : {"n", "x", "w", "l", "b", "t", "u", "period_s", ""}) {
    ask([&]() -> bool {
      switch (which++ % 10) {
        case 0:
          return table.number_or(key, 0.0, Range::positive()) > 0;
        case 1:
          return table.integer_or(key, 1, {0, 5}) > 0;
        case 2:
          return table.boolean_or(key, true);
        case 3:
          return table.text_or(key, "").empty();
        case 4:
          return table.choice_or(key, 0, {"a", "b"}) == 0;
        case 5:
          return table.endpoint_or(key, {}).port == 0;
        case 6:
          return table.texts_or(key, {}).empty();
        case 7:
          return table.numbers(key).empty();
        case 8:
          return table.numbers_or<3>(key, {})[0] > 0;
        default:
          return table.table_or_empty(key).number_or("x", 1.0) > 0;
      }
    });
  }
  if (depth == 0) return;
  for (const TomlTable& inner : table.tables()) ask_keys(inner, which, depth - 1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  ask([&] {
    const TomlDocument document = load({reinterpret_cast<const char*>(data), size});
    const std::string printed = document.effective();
    try {
      if (load(printed).effective() != printed) std::abort();
    } catch (const StartupError&) {
      std::abort();
    }
    ask([&] {
      document.refuse_unknown_keys();
      return true;
    });
    ask_keys(document.root(), size, 4);
    return true;
  });
  return 0;
}
