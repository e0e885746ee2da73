#include "gateway/console/foxglove.hpp"

#include <nlohmann/json.hpp>

#include <limits>
#include <stdexcept>

#include "gateway/bus/topic_list.hpp"
#include "gateway/console/board.hpp"

namespace motionlab::console::foxglove {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr std::size_t kMostAtOnce = 256;  // entries of one message

constexpr std::string_view kOwnSchema =
    R"({"type":"object","properties":{"t_ns":{"type":"string"},"clients":{"type":"integer"},"taken":{"type":"integer"},"refused":{"type":"integer"},"gateway_listens":{"type":"boolean"}}})";

/// Text of ours; bytes that are no UTF-8 are replaced.
std::string text_of(const ordered_json& value) {
  return value.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

ordered_json channel_json(std::uint32_t channel) {
  ordered_json entry;
  entry["id"] = channel;
  if (channel == kOwnChannel) {
    entry["topic"] = "console/state";
    entry["encoding"] = "json";
    entry["schemaName"] = "console.State";
    entry["schemaEncoding"] = "jsonschema";
    entry["schema"] = kOwnSchema;
    return entry;
  }
  const bus::TopicRow& row = bus::kTopicList[channel - 1];
  entry["topic"] = row.name;
  entry["encoding"] = "cdr";
  entry["schemaName"] = row.type_name;
  entry["schemaEncoding"] = "omgidl";
  entry["schema"] = row.idl;
  return entry;
}

std::uint32_t number(const json& value) {
  if (!value.is_number_integer()) throw std::invalid_argument{"an id is no whole number"};
  const auto wide = value.get<std::int64_t>();
  if (wide < 0 || wide > std::numeric_limits<std::uint32_t>::max()) {
    throw std::invalid_argument{"an id is not in 0…2^32-1"};
  }
  return static_cast<std::uint32_t>(wide);
}

const json& list(const json& message, const char* key) {
  const json& entries = message.at(key);
  if (!entries.is_array() || entries.size() > kMostAtOnce) {
    throw std::invalid_argument{std::string{key} + " is no list of at most " + std::to_string(kMostAtOnce)};
  }
  return entries;
}

std::vector<std::uint32_t> numbers(const json& message, const char* key) {
  std::vector<std::uint32_t> all;
  for (const json& entry : list(message, key)) all.push_back(number(entry));
  return all;
}

ClientText read(const json& message) {
  const std::string op = message.at("op").get<std::string>();
  if (op == "subscribe") {
    Subscribe subscribe;
    for (const json& entry : list(message, "subscriptions")) {
      subscribe.all.push_back({number(entry.at("id")), number(entry.at("channelId"))});
    }
    return subscribe;
  }
  if (op == "unsubscribe") return Unsubscribe{numbers(message, "subscriptionIds")};
  if (op == "advertise") {
    Advertise advertise;
    for (const json& entry : list(message, "channels")) {
      advertise.all.push_back({number(entry.at("id")), entry.at("topic").get<std::string>(),
                               entry.at("encoding").get<std::string>()});
    }
    return advertise;
  }
  if (op == "unadvertise") return Unadvertise{numbers(message, "channelIds")};
  if (op == "motionlab/authorize") return Authorize{message.at("token").get<std::string>()};
  throw std::invalid_argument{"this console does not know the operation " + op};
}

}  // namespace

std::string server_info(bool control, std::string_view session) {
  ordered_json message;
  message["op"] = "serverInfo";
  message["name"] = "motionlab-console";
  message["capabilities"] = control ? ordered_json::array({"clientPublish"}) : ordered_json::array();
  if (control) message["supportedEncodings"] = {"json"};
  message["metadata"] = ordered_json::object();
  message["sessionId"] = session;
  return text_of(message);
}

std::string advertise(std::span<const std::uint32_t> channels) {
  ordered_json message;
  message["op"] = "advertise";
  message["channels"] = ordered_json::array();
  for (const std::uint32_t channel : channels) message["channels"].push_back(channel_json(channel));
  return text_of(message);
}

std::string unadvertise(std::span<const std::uint32_t> channels) {
  ordered_json message;
  message["op"] = "unadvertise";
  message["channelIds"] = channels;
  return text_of(message);
}

std::string status(Level level, std::string_view text) {
  ordered_json message;
  message["op"] = "status";
  message["level"] = static_cast<int>(level);
  message["message"] = text;
  return text_of(message);
}

std::string missed_status(std::string_view text, std::uint64_t missed) {
  ordered_json message;
  message["op"] = "status";
  message["level"] = static_cast<int>(Level::warning);
  message["message"] = text;
  message["id"] = "missed";
  message["missed"] = missed;
  return text_of(message);
}

std::string authorized(bool granted) {
  ordered_json message;
  message["op"] = "motionlab/authorized";
  message["granted"] = granted;
  return text_of(message);
}

Header message_header(std::uint32_t subscription, std::int64_t t_ns) noexcept {
  Header header{1};
  for (std::size_t i = 0; i < 4; ++i) header[1 + i] = static_cast<std::uint8_t>(subscription >> (8 * i));
  const auto t = static_cast<std::uint64_t>(t_ns);
  for (std::size_t i = 0; i < 8; ++i) header[5 + i] = static_cast<std::uint8_t>(t >> (8 * i));
  return header;
}

std::variant<ClientText, std::string> read_text(std::string_view text) {
  try {
    return read(json::parse(text));
  } catch (const json::exception&) {
    return std::string{"that is no message of the Foxglove WebSocket protocol"};
  } catch (const std::invalid_argument& wrong) {
    return std::string{wrong.what()};
  }
}

std::variant<ClientMessage, std::string> read_binary(std::string_view bytes) {
  if (bytes.size() < 5 || bytes[0] != 1) return std::string{"that is no binary message of a client"};
  ClientMessage message;
  for (std::size_t i = 0; i < 4; ++i) {
    message.channel |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[1 + i])) << (8 * i);
  }
  message.payload = bytes.substr(5);
  return message;
}

}  // namespace motionlab::console::foxglove
