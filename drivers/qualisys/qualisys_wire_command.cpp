#include "drivers/qualisys/qualisys_wire_command.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "drivers/qualisys/qualisys_wire_text.hpp"

namespace motionlab::qualisys {

namespace {

constexpr std::uint16_t kLowestStreamPort = 1023;
constexpr Fault kParseError{Reason::refused, "Parse error"};
constexpr std::array<std::string_view, 8> kGroupsWithoutContent = {
    "Calibration", "Analog", "Force", "Image", "GazeVector", "EyeTracker", "Skeleton", "Skeleton:global"};

/// A command of one word.
template <class T>
Result<Command> alone(Words words, T command) noexcept {
  if (!words.empty()) return kParseError;
  return Command{command};
}

Result<Command> version(Words words) noexcept {
  if (words.empty()) return Command{command::Version{}};
  const auto text = after("1.", words.next());
  const auto minor = text ? number<int>(*text) : std::nullopt;
  return Command{command::Version{minor && *minor >= 0 && words.empty() ? *minor : -1}};
}

Result<Command> parameters(Words words) noexcept {
  ParameterGroups groups;
  if (words.empty()) return kParseError;
  while (!words.empty()) {
    const std::string_view word = words.next();
    const bool all = same_name(word, "All");
    const ParameterGroups asked{all || same_name(word, "General"), all || same_name(word, "6D"),
                                all || same_name(word, "3D")};
    const bool other = std::any_of(kGroupsWithoutContent.begin(), kGroupsWithoutContent.end(),
                                   [&](std::string_view name) { return same_name(name, word); });
    if (asked == ParameterGroups{} && !other) return kParseError;
    groups.general = groups.general || asked.general;
    groups.bodies = groups.bodies || asked.bodies;
    groups.markers = groups.markers || asked.markers;
  }
  return Command{command::GetParameters{groups}};
}

/// The components of all words that are left; none at all is a fault.
std::optional<Components> components(Words words) noexcept {
  Components asked;
  while (!words.empty()) {
    const auto component = component_of(words.next());
    if (!component) return std::nullopt;
    asked.add(*component);
  }
  return asked.empty() ? std::nullopt : std::optional{asked};
}

std::optional<std::uint32_t> address(std::string_view text) noexcept {
  std::uint32_t value = 0;
  for (int part = 0; part < 4; ++part) {
    const std::size_t dot = text.find('.');
    if ((dot == std::string_view::npos) != (part == 3)) return std::nullopt;
    const auto byte = number<std::uint8_t>(text.substr(0, dot));
    if (!byte) return std::nullopt;
    value = value << 8 | *byte;
    if (part < 3) text.remove_prefix(dot + 1);
  }
  return value;
}

/// `port` or `address:port`
std::optional<command::StreamFrames::Udp> udp(std::string_view text) noexcept {
  command::StreamFrames::Udp to;
  if (const std::size_t colon = text.rfind(':'); colon != std::string_view::npos) {
    const auto found = address(text.substr(0, colon));
    if (!found) return std::nullopt;
    to.address = *found;
    text.remove_prefix(colon + 1);
  }
  const auto port = number<std::uint16_t>(text);
  if (!port || *port < kLowestStreamPort) return std::nullopt;
  to.port = *port;
  return to;
}

Result<Command> stream(Words words) noexcept {
  const std::string_view pace = words.next();
  if (same_name(pace, "Stop")) return alone(words, command::StopStream{});
  command::StreamFrames stream;
  if (const auto divisor = after("FrequencyDivisor:", pace)) {
    stream.divisor = number<std::uint64_t>(*divisor).value_or(0);
    if (stream.divisor == 0) return kParseError;
  } else if (const auto frequency = after("Frequency:", pace)) {
    stream.rate_hz = number<double>(*frequency);
    if (!stream.rate_hz || !std::isfinite(*stream.rate_hz) || *stream.rate_hz <= 0.0) return kParseError;
  } else if (!same_name(pace, "AllFrames")) {
    return kParseError;
  }
  Words behind = words;
  if (const auto target = after("UDP:", behind.next())) {
    stream.udp = udp(*target);
    if (!stream.udp) return kParseError;
    words = behind;
  }
  const auto asked = components(words);
  if (!asked) return kParseError;
  stream.components = *asked;
  return Command{stream};
}

Result<Command> start(Words words) noexcept {
  if (words.empty()) return Command{command::Start{}};
  if (!same_name(words.next(), "RTFromFile")) return kParseError;
  return alone(words, command::Start{true});
}

}  // namespace

Result<Command> parse_command(std::string_view text) noexcept {
  Words words{text};
  const std::string_view name = words.next();
  const auto is = [name](std::string_view wanted) { return same_name(name, wanted); };
  if (is("Version")) return version(words);
  if (is("QTMVersion")) return alone(words, command::QtmVersion{});
  if (is("ByteOrder")) return alone(words, command::ByteOrder{});
  if (is("GetState") || is("GetLastEvent")) return alone(words, command::GetState{});  // renamed with 1.10
  if (is("GetParameters")) return parameters(words);
  if (is("GetCurrentFrame")) {
    const auto asked = components(words);
    if (!asked) return kParseError;
    return Command{command::GetCurrentFrame{*asked}};
  }
  if (is("StreamFrames")) return stream(words);
  if (is("TakeControl")) return Command{command::TakeControl{words.rest()}};
  if (is("ReleaseControl")) return alone(words, command::ReleaseControl{});
  if (is("New")) return alone(words, command::New{});
  if (is("Close")) return alone(words, command::Close{});
  if (is("Start")) return start(words);
  if (is("Stop")) return alone(words, command::Stop{});
  if (is("Trig")) return alone(words, command::Trigger{});
  if (is("SetQTMEvent") || is("Event")) return Command{command::SetEvent{words.rest()}};
  return kParseError;
}

}  // namespace motionlab::qualisys
