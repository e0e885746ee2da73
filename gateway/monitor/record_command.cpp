#include "gateway/monitor/record_command.hpp"

#include <systemd/sd-daemon.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <sstream>
#include <thread>
#include <utility>

#include "drivers/core/error.hpp"
#include "drivers/core/toml_reader.hpp"
#include "gateway/monitor/named_topics.hpp"
#include "gateway/monitor/recorder.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"
#include "gateway/record/run_recorder.hpp"

namespace motionlab::monitor {
namespace {

constexpr std::uint64_t kMegabyte = 1'000'000;
constexpr Nanoseconds kRound = 5ms;  // from taking to taking
constexpr Nanoseconds kTell = 1s;    // how often it says how far it is
constexpr int kPatientDepth = 512;   // samples that DDS keeps while this process gets no processor

std::filesystem::path file_for(const std::string& to, LabTime now) {
  if (to.empty()) return record::dated_name(now);
  const std::filesystem::path named = to;
  return std::filesystem::is_directory(named) ? named / record::dated_name(now) : named;
}

record::AttachedFile attached(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  if (!in) throw StartupError{"cannot read " + path + ": a file to attach must be there and be readable"};
  const std::filesystem::path file(path);
  return {file.filename().string(),
          file.extension() == ".toml" ? "application/toml" : "application/octet-stream", text.str()};
}

/// The gateway's files as they are, comments included, and what they are together.
std::vector<record::AttachedFile> attachments(const RecordCommand& command) {
  std::vector<record::AttachedFile> files;
  if (!command.config.empty()) {
    const std::vector<std::filesystem::path> overlays(command.overlays.begin(), command.overlays.end());
    files.push_back({std::string(record::kRunConfiguration), "application/toml",
                     TomlDocument::load(command.config, overlays).effective()});
    files.push_back(attached(command.config));
  }
  for (const std::string& overlay : command.overlays) files.push_back(attached(overlay));
  for (const std::string& other : command.attachments) files.push_back(attached(other));
  return files;
}

std::optional<EventWindow> window_of(const RecordCommand& command) {
  if (command.on_event.empty()) return std::nullopt;
  return EventWindow{command.on_event, from_seconds(command.before_s), from_seconds(command.after_s)};
}

/// Those asked for, and the events that open windows.
std::vector<std::size_t> rows_of(const RecordCommand& command) {
  std::vector<std::size_t> rows = rows_named(command.topics);
  constexpr std::size_t kEvents = bus::topic_index<topic::Event>();
  if (!command.on_event.empty() && !rows.empty() &&
      std::find(rows.begin(), rows.end(), kEvents) == rows.end())
    rows.push_back(kEvents);
  return rows;
}

record::RecordingOptions recording_options(const RecordCommand& command, LabTime now) {
  record::RecordingOptions options;
  options.file = file_for(command.to, now);
  options.split_bytes = command.split_mb * kMegabyte;
  options.disk_bytes = command.disk_mb * kMegabyte;
  if (command.disk_mb > 0) options.split_bytes = std::min(options.split_bytes, options.disk_bytes / 4);
  options.attached = attachments(command);
  std::string topics;
  for (const std::string& topic : command.topics) topics += (topics.empty() ? "" : " ") + topic;
  options.about["topics"] = topics.empty() ? "all" : topics;
  return options;
}

record::TopicLosses sum(const record::LossesByTopic& losses) {
  record::TopicLosses all;
  for (const record::TopicLosses& one : losses) {
    all.on_dds += one.on_dds;
    all.in_queue += one.in_queue;
    all.refused += one.refused;
  }
  return all;
}

/// "12 s, 24013 messages, 1.2 MB, lost 0 on DDS, 0 in the queue"
std::string how_far(Nanoseconds time, std::uint64_t messages, std::uint64_t bytes,
                    const record::TopicLosses& lost) {
  return fixed(seconds(time), 0) + " s, " + std::to_string(messages) + " messages, " +
         fixed(static_cast<double>(bytes) / kMegabyte, 1) + " MB, lost " + std::to_string(lost.on_dds) +
         " on DDS, " + std::to_string(lost.in_queue) + " in the queue";
}

nlohmann::ordered_json as_json(const record::Recording& recording, const record::LossesByTopic& losses,
                               Nanoseconds time) {
  nlohmann::ordered_json json;
  json["files"] = nlohmann::ordered_json::array();
  for (const auto& file : recording.files()) json["files"].push_back(file.string());
  json["seconds"] = seconds(time);
  json["messages"] = recording.messages();
  json["bytes"] = recording.bytes();
  json["losses"] = nlohmann::ordered_json::array();
  for (std::size_t topic = 0; topic < losses.size(); ++topic) {
    if (losses[topic] == record::TopicLosses{}) continue;
    json["losses"].push_back({{"topic", bus::kTopicList[topic].name},
                              {"lost_on_dds", losses[topic].on_dds},
                              {"lost_in_queue", losses[topic].in_queue},
                              {"refused", losses[topic].refused}});
  }
  return json;
}

std::string as_text(const record::Recording& recording, const record::LossesByTopic& losses,
                    Nanoseconds time) {
  std::string text;
  for (const auto& file : recording.files()) text += file.string() + "\n";
  text += how_far(time, recording.messages(), recording.bytes(), sum(losses)) + "\n";
  for (std::size_t topic = 0; topic < losses.size(); ++topic) {
    const record::TopicLosses& lost = losses[topic];
    if (lost == record::TopicLosses{}) continue;
    text += "  " + std::string{bus::kTopicList[topic].name} + ": lost " + std::to_string(lost.on_dds) +
            " on DDS, " + std::to_string(lost.in_queue) + " in the queue, refused " +
            std::to_string(lost.refused) + "\n";
  }
  return text;
}

/// Says once a second how far it is: to systemd, with a stroke for its watchdog when the writing thread has
/// come round, and to a terminal.
class Teller {
 public:
  Teller(const Terminal& terminal, bool windows) : terminal_(terminal), windows_(windows) {}
  ~Teller() {
    if (shown_) terminal_.err << "\r\033[K" << std::flush;
  }
  Teller(const Teller&) = delete;
  Teller& operator=(const Teller&) = delete;

