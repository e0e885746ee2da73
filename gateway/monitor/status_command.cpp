#include "gateway/monitor/status_command.hpp"

#include <ostream>

#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"

namespace motionlab::monitor {
namespace {

/// Devices come one by one, ten times a second: by then every one has been heard.
constexpr Nanoseconds kHealthRound = 300ms;
constexpr Nanoseconds kPoll = 50ms;

nlohmann::ordered_json to_json(const Status& status) {
  nlohmann::ordered_json json;
  json["healthy"] = status.healthy();
  json["mode"] = status.mode ? topic_json(*status.mode) : nullptr;
  json["devices"] = nlohmann::ordered_json::array();
  for (const topic::Health& device : status.devices) json["devices"].push_back(topic_json(device));
  return json;
}

}  // namespace

bool Status::healthy() const {
  if (!mode || devices.empty()) return false;
  for (const topic::Health& device : devices) {
    if (device.link != topic::LinkState::up) return false;
  }
  switch (mode->state) {
    case topic::ModeState::off:
    case topic::ModeState::fault:
      return false;
    case topic::ModeState::settled:
      return mode->fault_code.empty();  // else it names what keeps the gateway from being ready
    case topic::ModeState::ready:
    case topic::ModeState::engaged:
    case topic::ModeState::stopping:
      break;
  }
  return true;
}

Status hear_status(const Connection& connection, const std::atomic<bool>& interrupted) {
  Session session{connection};
  session.dds.in<topic::Mode>();
  session.dds.in<topic::Health>();
  const auto mode = session.local.reader<topic::Mode>();
  // Only for being woken: the values are read from the bus.
  const auto modes = session.local.subscribe<topic::Mode>(session.wakeup);
  const auto healths = session.local.subscribe<topic::Health>(session.wakeup);
  session.dds.start();

  Status status;
  LabTime end = session.clock.now() + from_seconds(connection.timeout_s);
  bool complete = false;
  while (!interrupted && session.clock.now() < end) {
    session.wakeup->wait(kPoll);
    status.mode = mode.newest();
    status.devices.clear();
    session.local.for_each_newest<topic::Health>(
        [&status](const topic::Health& health) { status.devices.push_back(health); });
    if (!complete && status.mode && !status.devices.empty()) {
      complete = true;
      end = session.clock.now() + kHealthRound;
    }
  }
  std::ranges::sort(status.devices, {}, [](const topic::Health& health) { return health.device.view(); });
  return status;
}

int run_status(const Connection& connection, bool json, const Terminal& terminal) {
  const Status status = hear_status(connection, terminal.interrupted);
  if (terminal.interrupted) return kExitInterrupted;
  if (json) {
    terminal.out << json_text(to_json(status));
  } else {
    const Paint paint{terminal.colour};
    if (status.mode) terminal.out << "gateway    " << mode_line(*status.mode, paint) << "\n";
    for (const topic::Health& device : status.devices) terminal.out << device_line(device, paint) << "\n";
  }
  if (status.nobody()) {
    terminal.err << nobody_answers(connection, connection.timeout_s) << "\n";
    return kExitNobody;
  }
  if (!status.mode) terminal.err << "the devices report, but the gateway's mode is missing\n";
  if (status.devices.empty()) terminal.err << "the gateway says its mode, but nothing of its devices\n";
  return status.healthy() ? kExitGood : kExitWrong;
}

}  // namespace motionlab::monitor
