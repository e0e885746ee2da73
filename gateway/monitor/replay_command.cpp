#include "gateway/monitor/replay_command.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <ostream>
#include <span>
#include <string_view>

#include "drivers/core/error.hpp"
#include "gateway/bus/dds_repeater.hpp"
#include "gateway/bus/dds_watch.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/monitor/files.hpp"
#include "gateway/monitor/found_topic.hpp"
#include "gateway/monitor/named_topics.hpp"
#include "gateway/monitor/progress.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/record/ordered_messages.hpp"

namespace motionlab::monitor {
namespace {

constexpr Nanoseconds kLook = 2s;               // discovery has no end; so long a gateway may take to be seen
constexpr Nanoseconds kReadersMayCome = 500ms;  // or they miss the beginning
constexpr Nanoseconds kPoll = 20ms;             // how often it is looked for while samples are said
constexpr const char* kName = "motionlab-replay";

/// Whether somebody does what such samples say.
bool asks(const bus::TopicRow& row) {
  return row.qos == bus::QosClass::command || row.qos == bus::QosClass::request ||
         row.name == bus::TopicTraits<topic::Reference>::name;
}

std::vector<std::size_t> rows_to_say(const std::vector<std::string>& names) {
  if (!names.empty()) return rows_named(names);
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < bus::kTopicList.size(); ++row) {
    if (!asks(bus::kTopicList[row])) rows.push_back(row);
  }
  return rows;
}

/// Whoever says which mode the laboratory is in is a gateway; nothing when only replays say so.
std::optional<std::string> gateway_in(const bus::DdsWatch& watch) {
  for (const bus::SeenEndpoint& writer : watch.writers_of(bus::TopicTraits<topic::Mode>::name)) {
    if (writer.participant != kName) return who(writer);
  }
  return std::nullopt;
}

int refuse(const std::string& gateway, const Connection& connection, const Terminal& terminal) {
  terminal.err << "a gateway lives in domain " << connection.domain << " (" << gateway
               << "): nothing recorded is said where it could move a robot. Choose another --domain\n";
  return kExitWrong;
}

/// How long after the first message this one is said. A file may hold any number as a time.
Nanoseconds since(std::uint64_t first_ns, std::uint64_t logged_ns, double speed) {
  constexpr double kLongest = 1e9;  // seconds
  const double recorded_s = 1e-9 * (static_cast<double>(logged_ns) - static_cast<double>(first_ns));
  return from_seconds(std::clamp(recorded_s / speed, 0.0, kLongest));
}

/// Where the messages of a file go.
class Rows {
 public:
  explicit Rows(const std::vector<std::size_t>& chosen) : chosen_(chosen) {}

  /// Nothing: it is not said.
  std::optional<std::size_t> of(const record::McapChannel& channel) {
    const auto known = rows_.find(&channel);
    if (known != rows_.end()) return known->second;
    std::optional<std::size_t> row;
    for (const std::size_t one : chosen_) {
      if (bus::kTopicList[one].name == channel.topic) row = one;
    }
    if (!row) left_out_ += (left_out_.empty() ? "" : ", ") + escaped(channel.topic);
    return rows_.emplace(&channel, row).first->second;
  }
  /// Their names.
  [[nodiscard]] const std::string& left_out() const noexcept { return left_out_; }

 private:
  const std::vector<std::size_t>& chosen_;
  std::map<const record::McapChannel*, std::optional<std::size_t>> rows_;
  std::string left_out_;
};

}  // namespace

int run_replay(const Connection& connection, const ReplayCommand& command, const Terminal& terminal) {
  const RealClock clock;
  std::ifstream in = open_recording(command.file);
  const std::vector<std::size_t> chosen = rows_to_say(command.topics);
  const auto wakeup = std::make_shared<bus::Wakeup>();
  bus::DdsConfig dds = dds_config(connection, true);
  dds.participant = kName;
  const bus::DdsWatch watch{dds, wakeup};
  std::optional<std::string> gateway;
  const auto look = [&](const char* what, Nanoseconds time) {
    Progress progress{terminal, what};
    for (const LabTime start = clock.now();
         !terminal.interrupted && !gateway && clock.now() < start + time;) {
      progress.show(clock.now() - start, time);
      wakeup->wait(kPoll);
      gateway = gateway_in(watch);
    }
  };
  look("looking whether a gateway lives here", kLook);
  if (gateway) return refuse(*gateway, connection, terminal);
  bus::DdsRepeater repeater{dds, chosen};
  look("waiting for readers", kReadersMayCome);

  record::McapReader reader(in);
  record::OrderedMessages messages(reader);
  Rows rows(chosen);
  std::uint64_t said = 0, not_said = 0, first_ns = 0;
  const LabTime start = clock.now();
  LabTime next_look = start;
  while (!terminal.interrupted && !gateway) {
    const auto message = messages.next();
    if (!message) break;
    const auto row = rows.of(*message->channel);
    if (!row) continue;
    if (said + not_said == 0) first_ns = message->logged_ns;
    const LabTime due = start + since(first_ns, message->logged_ns, command.speed);
    for (LabTime now = clock.now(); !terminal.interrupted && !gateway && (now < due || now >= next_look);
         now = clock.now()) {
      gateway = gateway_in(watch);
      next_look = now + kPoll;
      if (now < due) wakeup->wait(std::min<Nanoseconds>(kPoll, due - now));
    }
    if (terminal.interrupted || gateway) break;
    (repeater.say(*row, std::as_bytes(std::span{message->data})) ? said : not_said) += 1;
  }
  terminal.out << said << " samples said\n";
  if (not_said > 0) terminal.err << not_said << " are no samples of their topic, or DDS did not take them\n";
  if (!rows.left_out().empty()) terminal.err << "left out: " << rows.left_out() << "\n";
  if (gateway) return refuse(*gateway, connection, terminal);
  if (messages.fault()) terminal.err << escaped(command.file) << ": " << messages.fault()->text << "\n";
  if (terminal.interrupted) return said > 0 ? kExitGood : kExitInterrupted;
  return said > 0 && !messages.fault() ? kExitGood : kExitWrong;
}

}  // namespace motionlab::monitor
