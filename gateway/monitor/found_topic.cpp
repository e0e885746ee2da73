#include "gateway/monitor/found_topic.hpp"

#include <algorithm>
#include <utility>

#include "drivers/core/error.hpp"
#include "gateway/monitor/nearest_name.hpp"
#include "gateway/monitor/progress.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"

namespace motionlab::monitor {
namespace {

constexpr Nanoseconds kPoll = 50ms;
/// Once one writer is known, others of the topic may still be on their way.
constexpr Nanoseconds kOthersMayCome = 300ms;

std::string full_name(const std::string& wanted) {
  if (topic_named(wanted)) return wanted;
  const std::string with_prefix = "motionlab/" + wanted;
  return topic_named(with_prefix) ? with_prefix : wanted;
}

[[noreturn]] void refuse(const bus::DdsWatch& watch, const std::string& name) {
  const auto writers = watch.writers_of(name);
  if (!writers.empty()) {
    throw StartupError{"the topic " + escaped(name) + " is on the bus, written by " + who(writers.front()) +
                       ", but its type " + escaped(writers.front().type) + " is not known to motionlab"};
  }
  std::vector<std::string> names;
  for (const TopicDescription& topic : every_topic()) names.emplace_back(topic.name);
  for (const bus::SeenEndpoint& end : watch.endpoints()) names.push_back(escaped(end.topic));
  throw StartupError{"there is no topic " + escaped(name) + did_you_mean(name, names) +
                     " See motionlab topics for what is on the bus"};
}

}  // namespace

FoundTopic find_topic(bus::DdsWatch& watch, bus::Wakeup& wakeup, const std::string& wanted,
                      const Connection& connection, const Terminal& terminal) {
  FoundTopic found{.name = full_name(wanted), .description = topic_named(full_name(wanted))};
  if (found.description) return found;

  const RealClock clock;
  const Nanoseconds timeout = from_seconds(connection.timeout_s);
  Progress progress{terminal, "looking for a writer of " + wanted};
  const LabTime start = clock.now();
  LabTime end = start + timeout;
  bool seen = false;
  while (!terminal.interrupted && !found.description && clock.now() < end) {
    for (const bus::SeenEndpoint& writer : watch.writers_of(wanted)) {
      if (!found.description) found.description = topic_of_type(writer.type);
      if (!std::exchange(seen, true)) end = std::min(end, clock.now() + kOthersMayCome);
    }
    progress.show(clock.now() - start, timeout);
    wakeup.wait(kPoll);
  }
  progress.clear();
  if (!found.description && !terminal.interrupted) refuse(watch, wanted);
  return found;
}

std::string who(const bus::SeenEndpoint& endpoint) {
  std::string text = endpoint.participant.empty() ? "somebody without a name" : escaped(endpoint.participant);
  if (!endpoint.host.empty()) text += " on " + escaped(endpoint.host);
  return text;
}

std::string nothing_heard(const FoundTopic& topic, const bus::DdsWatch& watch, const Connection& connection,
                          double waited_s) {
  const auto writers = watch.writers_of(topic.name);
  const std::string waited = " within " + fixed(waited_s, 1) + " s";
  if (writers.empty()) {
    return "nobody writes " + escaped(topic.name) + "; " + nobody_answers(connection, waited_s);
  }
  const bus::SeenEndpoint& writer = writers.front();
  if (writer.type != topic.description->type) {
    return who(writer) + " writes " + escaped(topic.name) + " with the type " + escaped(writer.type) +
           ", not " + std::string{topic.description->type};
  }
  if (!writer.qos.xcdr1) {
    return who(writer) + " writes " + escaped(topic.name) +
           " in the encoding XCDR2 only; let it offer XCDR1 as well (final types do by default)";
  }
  return who(writer) + " has a writer of " + escaped(topic.name) + ", but it said nothing" + waited;
}

}  // namespace motionlab::monitor
