#include "simulators/lab/fault_matrix/cell.hpp"

#include <algorithm>

#include "drivers/core/memory_network.hpp"
#include "drivers/core/time.hpp"
#include "simulators/lab/simulated_lab.hpp"

namespace motionlab::matrix {

namespace {

/// Why the device refuses this fault; empty: it does not.
std::string refusal(lab::SimulatedLab& lab, std::string_view device, const std::string& name) {
  const Status switched = lab.set_fault(device, name, true);
  std::string because = switched ? "" : std::string(switched.fault().text);
  because.resize(std::min(because.size(), because.find("; its wire: ")));  // which other names it knows
  (void)lab.set_fault(device, name, false);
  return because;
}

void add_faults_of(std::string_view device, const lab::LabConfig& config, Program program,
                   std::vector<KnownFault>& all) {
  SteppedClock clock;
  MemoryNetwork network(clock);
  lab::SimulatedLab lab(config, network, clock.now());
  for (const std::string& name : lab.fault_names(device)) {
    all.push_back({{std::string(device), name, program}, refusal(lab, device, name)});
  }
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

bool obeys_others(const DeviceFault& fault) {
  return fault.program == Program::faithful && (fault.name == "corrupt" || fault.name == "foreign" ||
                                                fault.name == "truncate" || fault.name == "torn");
}

std::vector<KnownFault> every_fault(const lab::LabConfig& config) {
  std::vector<KnownFault> all;
  for (const std::string_view device : {lab::kMru1, lab::kMru2, lab::kQualisys, lab::kWinch}) {
    add_faults_of(device, config, Program::hardened, all);
  }
  for (const Program program : {Program::hardened, Program::faithful}) {
    lab::LabConfig with = config;
    with.arm.hardened = program == Program::hardened;
    add_faults_of(lab::kArm, with, program, all);
  }
  return all;
}

Timetable Timetable::of(const Cell& cell) {
  // The gateway is ready 4 s after the start; engaged, it has the load still 4 s later.
  constexpr double kReady_s = 5, kStill_s = 10, kFault_s = 5, kAsked_s = 3, kAfterwards_s = 3;
  const double begins_s = cell.state == State::settled ? kReady_s : kStill_s;
  const bool slow = cell.state != State::settled &&
                    (cell.fault.device == lab::kQualisys || cell.fault.program == Program::faithful);
  const double ends_s = begins_s + (slow ? 12 : kFault_s);
  return {.engage_s = cell.state == State::settled ? kReady_s + kAsked_s : kReady_s,
          .fault_s = begins_s,
          .fault_ends_s = ends_s,
          .end_s = ends_s + kAfterwards_s};
}

}  // namespace motionlab::matrix
