// The commands of the protocol's text interface. Source: QTM RT Protocol documentation, "Commands".
#include <algorithm>
#include <charconv>
#include <cmath>

#include "drivers/core/error.hpp"
#include "simulators/qualisys/qualisys_device.hpp"

namespace motionlab::qualisys {

namespace {

constexpr int kOldestVersionMinor = 8;  // before it, the data had doubles and padding
constexpr std::uint16_t kLowestStreamPort = 1023;
constexpr std::string_view kParseError = "Parse error";
constexpr std::string_view kVersionNotSupported = "Version NOT supported";

/// Components that may be asked for and have no data here.
constexpr std::array<std::string_view, 16> kComponentsWithoutData = {
    "2D",      "2DLin",      "3D",       "3DRes",        "3DNoLabels", "3DNoLabelsRes",
    "6DEuler", "6DEulerRes", "Analog",   "AnalogSingle", "Force",      "ForceSingle",
    "Image",   "GazeVector", "Skeleton", "EyeTracker"};
constexpr std::array<std::string_view, 9> kParameterGroups = {"Calibration", "3D",       "Analog",
                                                              "Force",       "Image",    "GazeVector",
                                                              "EyeTracker",  "Skeleton", "Skeleton:global"};

std::vector<std::string_view> split(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\n";
  std::vector<std::string_view> words;
  for (std::size_t begin = text.find_first_not_of(kBlank); begin != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kBlank, begin), text.size());
    words.push_back(text.substr(begin, end - begin));
    begin = text.find_first_not_of(kBlank, end);
  }
  return words;
}

template <std::size_t N>
bool is_one_of(const std::array<std::string_view, N>& names, std::string_view word) {
  return std::any_of(names.begin(), names.end(),
                     [&](std::string_view name) { return same_name(name, word); });
}

template <class Number>
std::optional<Number> number(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// What follows `prefix` in the word, if it begins so.
std::optional<std::string_view> after(std::string_view prefix, std::string_view word) {
  if (!same_name(word.substr(0, prefix.size()), prefix)) return std::nullopt;
  return word.substr(prefix.size());
}

std::optional<Components> components(std::span<const std::string_view> words) {
  Components asked;
  for (const std::string_view word : words) {
    if (same_name(word, "6D"))
      asked.bodies = true;
    else if (same_name(word, "6DRes"))
      asked.bodies_with_residual = true;
    else if (same_name(word, "Timecode"))
      asked.timecode = true;
    else if (!is_one_of(kComponentsWithoutData, word.substr(0, word.find(':'))))
      return std::nullopt;
  }
  return words.empty() ? std::nullopt : std::optional{asked};
}

/// `UDP:port` or `UDP:address:port`; without an address it is the client's own.
std::optional<Endpoint> udp_endpoint(std::string_view after_udp, Endpoint peer) {
  Endpoint to = peer;
  const std::size_t colon = after_udp.rfind(':');
  if (colon != std::string_view::npos) {
    try {
      to.address = Endpoint::parse_address(after_udp.substr(0, colon));
    } catch (const StartupError&) {
      return std::nullopt;
    }
    after_udp.remove_prefix(colon + 1);
  }
  const auto port = number<std::uint16_t>(after_udp);
  if (!port || *port < kLowestStreamPort) return std::nullopt;
  to.port = *port;
  return to;
}

}  // namespace

void QualisysDevice::on_command(SessionId id, Session& session, std::string_view text) {
  const Words words = split(text);
  const auto is = [&](std::string_view name) { return !words.empty() && same_name(words[0], name); };
  if (is("Version")) return version(id, session, words);
  if (is("QTMVersion")) return reply(id, "QTM Version is " + config_.qtm_version);
  if (is("ByteOrder")) return reply(id, "Byte order is little endian");
  if (is("GetState") || is("GetLastEvent")) return send(id, encode_event(state_));
  if (is("TakeControl")) return take_control(id);
  if (is("ReleaseControl")) return release_control(id);
  // What follows differs between versions. A client that asked for none has 1.1, which is not spoken here.
  const bool versioned = is("GetParameters") || is("StreamFrames") || is("GetCurrentFrame");
  if (versioned && session.version_minor < kOldestVersionMinor) return refuse(id, kVersionNotSupported);
  if (is("GetParameters")) return parameters(id, session, words);
  if (is("StreamFrames")) return stream_frames(id, session, words);
  if (is("GetCurrentFrame")) return current_frame(id, session, words);
  refuse(id, kParseError);
}

