#include "simulators/lab/fault_matrix/table.hpp"

#include <algorithm>
#include <array>
#include <iomanip>
#include <iterator>
#include <map>
#include <sstream>
#include <vector>

#include "simulators/faults/common_faults.hpp"
#include "simulators/faults/wire_faults.hpp"

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
    case Ending::cannot_be:
      return "cannot be";
  }
  text += "; " + detected(o);
  if (cell.state != State::settled) text += "; " + degrees(o.swing_max_deg);
  const std::string limit = o.overshoot.worst();
  if (limit == "joint speed" && obeys_others(cell.fault)) {
    std::ostringstream share;
    share << std::fixed << std::setprecision(2) << o.overshoot.plant_joint_speed;
    text += "; ***at " + share.str() + " of the cap by bytes that we did not send: not stoppable by us***";
  } else if (!limit.empty()) {
    text += "; **EXCEEDS " + limit + "**";
  }
  if (o.moved_by_itself) text += "; **MOVED BY ITSELF**";
  return text;
}

/// Whose faults a table lists.
struct Subject {
  std::string device;
  Program program = Program::hardened;
  bool operator==(const Subject&) const = default;
};

Subject subject_of(const DeviceFault& fault) {
  return {fault.device, fault.program};
}

std::string heading(const Subject& subject) {
  if (subject.device != lab::kArm) return subject.device;
  return subject.device + ", robot computer " + std::string(to_string(subject.program)) +
         (subject.program == Program::hardened ? " (with a watchdog)"
                                               : " (the laboratory's own program, no watchdog)");
}

/// The largest shares and speeds over all cells.
struct Extremes {
  Overshoot most;
  double runaway_radps = 0;
  std::map<Ending, int> count;

  void add(const Entry& entry) {
    Outcome o = entry.outcome;
    ++count[o.ending];
    // What others command says nothing of our limits.
    if (obeys_others(entry.cell.fault))
      o.overshoot.plant_joint_speed = o.overshoot.plant_joint_speed_of_servo = 0;
    const auto grow = [&o, this](double Overshoot::*share) {
      most.*share = std::max(most.*share, o.overshoot.*share);
    };
    for (const auto share :
         {&Overshoot::joint_position_rad, &Overshoot::wire_length_m, &Overshoot::joint_speed,
          &Overshoot::joint_acceleration, &Overshoot::wire_speed, &Overshoot::wire_acceleration,
          &Overshoot::plant_joint_speed, &Overshoot::plant_wire_speed, &Overshoot::plant_joint_speed_of_servo,
          &Overshoot::plant_wire_speed_of_servo}) {
      grow(share);
    }
    if (o.ending == Ending::not_stoppable) runaway_radps = std::max(runaway_radps, o.joint_speed_max_radps);
  }
};

/// All states of one fault in a few letters: seen after, at rest after, in ms; the worst of each.
std::string in_short(const Matrix& matrix, const DeviceFault& fault) {
  std::vector<const Outcome*> states;
  for (const auto& [cell, outcome] : matrix) {
    if (cell.fault == fault) states.push_back(&outcome);
  }
  if (states.empty() || states.front()->ending == Ending::cannot_be) return "–";
  const auto any = [&states](Ending ending) {
    return std::any_of(states.begin(), states.end(), [&](const Outcome* o) { return o->ending == ending; });
  };
  const auto slowest = [&states](std::optional<double> Outcome::*after_s) {
    std::optional<double> worst;
    for (const Outcome* const o : states) worst = std::max(worst, o->*after_s);
    return worst;
  };
  const bool unseen = std::any_of(states.begin(), states.end(),
                                  [](const Outcome* o) { return !o->detected_after_s.has_value(); });
  std::string text = unseen ? "unseen" : milliseconds(slowest(&Outcome::detected_after_s));
  if (any(Ending::not_stoppable)) return text + " → **edge**";
  if (any(Ending::brakes_engaged)) return text + " → brakes";
  if (any(Ending::rests)) return text + " → " + milliseconds(slowest(&Outcome::at_rest_after_s));
  return text;
}

std::vector<std::string> words_of(std::string_view names) {
  std::istringstream words{std::string(names)};
  return {std::istream_iterator<std::string>(words), {}};
}

void tell_in_short(const Matrix& matrix, std::ostream& out) {
  const std::array<Subject, 6> columns{{{std::string(lab::kMru1)},
                                        {std::string(lab::kMru2)},
                                        {std::string(lab::kQualisys)},
                                        {std::string(lab::kWinch)},
                                        {std::string(lab::kArm), Program::hardened},
                                        {std::string(lab::kArm), Program::faithful}}};
  out << "| fault | mru1 | mru2 | cameras | winch | arm, with watchdog | arm, without |\n"
         "|---|---|---|---|---|---|---|\n";
  std::vector<std::string> common = words_of(faults::CommonFaults::kNames);
  const auto wire = words_of(faults::WireFaults::kNames);
  common.insert(common.end(), wire.begin(), wire.end());
  for (const std::string& name : common) {
    out << "| `" << name << "` |";
    for (const Subject& column : columns) {
      out << ' ' << in_short(matrix, {column.device, name, column.program}) << " |";
    }
    out << '\n';
  }
}

constexpr std::string_view kHowToRead =
    R"(# The fault matrix

