#include "gateway/monitor/delay_command.hpp"

#include <limits.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <memory>
#include <ostream>
#include <utility>

#include "gateway/monitor/any_tap.hpp"
#include "gateway/monitor/progress.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"

namespace motionlab::monitor {
namespace {

constexpr Nanoseconds kPoll = 20ms;

bool has_rhythm(const TopicDescription& topic) {
  return topic.partition.empty() &&
         (topic.qos == bus::QosClass::sensor || topic.qos == bus::QosClass::command);
}

/// Writers of these topics that are not on this host.
std::vector<std::string> far_hosts(const bus::DdsWatch& watch) {
  std::array<char, HOST_NAME_MAX + 1> here{};
  if (gethostname(here.data(), here.size() - 1) != 0) here[0] = '\0';
  std::vector<std::string> far;
  for (const bus::SeenEndpoint& end : watch.endpoints()) {
    const TopicDescription* const topic = topic_named(end.topic);
    if (!end.writes || !topic || !has_rhythm(*topic) || end.host == here.data()) continue;
    if (std::ranges::find(far, end.host) == far.end()) far.push_back(end.host);
  }
  return far;
}

std::string clocks_text(const std::vector<std::string>& far) {
  std::string text =
      "\nClocks: all hops but the last two are in the gateway's laboratory time; a constant part of a link's "
      "delay is\n"
      "known only from the configuration. \"last stamp -> on DDS\" compares laboratory time with the system "
      "clock of\n"
      "the writer's host, from which it was started and which it follows slowly; \"on DDS -> heard here\" "
      "compares that\n"
      "with the system clock of this host. ";
  if (far.empty()) return text + "All writers are on this host: one system clock.\n";
  text += "Writers on other hosts (";
  for (std::size_t i = 0; i < far.size(); ++i) text += (i > 0 ? ", " : "") + escaped(far[i]);
  return text + "):\nthe last hop is only as good as their synchronisation (PTP, NTP).\n";
}

}  // namespace

std::string delay_text(const std::vector<HopDelay>& hops, const std::vector<std::string>& far) {
  std::vector<std::array<std::string, 8>> lines{{"HOP", "OF", "SAMPLES", "P50", "P95", "P99", "MAX", ""}};
  std::size_t negative = 0;
  for (const HopDelay& hop : hops) {
    lines.push_back({std::string{name_of(hop.hop)}, escaped(hop.what), std::to_string(hop.delay_us.count),
                     fixed(hop.delay_us.p50, 0), fixed(hop.delay_us.p95, 0), fixed(hop.delay_us.p99, 0),
                     fixed(hop.delay_us.max, 0),
                     hop.negative > 0 ? "negative " + std::to_string(hop.negative) : ""});
    if (crosses_clocks(hop.hop)) negative += hop.negative;
  }
  std::array<std::size_t, 8> width{};
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) width[i] = std::max(width[i], line[i].size());
  }
  std::string text = "delay in microseconds\n";
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < line.size(); ++i) {
      const std::string space(width[i] - line[i].size(), ' ');
      const bool number = i >= 2 && i < 7;
      text += number ? space + line[i] + "  " : line[i] + (i + 1 < line.size() ? space + "  " : "");
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  text += clocks_text(far);
  if (negative > 0)
    text += "A negative delay means that the two clocks of that hop disagree by more than the delay.\n";
  return text;
}

nlohmann::ordered_json delay_json(const std::vector<HopDelay>& hops, const std::vector<std::string>& far) {
  nlohmann::ordered_json json;
  json["unit"] = "us";
  json["other_hosts"] = far;
  json["hops"] = nlohmann::ordered_json::array();
  for (const HopDelay& hop : hops) {
    json["hops"].push_back({{"hop", std::string{name_of(hop.hop)}},
                            {"of", hop.what},
                            {"crosses_clocks", crosses_clocks(hop.hop)},
                            {"samples", hop.delay_us.count},
                            {"negative", hop.negative},
                            {"min", hop.delay_us.min},
                            {"p50", hop.delay_us.p50},
                            {"p95", hop.delay_us.p95},
                            {"p99", hop.delay_us.p99},
                            {"max", hop.delay_us.max}});
  }
  return json;
}

int run_delay(const Connection& connection, const DelayCommand& command, const Terminal& terminal) {
  const RealClock clock;
  const auto wakeup = std::make_shared<bus::Wakeup>();
  bus::DdsWatch watch{dds_config(connection), wakeup};
  std::vector<std::pair<const TopicDescription*, std::unique_ptr<AnyTap>>> taps;
  for (const TopicDescription& topic : every_topic()) {
    if (has_rhythm(topic)) taps.emplace_back(&topic, tap(watch, topic, std::string{topic.name}));
  }
  DelayMeter meter;
  const Nanoseconds window = from_seconds(command.window_s);
  const LabTime start = clock.now();
  std::optional<LabTime> first;
  {
    Progress progress{terminal, "measuring"};
    const auto over = [&] {
      const LabTime now = clock.now();
      return first ? now - *first >= window : now - start >= from_seconds(connection.timeout_s);
    };
    while (!terminal.interrupted && !over()) {
      wakeup->wait(kPoll);
      for (const auto& [topic, samples] : taps) {
        for (auto sample = samples->next(); sample; sample = samples->next()) meter.take(*topic, *sample);
      }
      if (!first && !meter.empty()) first = clock.now();
      if (first) progress.show(clock.now() - *first, window);
    }
  }
  if (meter.empty()) {
    if (terminal.interrupted) return kExitInterrupted;
    terminal.err << nobody_answers(connection, connection.timeout_s) << "\n";
    return kExitNobody;
  }
  const auto hops = meter.report();
  const auto far = far_hosts(watch);
  terminal.out << (command.json ? json_text(delay_json(hops, far)) : delay_text(hops, far));
  return kExitGood;
}

}  // namespace motionlab::monitor