void QualisysDevice::version(SessionId id, Session& session, const Words& words) {
  if (words.size() == 1) return reply(id, "Version is 1." + std::to_string(session.version_minor));
  const auto minor_text = after("1.", words[1]);
  const auto minor = minor_text ? number<int>(*minor_text) : std::nullopt;
  if (!minor || *minor < kOldestVersionMinor || *minor > config_.newest_version_minor || words.size() > 2)
    return refuse(id, kVersionNotSupported);
  session.version_minor = *minor;
  reply(id, "Version set to 1." + std::to_string(*minor));
}

void QualisysDevice::parameters(SessionId id, const Session& session, const Words& words) {
  XmlContent content{.version_minor = session.version_minor, .rate_hz = config_.rate_hz, .body_list = list_};
  if (words.size() < 2) return refuse(id, kParseError);
  for (std::size_t i = 1; i < words.size(); ++i) {
    const bool all = same_name(words[i], "All");
    const bool general = all || same_name(words[i], "General");
    const bool bodies = all || same_name(words[i], "6D");
    if (!general && !bodies && !is_one_of(kParameterGroups, words[i])) return refuse(id, kParseError);
    content.general = content.general || general;
    content.bodies = content.bodies || bodies;
  }
  send(id, encode_text(PacketType::xml, write_parameters_xml(content)));
}

/// No text answers this command: clients pair answers with commands by order.
void QualisysDevice::stream_frames(SessionId id, Session& session, const Words& words) {
  if (words.size() == 2 && same_name(words[1], "Stop")) {
    session.stream.reset();
    return;
  }
  if (words.size() < 3) return refuse(id, kParseError);
  Stream stream;
  if (same_name(words[1], "AllFrames")) {
    stream.divisor = 1;
  } else if (const auto divisor = after("FrequencyDivisor:", words[1])) {
    stream.divisor = number<std::uint64_t>(*divisor).value_or(0);
    if (stream.divisor == 0) return refuse(id, kParseError);
  } else if (const auto frequency = after("Frequency:", words[1])) {
    const double rate_hz = number<double>(*frequency).value_or(0.0);
    if (!(rate_hz > 0.0)) return refuse(id, kParseError);
    stream.share = std::min(rate_hz / config_.rate_hz, 1.0);
  } else {
    return refuse(id, kParseError);
  }
  std::span<const std::string_view> rest{words.begin() + 2, words.end()};
  if (const auto udp = after("UDP:", rest.front())) {
    stream.udp = udp_endpoint(*udp, session.peer);
    if (!stream.udp) return refuse(id, kParseError);
    rest = rest.subspan(1);
  }
  const auto asked = components(rest);
  if (!asked) return refuse(id, kParseError);
  stream.components = *asked;
  session.stream = stream;
  if (!measuring()) send(id, encode_no_more_data());
}

void QualisysDevice::current_frame(SessionId id, Session& session, const Words& words) {
  const auto asked = components(std::span{words}.subspan(1));
  if (!asked) return refuse(id, kParseError);
  if (!measuring()) return send(id, encode_no_more_data());
  session.current_frame = *asked;
}

void QualisysDevice::take_control(SessionId id) {
  if (master_ == id) return reply(id, "You are already master");
  if (master_) {
    const Endpoint peer = sessions_.at(*master_).peer;
    return refuse(id,
                  address_to_string(peer.address) + " (" + std::to_string(peer.port) + ") is already master");
  }
  master_ = id;
  reply(id, "You are now master");
}

void QualisysDevice::release_control(SessionId id) {
  if (master_ != id) return reply(id, "You are already a regular client");
  master_.reset();
  reply(id, "You are now a regular client");
}

}  // namespace motionlab::qualisys
