#include "simulators/lab/fault_matrix/table.hpp"

#include <algorithm>
#include <iomanip>
#include <map>
#include <sstream>

namespace motionlab::matrix {

namespace {

std::string milliseconds(const std::optional<double>& value_s) {
  if (!value_s) return "–";
  std::ostringstream text;
  text << std::fixed << std::setprecision(0) << 1e3 * *value_s;
  return text.str();
}

std::string degrees(double value) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(value < 1 ? 2 : 1) << value << "°";
  return text.str();
}

std::string detected(const Outcome& o) {
  return o.detected_after_s ? milliseconds(o.detected_after_s) + " ms " + o.detected_by : "unseen";
}

/// What a cell says: what became of it, when and by what it was seen, how far the load swung.
std::string cell_text(const Cell& cell, const Outcome& o) {
  std::string text;
  switch (o.ending) {
    case Ending::rests:
      text = "**rests** " + milliseconds(o.at_rest_after_s) + " ms";
      break;
    case Ending::rides_through:
      text = "rides through";
      break;
    case Ending::refuses:
      text = "**refuses** " + o.code;
      break;
    case Ending::engages:
      text = "engages";
      break;
    case Ending::brakes_engaged:
      text = "*brakes, mode stays engaged*";
      break;
    case Ending::not_stoppable:
      text = "***runs to the box edge: not stoppable by us***";
      break;
  }
  text += "; " + detected(o);
  if (cell.state != State::settled) text += "; " + degrees(o.swing_max_deg);
  if (const std::string limit = o.overshoot.worst(); !limit.empty()) text += "; **EXCEEDS " + limit + "**";
  if (o.moved_by_itself) text += "; **MOVED BY ITSELF**";
  return text;
}

std::string heading(const DeviceFault& fault) {
  if (fault.device != lab::kArm) return fault.device;
  return fault.device + ", robot computer " + std::string(to_string(fault.program)) +
         (fault.program == Program::hardened ? " (with a watchdog)"
                                             : " (the laboratory's own program, no watchdog)");
}

/// The largest shares and speeds over all cells.
struct Extremes {
  double joint_speed = 0, joint_acceleration = 0, wire_speed = 0, wire_acceleration = 0;
  double beyond_rad = 0, beyond_m = 0, runaway_radps = 0;
  std::map<Ending, int> count;

  void add(const Outcome& o) {
    joint_speed = std::max(joint_speed, o.overshoot.joint_speed);
    joint_acceleration = std::max(joint_acceleration, o.overshoot.joint_acceleration);
    wire_speed = std::max(wire_speed, o.overshoot.wire_speed);
    wire_acceleration = std::max(wire_acceleration, o.overshoot.wire_acceleration);
    beyond_rad = std::max(beyond_rad, o.overshoot.joint_position_rad);
    beyond_m = std::max(beyond_m, o.overshoot.wire_length_m);
    if (o.ending == Ending::not_stoppable) runaway_radps = std::max(runaway_radps, o.joint_speed_max_radps);
    ++count[o.ending];
  }
};

constexpr std::string_view kHowToRead =
    "# The fault matrix\n\n"
    "Written by `tests/golden/remake_fault_matrix.sh`; do not edit. Every fault that a device or its wire "
    "has, in "
    "its own words\n(`simulators/README.md`, `motionlab-sim --fault`), with its default value, in lockstep, "
    "seed 1. The device's fault begins while the\ngateway is *settled* (and somebody asks to engage 3 s "
    "later), "
    "*engaged* on a calm ship, or *engaged* in a sea of Hs 0.5 m; it\nlasts 5 s (the cameras' and those of a "
    "robot "
    "computer without a watchdog 12 s), and 3 s more are watched.\n\n"
    "A cell says: what became of it · after how long it was seen, and by what first (`mode`: the mode "
    "changed or "
    "latched, with its\ncode; `link`, `advice`: in the device's health, told every 100 ms; `quality`: the "
    "sample's "
    "own word; `counted`: only a counter\nmoved) · the load's largest swing from then to the end of the run. "
    "*rests* is "
    "when arm and winch truly stood still. *rides through*:\nthe gateway stayed engaged.\n";

}  // namespace

std::string to_markdown(const Matrix& matrix) {
  std::ostringstream out;
  out << kHowToRead;
  Extremes extremes;
  std::string head;
  std::size_t offended = offences(matrix).size();
  for (auto row = matrix.begin(); row != matrix.end();) {
    const DeviceFault& fault = row->cell.fault;
    if (heading(fault) != head) {
      head = heading(fault);
      out << "\n## " << head << "\n\n| fault |";
      for (const State state : kStates) out << ' ' << to_string(state) << " |";
      out << "\n|---|---|---|---|\n";
    }
    out << "| `" << fault.name << "` |";
    for (; row != matrix.end() && row->cell.fault == fault; ++row) {
      extremes.add(row->outcome);
      out << ' ' << cell_text(row->cell, row->outcome) << " |";
    }
    out << '\n';
  }
  out << "\n## What follows\n\n" << matrix.size() << " cells:";
  for (const auto& [ending, count] : extremes.count) {
    out << (ending == extremes.count.begin()->first ? " " : ", ") << count << ' ' << to_string(ending);
  }
  out << std::fixed << std::setprecision(2) << ".\n\nLimits, largest share over all cells: joint speed "
      << extremes.joint_speed << ", joint acceleration on the wire " << extremes.joint_acceleration
      << ", wire speed " << extremes.wire_speed << ",\nwire acceleration " << extremes.wire_acceleration
      << "; beyond the joints' box " << 1e3 * extremes.beyond_rad << " mrad, beyond the wire's "
      << 1e3 * extremes.beyond_m << " mm. Something exceeded or moved by itself: " << offended << ".\n";
  if (extremes.count.contains(Ending::not_stoppable)) {
    out << "\nA robot computer without a watchdog that hears nothing goes on with the last velocity until "
           "the "
           "edge of its box; nothing on\nthis side of the cable can stop it. The fastest that it went was "
        << extremes.runaway_radps
        << " rad/s: this is why `lab.toml` caps the joints at\n0.1 rad/s as long as `[comau] watchdog = "
           "\"none\"` stands there, and why a person stands at the stop button.\n";
  }
  return out.str();
}

}  // namespace motionlab::matrix