  void tell(Recorder& recorder, Nanoseconds time) {
    if (time < next_) return;
    next_ = time + kTell;
    std::string far = how_far(time, recorder.messages(), recorder.bytes(), sum(recorder.losses()));
    if (windows_) far += ", " + std::to_string(recorder.windows()) + " events";
    const std::uint64_t rounds = recorder.rounds();
    const bool alive = std::exchange(rounds_, rounds) != rounds;
    sd_notifyf(0, "%sSTATUS=%s", alive ? "WATCHDOG=1\n" : "", far.c_str());
    if (!terminal_.progress) return;
    terminal_.err << "\rrecording: " << far << "\033[K" << std::flush;
    shown_ = true;
  }

 private:
  const Terminal& terminal_;
  const bool windows_;
  Nanoseconds next_{0};
  std::uint64_t rounds_ = 0;
  bool shown_ = false;
};

}  // namespace

int run_record(const Connection& connection, const RecordCommand& command, const Terminal& terminal) {
  RealClock clock;
  bus::DdsConfig dds = dds_config(connection, true);
  dds.participant = "motionlab-recorder";
  const LabTime start = clock.now();
  const std::optional<EventWindow> window = window_of(command);
  Recorder recorder{
      dds, {.topics = rows_of(command), .depth = kPatientDepth}, recording_options(command, start), window};
  sd_notify(0, "READY=1");
  std::size_t heard = 0;
  {
    Teller teller{terminal, window.has_value()};
    const Nanoseconds end = command.seconds ? from_seconds(*command.seconds) : Nanoseconds::max();
    for (Nanoseconds time{0}; !terminal.interrupted && time < end && !recorder.trouble();
         time = clock.now() - start) {
      heard += recorder.listen();
      teller.tell(recorder, time);
      std::this_thread::sleep_for(std::min(kRound, end - time));
    }
  }
  sd_notify(0, "STOPPING=1");
  heard += recorder.listen();
  const record::Recording& recording = recorder.finish();
  const Nanoseconds time = clock.now() - start;
  terminal.out << (command.json ? json_text(as_json(recording, recorder.losses(), time))
                                : as_text(recording, recorder.losses(), time));
  if (const auto trouble = recording.trouble()) {
    terminal.err << *trouble << "\n";
    return kExitWrong;
  }
  if (heard > 0) return kExitGood;
  if (terminal.interrupted) return kExitInterrupted;
  terminal.err << nobody_answers(connection, seconds(time)) << "\n";
  return kExitNobody;
}

}  // namespace motionlab::monitor
