#include "simulators/lab/study/fault_matrix_run.hpp"

#include <cmath>
#include <map>
#include <utility>

#include "drivers/comau/comau_wire.hpp"
#include "drivers/core/error.hpp"
#include "gateway/monitor/motion_score.hpp"
#include "gateway/service/snapshot.hpp"
#include "simulators/lab/fault_matrix/cell_watch.hpp"
#include "simulators/lab/study/two_at_a_time.hpp"

namespace motionlab::study {

namespace {

using matrix::Cell;
using matrix::Program;
using matrix::State;

constexpr Nanoseconds kHealthPeriod = 10ms;

/// A robot computer without a watchdog is one that lab.toml knows to have none: the cap on the joints' speed
/// is part of what is looked at.
lockstep::Config configure_cell(LabRun run, State state, Program program) {
  run.scenario = state == State::calm ? "calm" : "sea";
  if (program == Program::faithful) {
    run.settings.insert(run.settings.end(), {"world.devices.arm.hardened=false", "lab.comau.watchdog=none"});
  }
  return configure(run);
}

matrix::Truth truth_of(lab::SimulatedLab& lab) {
  const plant::WorldState s = lab.state();
  const auto swing = [](const plant::HangingState& hanging) {
    return monitor::degrees(std::hypot(hanging.swing_rad[0], hanging.swing_rad[1]));
  };
  return {.q_rad = s.q_rad,
          .qd_radps = s.qd_radps,
          .wire_length_m = s.winch_length_m,
          .wire_speed_mps = s.winch_speed_mps,
          .swing_deg = swing(s.crane),
          .twin_swing_deg = swing(s.twin)};
}

/// Whether the newest samples of a device call themselves good.
bool samples_are_good(bus::LocalBus& bus, std::string_view device) {
  bool good = true;
  bus.for_each_newest<topic::Mru>([&](const topic::Mru& mru) {
    if (mru.device.view() == device) good = mru.stable && !mru.checksum_suspect;
  });
  bus.for_each_newest<topic::Bodies>([&](const topic::Bodies& body) {
    if (body.device.view() == device) good = good && body.tracked;
  });
  bus.for_each_newest<topic::WinchState>([&](const topic::WinchState& winch) {
    if (winch.device.view() == device) good = !winch.error && winch.command_path_alive;
  });
  return good;
}

/// Velocities of the command, in SI.
std::array<double, 6> velocities(const comau::Command& command) {
  std::array<double, 6> qd{};
  for (std::size_t j = 0; j < qd.size(); ++j) qd[j] = static_cast<double>(command.qd_radps[j]);
  return qd;
}

matrix::Outcome run_cell(const Cell& cell, lockstep::Config config) {
  const auto times = matrix::Timetable::of(cell);
  lab::PlannedFault fault;
  fault.device = cell.fault.device;
  fault.fault = cell.fault.name;
  fault.from_s = times.fault_s;
  fault.until_s = times.fault_ends_s;
  config.faults = {fault};
  lockstep::Lockstep line(config);
  matrix::CellWatch watch(cell, config.gateway, config.lab);
  line.network().on_sent([&](Endpoint, Endpoint to, Bytes datagram, LabTime t) {
    if (to != config.gateway.comau.driver.robot_computer) return;
    if (const auto command = comau::decode_command(datagram)) {
      watch.sent(t, command->mode == static_cast<std::int32_t>(comau::Mode::follow), velocities(*command));
    }
  });
  auto mode = line.bus().reader<topic::Mode>();
  auto winch =
      line.bus().reader<topic::WinchCommand>(config.gateway.winch.driver.device, service::kGatewayRequester);
  auto health = line.bus().reader<topic::Health>(cell.fault.device);
  const LabTime end = LabTime{} + from_seconds(times.end_s);
  const LabTime engage = LabTime{} + from_seconds(times.engage_s);
  LabTime next_health{};
  for (bool asked = false; line.now() < end;) {
    if (!asked && line.now() >= engage) {
      line.request(topic::ModeAction::engage);
      asked = true;
    }
    line.step();
    const LabTime t = line.now();
    if (const auto sample = mode.newer()) watch.take(t, *sample);
    if (const auto sample = winch.newer()) watch.take(t, *sample);
    watch.quality(t, samples_are_good(line.bus(), cell.fault.device));
    if (t >= next_health) {
      if (const auto sample = health.newer()) watch.take(t, *sample);
      next_health = t + kHealthPeriod;
    }
    watch.take(t, truth_of(line.lab()));
  }
  return watch.outcome();
}

}  // namespace

matrix::Matrix run_fault_matrix(const LabRun& base, const std::string& only) {
  std::map<std::pair<State, Program>, lockstep::Config> configs;
  for (const State state : matrix::kStates) {
    for (const Program program : {Program::hardened, Program::faithful}) {
      configs[{state, program}] = configure_cell(base, state, program);
    }
  }
  auto faults = matrix::every_fault(configs[{State::sea, Program::hardened}].lab);
  std::erase_if(faults, [&only](const matrix::KnownFault& known) {
    return !only.empty() && known.fault.device != only && known.fault.device + ":" + known.fault.name != only;
  });
  if (faults.empty()) {
    throw StartupError("no fault \"" + only +
                       "\"; write a device (mru1, mru2, qualisys, winch, arm) or DEVICE:FAULT");
  }
  matrix::Matrix entries;
  for (const auto& [fault, refusal] : faults) {
    for (const State state : matrix::kStates) {
      entries.push_back({{fault, state}, {}});
      if (refusal.empty()) continue;
      entries.back().outcome.ending = matrix::Ending::cannot_be;
      entries.back().outcome.code = refusal;
    }
  }
  two_at_a_time(entries.size(), [&](std::size_t i) {
    const Cell& cell = entries[i].cell;
    if (entries[i].outcome.ending == matrix::Ending::cannot_be) return;
    entries[i].outcome = run_cell(cell, configs.at({cell.state, cell.fault.program}));
  });
  return entries;
}

}  // namespace motionlab::study
