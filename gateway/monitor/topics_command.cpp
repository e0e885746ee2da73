#include "gateway/monitor/topics_command.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <ostream>
#include <utility>

#include "gateway/monitor/found_topic.hpp"
#include "gateway/monitor/progress.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text_table.hpp"
#include "gateway/monitor/topic_json.hpp"
#include "gateway/monitor/topic_table.hpp"

namespace motionlab::monitor {
namespace {

std::string partitions_of(const bus::SeenQos& qos) {
  std::string text;
  for (const std::string& name : qos.partitions) {
    if (!text.empty()) text += ',';
    text += escaped(name);
  }
  return text;
}

/// "best_effort volatile", "reliable transient_local partition truth"
std::string qos_text(const bus::SeenQos& qos) {
  std::string text = qos.reliable ? "reliable " : "best_effort ";
  text += to_string(qos.durability);
  if (!qos.partitions.empty()) text += " partition " + partitions_of(qos);
  if (qos.exclusive) text += " exclusive";
  if (!qos.xcdr1) text += " xcdr2";
  return text;
}

/// What all of them offer or ask for, or "mixed".
std::string common_qos(const std::vector<bus::SeenEndpoint>& ends) {
  const std::string first = qos_text(ends.front().qos);
  const bool same =
      std::ranges::all_of(ends, [&](const bus::SeenEndpoint& end) { return qos_text(end.qos) == first; });
  return same ? first : "mixed (--endpoints shows each)";
}

std::string names_of(const std::vector<bus::SeenEndpoint>& ends) {
  std::vector<std::string> names;
  for (const bus::SeenEndpoint& end : ends) {
    if (const std::string name = who(end); std::ranges::find(names, name) == names.end())
      names.push_back(name);
  }
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

nlohmann::ordered_json endpoint_json(const bus::SeenEndpoint& end) {
  nlohmann::ordered_json json;
  json["participant"] = end.participant;
  json["host"] = end.host;
  json["process"] = end.process;
  json["reliability"] = end.qos.reliable ? "reliable" : "best_effort";
  json["durability"] = std::string{to_string(end.qos.durability)};
  json["ownership"] = end.qos.exclusive ? "exclusive" : "shared";
  json["deadline_s"] = end.qos.deadline_s > 0 ? nlohmann::ordered_json(end.qos.deadline_s) : nullptr;
  json["partitions"] = end.qos.partitions;
  json["xcdr1"] = end.qos.xcdr1;
  return json;
}

}  // namespace

std::vector<TopicRow> rows_of(const std::vector<bus::SeenEndpoint>& endpoints) {
  std::map<std::pair<std::string, std::string>, TopicRow> rows;
  for (const bus::SeenEndpoint& end : endpoints) {
    TopicRow& row = rows[{end.topic, end.type}];
    row.name = end.topic;
    row.type = end.type;
    row.known = topic_of_type(end.type) != nullptr;
    (end.writes ? row.writers : row.readers).push_back(end);
  }
  std::vector<TopicRow> ordered;
  for (auto& [key, row] : rows) ordered.push_back(std::move(row));
  return ordered;
}

std::string topics_text(const std::vector<TopicRow>& rows, bool endpoints) {
  std::vector<std::array<std::string, 6>> lines{{"TOPIC", "TYPE", "WRITERS", "READERS", "QOS", "WHO"}};
  for (const TopicRow& row : rows) {
    const auto& told = row.writers.empty() ? row.readers : row.writers;
    lines.push_back({escaped(row.name), escaped(row.type) + (row.known ? "" : " (unknown type)"),
                     std::to_string(row.writers.size()), std::to_string(row.readers.size()), common_qos(told),
                     (row.writers.empty() ? "read by " : "") + names_of(told)});
    if (!endpoints) continue;
    for (const auto* const ends : {&row.writers, &row.readers}) {
      for (const bus::SeenEndpoint& end : *ends) {
        std::string name = who(end);
        if (!end.process.empty()) name += ", process " + escaped(end.process);
        lines.push_back({end.writes ? "  writes" : "  reads", "", "", "", qos_text(end.qos), name});
      }
    }
  }
  return text_table(lines);
}

nlohmann::ordered_json topics_json(const std::vector<TopicRow>& rows,
                                   const std::vector<bus::SeenParticipant>& participants) {
  nlohmann::ordered_json json;
  json["participants"] = nlohmann::ordered_json::array();
  for (const bus::SeenParticipant& one : participants) {
    json["participants"].push_back({{"name", one.name}, {"host", one.host}, {"process", one.process}});
  }
  json["topics"] = nlohmann::ordered_json::array();
  for (const TopicRow& row : rows) {
    nlohmann::ordered_json topic;
    topic["topic"] = row.name;
    topic["type"] = row.type;
    topic["known"] = row.known;
    for (const auto& [name, ends] :
         {std::pair{"writers", &row.writers}, std::pair{"readers", &row.readers}}) {
      topic[name] = nlohmann::ordered_json::array();
      for (const bus::SeenEndpoint& end : *ends) topic[name].push_back(endpoint_json(end));
    }
    json["topics"].push_back(std::move(topic));
  }
  return json;
}

int run_topics(const Connection& connection, const TopicsCommand& command, const Terminal& terminal) {
  const RealClock clock;
  const auto wakeup = std::make_shared<bus::Wakeup>();
  const bus::DdsWatch watch{dds_config(connection), wakeup};
  {
    Progress progress{terminal, "listening"};
    const Nanoseconds wait = from_seconds(command.wait_s);
    const LabTime start = clock.now();
    while (!terminal.interrupted && clock.now() < start + wait) {
      progress.show(clock.now() - start, wait);
      wakeup->wait(std::min<Nanoseconds>(50ms, start + wait - clock.now()));
    }
  }
  if (terminal.interrupted) return kExitInterrupted;
  const std::vector<TopicRow> rows = rows_of(watch.endpoints());
  const auto participants = watch.participants();
  if (command.json) {
    terminal.out << json_text(topics_json(rows, participants));
  } else if (!rows.empty()) {
    terminal.out << topics_text(rows, command.endpoints);
  }
  if (!rows.empty()) return kExitGood;
  terminal.err << (participants.empty()
                       ? nobody_answers(connection, command.wait_s)
                       : "there are participants in the domain, but they write and read nothing")
               << "\n";
  return kExitNobody;
}

}  // namespace motionlab::monitor
