#include "gateway/monitor/export_command.hpp"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <map>
#include <ostream>
#include <utility>

#include "drivers/core/error.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/monitor/field_selection.hpp"
#include "gateway/monitor/files.hpp"
#include "gateway/monitor/named_topics.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/sample_text.hpp"
#include "gateway/monitor/sample_values.hpp"
#include "gateway/record/mcap_reader.hpp"

namespace motionlab::monitor {
namespace {

namespace fs = std::filesystem;

/// "motionlab/mru" as the name of a file: whatever a stranger calls a topic, it stays in its folder.
std::string file_name(std::string topic) {
  std::ranges::replace_if(
      topic, [](unsigned char c) { return std::isalnum(c) == 0 && c != '_' && c != '-'; }, '_');
  return topic + ".csv";
}

/// One topic on its way into its file.
class Sheet {
 public:
  Sheet(const record::McapChannel& channel, const fs::path& folder)
      : topic_(channel.topic), description_(channel.schema ? topic_of_type(channel.schema->name) : nullptr) {
    if (!description_) return;
    decode_ = decoder_of(*description_);
    fields_ = select_fields(*description_, {});
    path_ = folder / file_name(topic_);
    out_ = make_file(path_);
    out_ << "t_heard_ns,t_written_ns," << csv_header(fields_);
  }

  void take(const record::McapMessage& message) {
    const auto values = description_ ? decode_(message.data) : std::nullopt;
    if (!values) {
      ++unreadable_;
      return;
    }
    ++lines_;
    out_ << message.logged_ns << ',' << message.published_ns << ',' << as_csv(fields_, *values);
  }

  /// Says how it went. @returns whether all of it is in the file
  bool tell(const Terminal& terminal) {
    if (!description_) {
      terminal.err << escaped(topic_) << " is left out: its type is none of motionlab\n";
      return true;
    }
    out_.flush();
    terminal.out << path_.string() << ": " << lines_ << " samples\n";
    if (unreadable_ > 0)
      terminal.err << unreadable_ << " samples of " << escaped(topic_) << " are none of its type\n";
    if (!out_) terminal.err << path_.string() << " is not whole: its disk takes no more\n";
    return out_.good() && unreadable_ == 0;
  }

 private:
  std::string topic_;
  const TopicDescription* description_;
  Decoder decode_ = nullptr;
  std::vector<Selected> fields_;
  fs::path path_;
  std::ofstream out_;
  std::uint64_t lines_ = 0, unreadable_ = 0;
};

}  // namespace

int run_export(const ExportCommand& command, const Terminal& terminal) {
  std::vector<std::string_view> wanted;
  for (const std::size_t row : rows_named(command.topics)) wanted.push_back(bus::kTopicList[row].name);
  std::ifstream in = open_recording(command.file);
  const fs::path folder =
      command.folder.empty() ? fs::path(command.file).replace_extension() : fs::path(command.folder);
  record::McapReader reader(in);
  std::map<const record::McapChannel*, Sheet> sheets;
  bool whole = true;
  while (!terminal.interrupted) {
    const auto item = reader.next();
    if (!item) {
      terminal.err << escaped(command.file) << ": " << item.fault().text << "\n";
      whole = false;
      if (!reader.skip()) break;
      continue;
    }
    if (!item->has_value()) break;
    const auto* const message = std::get_if<record::McapMessage>(&**item);
    if (!message) continue;
    const record::McapChannel& channel = *message->channel;
    if (!wanted.empty() && std::ranges::find(wanted, channel.topic) == wanted.end()) continue;
    auto sheet = sheets.find(&channel);
    if (sheet == sheets.end()) {
      make_folder(folder);
      sheet = sheets.try_emplace(&channel, channel, folder).first;
    }
    sheet->second.take(*message);
  }
  for (auto& [channel, sheet] : sheets) whole = sheet.tell(terminal) && whole;
  if (terminal.interrupted) return kExitInterrupted;
  if (sheets.empty()) terminal.err << escaped(command.file) << " has no sample of what was asked for\n";
  return whole && !sheets.empty() ? kExitGood : kExitWrong;
}

}  // namespace motionlab::monitor