Written by `tests/golden/remake_fault_matrix.sh`; do not edit. Every fault that a device or its wire has, in its own words
(`simulators/README.md`, `motionlab-sim --fault`), with its default value, in lockstep, seed 1. The device's fault begins while the
gateway is *settled* (and somebody asks to engage 3 s later), *engaged* on a calm ship, or *engaged* in a sea of Hs 0.5 m; it
lasts 5 s (the cameras' and those of a robot computer without a watchdog, engaged, 12 s), and 3 s more are watched.

## In short

After how many milliseconds a fault of the common words was seen → after how many arm and winch truly stood still; the worst of
the three states. No arrow: it was ridden through, or engaging was refused. *brakes*: the arm is held, the mode stays engaged.
*edge*: the arm ran to the edge of its box, and nothing on this side of the cable can stop it. –: the device cannot have it.

)";

constexpr std::string_view kTheWhole =
    R"(
## Every cell

What became of it · after how long it was seen, and by what first (`mode`: the mode changed or latched, with its code; `link`,
`advice`: in the device's health, told every 100 ms; `quality`: the sample's own word; `counted`: only a counter moved) · the
load's largest swing from then to the end of the run. *rests* is when arm and winch truly stood still. *rides through*: the
gateway stayed engaged. *cannot be*: the device or its wire refuses this fault by name; the reason stands below the table.
)";

/// Which faults the subject refuses, by reason.
void tell_refusals(const Matrix& matrix, const Subject& subject, std::ostream& out) {
  std::map<std::string, std::vector<std::string>> faults;
  for (const auto& [cell, outcome] : matrix) {
    if (outcome.ending != Ending::cannot_be || cell.state != State::settled) continue;
    if (subject_of(cell.fault) == subject) faults[outcome.code].push_back(cell.fault.name);
  }
  for (const auto& [reason, names] : faults) {
    out << '\n';
    for (const std::string& name : names) out << '`' << name << (name == names.back() ? "`" : "`, ");
    out << ": " << reason << ".\n";
  }
}

void tell_cells(const Matrix& matrix, std::ostream& out) {
  for (auto row = matrix.begin(); row != matrix.end();) {
    const Subject subject = subject_of(row->cell.fault);
    out << "\n### " << heading(subject) << "\n\n| fault |";
    for (const State state : kStates) out << ' ' << to_string(state) << " |";
    out << "\n|---|---|---|---|\n";
    while (row != matrix.end() && subject_of(row->cell.fault) == subject) {
      const DeviceFault& fault = row->cell.fault;
      out << "| `" << fault.name << "` |";
      for (; row != matrix.end() && row->cell.fault == fault; ++row) {
        out << ' ' << cell_text(row->cell, row->outcome) << " |";
      }
      out << '\n';
    }
    tell_refusals(matrix, subject, out);
  }
}

void tell_what_follows(const Matrix& matrix, std::ostream& out) {
  Extremes extremes;
  for (const Entry& entry : matrix) extremes.add(entry);
  const Overshoot& most = extremes.most;
  out << "\n## What follows\n\n" << matrix.size() << " cells:";
  for (const auto& [ending, count] : extremes.count) {
    out << (ending == extremes.count.begin()->first ? " " : ", ") << count << ' ' << to_string(ending);
  }
  out << std::fixed << std::setprecision(3)
      << ".\n\nWhat was commanded, as the largest share of its limit over all cells: joint speed "
      << most.joint_speed << ", joint acceleration " << most.joint_acceleration << ",\nwire speed "
      << most.wire_speed << ", wire acceleration " << most.wire_acceleration
      << ". Beyond the joints' box: " << 1e3 * most.joint_position_rad
      << " mrad, beyond the wire's: " << 1e3 * most.wire_length_m
      << " mm.\nSomething exceeded or moved by itself: " << offences(matrix).size()
      << ".\n\nThe plant's joints reached " << most.plant_joint_speed
      << " of the limit on what is commanded: their servos (damping 0.7) ring. A set point that\nreverses "
         "between ± the limit at the guard's acceleration overshoots by 8.9 % at 0.1 rad/s; the worst that "
         "any "
         "set point within the\nlimit can do to such a servo is (1 + M) / (1 − M) = 1.096 of it, with M its "
         "step response's overshoot "
         "(`simulators/lab/fault_matrix/servo_speed.hpp`).\nThe largest share of what the servo can do: "
      << most.plant_joint_speed_of_servo << " (wire " << most.plant_wire_speed_of_servo << ").\n";
  if (!extremes.count.contains(Ending::not_stoppable)) return;
  out << "\nA robot computer without a watchdog that hears nothing goes on with the last velocity until the "
         "edge of its box; nothing on\nthis side of the cable can stop it. The fastest that it went was "
      << extremes.runaway_radps << R"( rad/s. Hence the cap on authority in `lab.toml`:
as long as `[comau] watchdog = "none"` stands there, joints are held to 0.1 rad/s. The tool, 2.6 m from the first axis, then goes at
0.26 m/s, about what the robot controller calls safe beside people (0.25 m/s), and a joint of the crane is 5 s under way from the
middle of its box to the nearest edge: time for the person at the stop button. Without the cap it would be 1.4 m/s and one second.
)";
}

}  // namespace

std::string to_markdown(const Matrix& matrix) {
  std::ostringstream out;
  out << kHowToRead;
  tell_in_short(matrix, out);
  out << kTheWhole;
  tell_cells(matrix, out);
  tell_what_follows(matrix, out);
  return out.str();
}

}  // namespace motionlab::matrix
