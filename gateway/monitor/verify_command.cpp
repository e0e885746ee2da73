#include "gateway/monitor/verify_command.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <ostream>

#include "drivers/core/error.hpp"
#include "gateway/monitor/files.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/text_table.hpp"
#include "gateway/monitor/topic_json.hpp"
#include "gateway/record/recording.hpp"

namespace motionlab::monitor {
namespace {

double span_s(const record::TopicContents& contents) {
  return 1e-9 * static_cast<double>(contents.last_ns - contents.first_ns);
}

double rate_hz(const record::TopicContents& contents) {
  return contents.last_ns == contents.first_ns
             ? 0
             : static_cast<double>(contents.messages - 1) / span_s(contents);
}

/// The recorder's own word on the topic; nothing where its file has no end.
const record::StringMap* ledger_of(const record::Inspection& seen, const std::string& topic) {
  for (const record::McapMetadata& entry : seen.metadata) {
    const auto found = entry.values.find("topic");
    if (entry.name == record::kLossMetadata && found != entry.values.end() && found->second == topic)
      return &entry.values;
  }
  return nullptr;
}

std::string value_in(const record::StringMap& values, const std::string& key) {
  const auto found = values.find(key);
  return found == values.end() ? "?" : escaped(found->second);
}

std::string losses_text(const record::Inspection& seen, const record::TopicContents& contents) {
  if (const auto* const ledger = ledger_of(seen, contents.topic)) {
    return value_in(*ledger, "lost_on_dds") + " on DDS, " + value_in(*ledger, "lost_in_queue") +
           " in the queue, " + value_in(*ledger, "refused") + " refused";
  }
  return std::to_string(contents.numbers.missing()) + " missing numbers";
}

/// "motionlab/wire device mru1, lost 0, received 200"
std::string metadata_line(const record::McapMetadata& entry) {
  std::string text = escaped(entry.name);
  const char* separator = " ";
  for (const auto& [key, value] : entry.values) {
    text += separator + escaped(key) + " " + escaped(value);
    separator = ", ";
  }
  return text + "\n";
}

}  // namespace

std::string inspection_text(const record::Inspection& seen) {
  std::string text = seen.whole() ? "whole" : "not whole";
  text += ", written by " + (seen.library.empty() ? "nobody knows whom" : escaped(seen.library)) + ", " +
          std::to_string(seen.messages()) + " messages\n";
  std::vector<std::array<std::string, 6>> lines{{"TOPIC", "TYPE", "MESSAGES", "SECONDS", "HZ", "LOST"}};
  for (const record::TopicContents& contents : seen.topics) {
    lines.push_back({escaped(contents.topic), escaped(contents.type), std::to_string(contents.messages),
                     fixed(span_s(contents), 3), fixed(rate_hz(contents), 1), losses_text(seen, contents)});
  }
  text += text_table(lines);
  for (const record::McapMetadata& entry : seen.metadata) {
    if (entry.name != record::kLossMetadata) text += metadata_line(entry);
  }
  for (const auto& [name, size] : seen.attachments)
    text += "attached: " + escaped(name) + ", " + std::to_string(size) + " bytes\n";
  for (const record::Damage& damage : seen.damages)
    text += "damage before byte " + std::to_string(damage.position) + ": " + std::string{damage.text} + "\n";
  if (seen.damage_count > seen.damages.size()) {
    text += "and " + std::to_string(seen.damage_count - seen.damages.size()) + " more\n";
  }
  if (!seen.complete) {
    text += "missing: its end. Whoever wrote it was ended before it, or the disk was full\n";
  } else if (!seen.has_index) {
    text += "missing: its index; it can only be read from front to back\n";
  }
  if (!seen.whole()) text += "motionlab verify FILE --repair OUT writes a whole file of all that is good\n";
  return text;
}

nlohmann::ordered_json inspection_json(const record::Inspection& seen) {
  using Json = nlohmann::ordered_json;
  Json json;
  json["whole"] = seen.whole();
  json["complete"] = seen.complete;
  json["has_index"] = seen.has_index;
  json["library"] = seen.library;
  json["messages"] = seen.messages();
  json["topics"] = Json::array();
  for (const record::TopicContents& contents : seen.topics) {
    Json topic{{"topic", contents.topic},
               {"type", contents.type},
               {"messages", contents.messages},
               {"first_ns", contents.first_ns},
               {"last_ns", contents.last_ns},
               {"rate_hz", rate_hz(contents)},
               {"missing_numbers", contents.numbers.missing()}};
    const auto* const ledger = ledger_of(seen, contents.topic);
    topic["ledger"] = ledger ? Json(*ledger) : Json(nullptr);
    json["topics"].push_back(std::move(topic));
  }
  json["metadata"] = Json::array();
  for (const record::McapMetadata& entry : seen.metadata)
    json["metadata"].push_back({{"name", entry.name}, {"values", entry.values}});
  json["attachments"] = Json::array();
  for (const auto& [name, size] : seen.attachments)
    json["attachments"].push_back({{"name", name}, {"bytes", size}});
  json["damage_count"] = seen.damage_count;
  json["damages"] = Json::array();
  for (const record::Damage& damage : seen.damages)
    json["damages"].push_back({{"position", damage.position}, {"text", damage.text}});
  return json;
}

int run_verify(const VerifyCommand& command, const Terminal& terminal) {
  std::ifstream in = open_recording(command.file);
  record::Inspection seen;
  bool repaired = false;
  if (command.repaired.empty()) {
    seen = record::inspect(in);
  } else {
    std::ofstream out = make_file(command.repaired);
    seen = record::repair(in, out);
    repaired = out.flush().good() && seen.messages() > 0;
    if (!out) terminal.err << command.repaired << " is not whole either: its disk takes no more\n";
    if (seen.messages() == 0) std::filesystem::remove(command.repaired);  // there is nothing to save
  }
  terminal.out << (command.json ? json_text(inspection_json(seen)) : inspection_text(seen));
  return seen.whole() || repaired ? kExitGood : kExitWrong;
}

}  // namespace motionlab::monitor
