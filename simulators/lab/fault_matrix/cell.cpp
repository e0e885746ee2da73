#include "simulators/lab/fault_matrix/cell.hpp"

#include "drivers/core/memory_network.hpp"
#include "drivers/core/time.hpp"
#include "simulators/lab/simulated_lab.hpp"

namespace motionlab::matrix {

namespace {

std::vector<std::string> supported(const lab::LabConfig& config, std::string_view device) {
  SteppedClock clock;
  MemoryNetwork network(clock);
  lab::SimulatedLab lab(config, network, clock.now());
  std::vector<std::string> faults = lab.fault_names(device);
  std::erase_if(faults, [&](const std::string& name) {
    const bool refused = !lab.set_fault(device, name, true);
    (void)lab.set_fault(device, name, false);
    return refused;
  });
  return faults;
}

}  // namespace

std::string_view to_string(State state) {
  switch (state) {
    case State::settled:
      return "settled";
    case State::calm:
      return "engaged calm";
    case State::sea:
      return "engaged in sea";
  }
  return "";
}

std::string_view to_string(Program program) {
  return program == Program::hardened ? "hardened" : "faithful";
}

std::string Cell::title() const {
  std::string title = fault.device + ":" + fault.name;
  if (fault.device == lab::kArm) title.append(" ").append(to_string(fault.program));
  return title.append(", ").append(to_string(state));
}

std::vector<DeviceFault> every_fault(const lab::LabConfig& config) {
  std::vector<DeviceFault> all;
  for (const std::string_view device : {lab::kMru1, lab::kMru2, lab::kQualisys, lab::kWinch}) {
    for (auto& name : supported(config, device)) all.push_back({std::string(device), std::move(name)});
  }
  for (const Program program : {Program::hardened, Program::faithful}) {
    lab::LabConfig with = config;
    with.arm.hardened = program == Program::hardened;
    for (auto& name : supported(with, lab::kArm)) {
      all.push_back({std::string(lab::kArm), std::move(name), program});
    }
  }
  return all;
}

std::vector<Cell> every_cell(const std::vector<DeviceFault>& faults) {
  std::vector<Cell> cells;
  for (const DeviceFault& fault : faults) {
    for (const State state : kStates) cells.push_back({fault, state});
  }
  return cells;
}

Timetable Timetable::of(const Cell& cell) {
  if (cell.state == State::settled) return {.engage_s = 7, .fault_s = 4, .fault_ends_s = 9, .end_s = 12};
  constexpr double kFault_s = 10, kAfterwards_s = 3;
  const bool slow = cell.fault.device == lab::kQualisys || cell.fault.program == Program::faithful;
  const double ends_s = kFault_s + (slow ? 12 : 5);
  return {.engage_s = 4, .fault_s = kFault_s, .fault_ends_s = ends_s, .end_s = ends_s + kAfterwards_s};
}

}  // namespace motionlab::matrix
