#include "simulators/lab/settings.hpp"

#include <charconv>
#include <string_view>
#include <system_error>

#include "drivers/core/error.hpp"

namespace motionlab::lab {

namespace {

/// Whether it already is a TOML value; anything else is a text without its quotes.
bool is_value(std::string_view text) {
  constexpr std::string_view kOpening = "\"'[{";
  if (text.empty() || text == "true" || text == "false" ||
      kOpening.find(text.front()) != std::string_view::npos)
    return true;
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size();
}

}  // namespace

Settings Settings::parse(const std::vector<std::string>& texts) {
  Settings settings;
  for (const std::string& written : texts) {
    const std::string source = "--set " + written;
    const auto refuse = [&source](std::string_view why) {
      return StartupError(
          source + ": " + std::string(why) +
          "; write world.TABLE.KEY=VALUE or lab.TABLE.KEY=VALUE, e.g. world.load.mass_kg=36 or "
          "lab.arm.servo_omega_radps=30");
    };
    const auto equals = written.find('=');
    if (equals == std::string::npos) throw refuse("the value is missing");
    const auto dot = written.find('.');
    if (dot > equals) throw refuse("the file is missing");
    const std::string file = written.substr(0, dot), key = written.substr(dot + 1, equals - dot - 1);
    std::string value = written.substr(equals + 1);
    if (key.empty()) throw refuse("the key is missing");
    if (!is_value(value)) value = '"' + value + '"';
    if (file == "world") {
      settings.world.push_back({source, key + " = " + value});
    } else if (file == "lab") {
      settings.lab.push_back({source, key + " = " + value});
    } else {
      throw refuse("there is no file " + file);
    }
  }
  return settings;
}

}  // namespace motionlab::lab
