#include "gateway/monitor/rate_command.hpp"

#include <algorithm>
#include <ostream>

#include "gateway/monitor/found_topic.hpp"
#include "gateway/monitor/progress.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"

namespace motionlab::monitor {
namespace {

constexpr Nanoseconds kPoll = 20ms;

std::string hz(const std::optional<double>& rate) {
  return rate ? fixed(*rate, 2) + " Hz" : "rate unknown";
}

nlohmann::ordered_json number_or_null(const std::optional<double>& number) {
  return number ? nlohmann::ordered_json(*number) : nullptr;
}

bool fast_enough(const RateReport& report, double at_least_hz) {
  return !report.instances.empty() &&
         std::ranges::all_of(report.instances, [at_least_hz](const InstanceRate& rate) {
           return rate.on_bus_hz && *rate.on_bus_hz >= at_least_hz;
         });
}

}  // namespace

std::string rate_text(const std::string& topic, const TopicDescription& description, const RateMeter& meter,
                      const RateReport& report) {
  std::string text = escaped(topic) + ": " + std::to_string(report.heard) + " samples, by " +
                     std::string{meter.stamp()} + "\n";
  for (const InstanceRate& rate : report.instances) {
    text += "  " + (rate.instance.empty() ? "" : escaped(rate.instance) + "  ") + hz(rate.on_bus_hz);
    if (description.paced && rate.made_hz) text += " (made at " + hz(rate.made_hz) + ")";
    text += "  heard " + std::to_string(rate.heard);
    if (!description.paced) text += "  missing numbers " + std::to_string(rate.missing);
    if (rate.repeated > 0) text += "  repeated " + std::to_string(rate.repeated);
    if (rate.restarts > 0) text += "  restarts " + std::to_string(rate.restarts);
    if (rate.period_ms) {
      const Percentiles& jitter = rate.jitter_us;
      text += "  period " + fixed(*rate.period_ms, 3) + " ms  jitter p50 " + fixed(jitter.p50, 0) + " p95 " +
              fixed(jitter.p95, 0) + " p99 " + fixed(jitter.p99, 0) + " max " + fixed(jitter.max, 0) + " us";
    }
    text += "\n";
  }
  text +=
      "  lost on DDS " + std::to_string(report.lost_on_dds) + ", refused " + std::to_string(report.refused);
  if (report.overflowed > 0) text += ", not looked at in time " + std::to_string(report.overflowed);
  return text + "\n";
}

nlohmann::ordered_json rate_json(const std::string& topic, const TopicDescription& description,
                                 const RateMeter& meter, const RateReport& report) {
  nlohmann::ordered_json json;
  json["topic"] = topic;
  json["type"] = std::string{description.type};
  json["stamp"] = std::string{meter.stamp()};
  json["paced"] = description.paced;
  json["heard"] = report.heard;
  json["lost_on_dds"] = report.lost_on_dds;
  json["refused"] = report.refused;
  json["overflowed"] = report.overflowed;
  json["instances"] = nlohmann::ordered_json::array();
  for (const InstanceRate& rate : report.instances) {
    nlohmann::ordered_json one;
    one["instance"] = rate.instance;
    one["rate_hz"] = number_or_null(rate.on_bus_hz);
    one["made_hz"] = number_or_null(rate.made_hz);
    one["span_s"] = rate.span_s;
    one["heard"] = rate.heard;
    one["missing"] = rate.missing;
    one["repeated"] = rate.repeated;
    one["restarts"] = rate.restarts;
    one["period_median_ms"] = number_or_null(rate.period_ms);
    one["jitter_us"] = {{"p50", rate.jitter_us.p50},
                        {"p95", rate.jitter_us.p95},
                        {"p99", rate.jitter_us.p99},
                        {"max", rate.jitter_us.max}};
    json["instances"].push_back(std::move(one));
  }
  return json;
}

int run_rate(const Connection& connection, const RateCommand& command, const Terminal& terminal) {
  const RealClock clock;
  const auto wakeup = std::make_shared<bus::Wakeup>();
  bus::DdsWatch watch{dds_config(connection), wakeup};
  const LabTime start = clock.now();
  const FoundTopic topic = find_topic(watch, *wakeup, command.topic, connection, terminal);
  if (terminal.interrupted) return kExitInterrupted;
  const auto samples = tap(watch, *topic.description, topic.name);
  RateMeter meter{*topic.description};
  const Nanoseconds window = from_seconds(command.window_s);
  std::optional<LabTime> first;
  {
    Progress progress{terminal, "measuring " + topic.name};
    const auto over = [&] {
      if (command.count && meter.heard() >= *command.count) return true;
      const LabTime now = clock.now();
      return first ? now - *first >= window : now - start >= from_seconds(connection.timeout_s);
    };
    while (!terminal.interrupted && !over()) {
      wakeup->wait(kPoll);
      for (auto sample = samples->next(); sample; sample = samples->next()) {
        meter.take(*sample);
        if (!first) first = clock.now();
        if (command.count && meter.heard() >= *command.count) break;
      }
      if (first) progress.show(clock.now() - *first, window);
    }
  }
  const RateReport report = meter.report(samples->overflowed());
  if (report.heard == 0) {
    if (terminal.interrupted) return kExitInterrupted;
    terminal.err << (report.refused > 0
                         ? "nothing that came was a sample of " + std::string{topic.description->type}
                         : nothing_heard(topic, watch, connection, connection.timeout_s))
                 << "\n";
    return kExitNobody;
  }
  terminal.out << (command.json ? json_text(rate_json(topic.name, *topic.description, meter, report))
                                : rate_text(topic.name, *topic.description, meter, report));
  if (command.at_least_hz && !fast_enough(report, *command.at_least_hz)) {
    terminal.err << topic.name << " is not at " << fixed(*command.at_least_hz, 2) << " Hz or more\n";
    return kExitWrong;
  }
  return kExitGood;
}

}  // namespace motionlab::monitor
