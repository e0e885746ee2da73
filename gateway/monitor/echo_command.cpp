#include "gateway/monitor/echo_command.hpp"

#include <array>
#include <ostream>
#include <utility>

#include "drivers/core/error.hpp"
#include "gateway/monitor/field_selection.hpp"
#include "gateway/monitor/found_topic.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/sample_text.hpp"

namespace motionlab::monitor {
namespace {

constexpr Nanoseconds kPoll = 50ms;

const Field* device_field(const EchoCommand& command, const TopicDescription& topic) {
  if (!command.device) return nullptr;
  const Field* const field = topic.field("device");
  if (!field) throw StartupError{std::string{topic.name} + " has no field device: leave --device away"};
  return field;
}

std::string written(const EchoCommand& command, const std::vector<Selected>& fields, const Values& values) {
  switch (command.format) {
    case EchoCommand::Format::json:
      return as_json_line(fields, values);
    case EchoCommand::Format::csv:
      return as_csv(fields, values);
    case EchoCommand::Format::text:
      break;
  }
  return command.fields.empty() ? as_block(fields, values) : as_line(fields, values);
}

}  // namespace

int run_echo(const Connection& connection, const EchoCommand& command, const Terminal& terminal) {
  const RealClock clock;
  const auto wakeup = std::make_shared<bus::Wakeup>();
  bus::DdsWatch watch{dds_config(connection), wakeup};
  const LabTime start = clock.now();
  const FoundTopic topic = find_topic(watch, *wakeup, command.topic, connection, terminal);
  if (terminal.interrupted) return kExitInterrupted;
  const std::vector<Selected> fields = select_fields(*topic.description, command.fields);
  const Field* const device = device_field(command, *topic.description);
  const auto samples = tap(watch, *topic.description, topic.name);

  std::uint64_t shown = 0;
  std::array<bool, static_cast<std::size_t>(bus::Refusal::count_)> told{};
  const LabTime end = start + from_seconds(connection.timeout_s);
  const auto complete = [&] { return command.count && shown >= *command.count; };
  while (!terminal.interrupted && !complete() && terminal.out) {
    if (shown == 0 && clock.now() >= end) break;
    wakeup->wait(kPoll);
    for (auto sample = samples->next(); sample && !complete(); sample = samples->next()) {
      if (!sample->data) continue;
      if (sample->refusal != bus::Refusal::none) {
        if (!std::exchange(told[static_cast<std::size_t>(sample->refusal)], true)) {
          terminal.err << "a sample of " << escaped(topic.name)
                       << " is not shown: " << to_string(sample->refusal) << "\n";
        }
        continue;
      }
      if (device && std::get<std::string>(sample->values[device->first]) != *command.device) continue;
      if (shown++ == 0 && command.format == EchoCommand::Format::csv) terminal.out << csv_header(fields);
      terminal.out << written(command, fields, sample->values);
    }
    terminal.out << std::flush;
  }
  if (const std::uint64_t missed = samples->overflowed()) {
    terminal.err << missed << " samples came faster than they could be written and are missing\n";
  }
  if (shown == 0) {
    if (terminal.interrupted) return kExitInterrupted;
    terminal.err << nothing_heard(topic, watch, connection, connection.timeout_s)
                 << (device ? " (for device " + escaped(*command.device) + ")" : "") << "\n";
    return kExitNobody;
  }
  return command.count && !complete() ? kExitWrong : kExitGood;
}

}  // namespace motionlab::monitor
