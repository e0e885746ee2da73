#include "simulators/lab/fault_matrix/report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "drivers/core/error.hpp"

namespace motionlab::matrix {

namespace {

using Json = nlohmann::ordered_json;

/// Digits that mean something; the rest would only make the file longer.
double rounded(double value) {
  constexpr double kDigits = 1e5;
  return std::round(value * kDigits) / kDigits;
}

Json or_null(const std::optional<double>& value) {
  return value ? Json(rounded(*value)) : Json(nullptr);
}
std::optional<double> number(const Json& value) {
  return value.is_null() ? std::nullopt : std::optional(value.get<double>());
}
Json or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}
std::string text(const Json& value) {
  return value.is_null() ? std::string() : value.get<std::string>();
}

Json json_of(const Entry& entry) {
  const auto& [cell, o] = entry;
  const bool arm = cell.fault.device == lab::kArm;
  return {{"device", cell.fault.device},
          {"fault", cell.fault.name},
          {"program", arm ? Json(to_string(cell.fault.program)) : Json(nullptr)},
          {"state", to_string(cell.state)},
          {"in_state", o.in_state},
          {"ending", to_string(o.ending)},
          {"code", or_null(o.code)},
          {"detected_after_s", or_null(o.detected_after_s)},
          {"detected_by", or_null(o.detected_by)},
          {"at_rest_after_s", or_null(o.at_rest_after_s)},
          {"swing_max_deg", rounded(o.swing_max_deg)},
          {"swing_rms_deg", rounded(o.swing_rms_deg)},
          {"twin_swing_max_deg", rounded(o.twin_swing_max_deg)},
          {"joint_speed_max_radps", rounded(o.joint_speed_max_radps)},
          {"limits",
           {{"exceeded", or_null(o.overshoot.worst())},
            {"joint_position_rad", rounded(o.overshoot.joint_position_rad)},
            {"wire_length_m", rounded(o.overshoot.wire_length_m)},
            {"joint_speed", rounded(o.overshoot.joint_speed)},
            {"joint_acceleration", rounded(o.overshoot.joint_acceleration)},
            {"wire_speed", rounded(o.overshoot.wire_speed)},
            {"wire_acceleration", rounded(o.overshoot.wire_acceleration)},
            {"plant_joint_speed", rounded(o.overshoot.plant_joint_speed)},
            {"plant_wire_speed", rounded(o.overshoot.plant_wire_speed)},
            {"plant_joint_speed_of_servo", rounded(o.overshoot.plant_joint_speed_of_servo)},
            {"plant_wire_speed_of_servo", rounded(o.overshoot.plant_wire_speed_of_servo)}}},
          {"advised", o.advised},
          {"moved_by_itself", o.moved_by_itself}};
}

State state_of(const std::string& name) {
  for (const State state : kStates) {
    if (to_string(state) == name) return state;
  }
  throw StartupError("no state of a fault matrix is called \"" + name + "\"");
}

Entry entry_of(const Json& json) {
  Entry entry;
  entry.cell.fault.device = json.at("device").get<std::string>();
  entry.cell.fault.name = json.at("fault").get<std::string>();
  entry.cell.fault.program =
      text(json.at("program")) == to_string(Program::faithful) ? Program::faithful : Program::hardened;
  entry.cell.state = state_of(json.at("state").get<std::string>());
  Outcome& o = entry.outcome;
  const auto ending = ending_of(json.at("ending").get<std::string>());
  o.in_state = json.at("in_state").get<bool>();
  if (!ending) throw StartupError("nothing in a fault matrix ends with " + json.at("ending").dump());
  o.ending = *ending;
  o.code = text(json.at("code"));
  o.detected_after_s = number(json.at("detected_after_s"));
  o.detected_by = text(json.at("detected_by"));
  o.at_rest_after_s = number(json.at("at_rest_after_s"));
  o.swing_max_deg = json.at("swing_max_deg").get<double>();
  o.swing_rms_deg = json.at("swing_rms_deg").get<double>();
  o.twin_swing_max_deg = json.at("twin_swing_max_deg").get<double>();
  o.joint_speed_max_radps = json.at("joint_speed_max_radps").get<double>();
  const Json& limits = json.at("limits");
  o.overshoot.joint_position_rad = limits.at("joint_position_rad").get<double>();
  o.overshoot.wire_length_m = limits.at("wire_length_m").get<double>();
  o.overshoot.joint_speed = limits.at("joint_speed").get<double>();
  o.overshoot.joint_acceleration = limits.at("joint_acceleration").get<double>();
  o.overshoot.wire_speed = limits.at("wire_speed").get<double>();
  o.overshoot.wire_acceleration = limits.at("wire_acceleration").get<double>();
  o.overshoot.plant_joint_speed = limits.at("plant_joint_speed").get<double>();
  o.overshoot.plant_wire_speed = limits.at("plant_wire_speed").get<double>();
  o.overshoot.plant_joint_speed_of_servo = limits.at("plant_joint_speed_of_servo").get<double>();
  o.overshoot.plant_wire_speed_of_servo = limits.at("plant_wire_speed_of_servo").get<double>();
  o.advised = json.at("advised").get<bool>();
  o.moved_by_itself = json.at("moved_by_itself").get<bool>();
  return entry;
}

/// How a number is worse than the recorded one; empty when it is not.
std::string later(std::string_view what, const std::optional<double>& now,
                  const std::optional<double>& recorded, double margin, std::string_view unit) {
  if (!recorded) return {};
  const double bound = 1.25 * *recorded + margin;
  if (now && *now <= bound) return {};
  std::ostringstream sentence;
  sentence << what << ' ';
  if (now) {
    sentence << *now << ' ' << unit;
  } else {
    sentence << "never";
  }
  sentence << ", the bound is " << bound << ' ' << unit;
  return sentence.str();
}

std::string worse(const Outcome& now, const Outcome& recorded) {
  if (now.ending != recorded.ending) {
    return "it " + std::string(to_string(now.ending)) + (now.code.empty() ? "" : " (" + now.code + ")") +
           ", recorded is: " + std::string(to_string(recorded.ending));
  }
  const bool rides = now.ending == Ending::rides_through || now.ending == Ending::engages;
  for (const std::string& offence :
       {later("detected after", now.detected_after_s, recorded.detected_after_s, 0.05, "s"),
        later("at rest after", now.at_rest_after_s, recorded.at_rest_after_s, 0.1, "s"),
        later("fastest joint", now.overshoot.plant_joint_speed, recorded.overshoot.plant_joint_speed, 0.05,
              "of the limit"),
        later("largest swing", now.swing_max_deg, recorded.swing_max_deg, 0.5, "deg"),
        rides ? later("swing rms", now.swing_rms_deg, recorded.swing_rms_deg, 0.05, "deg") : std::string()}) {
    if (!offence.empty()) return offence;
  }
  return {};
}

const Entry* find(const Matrix& matrix, const Cell& cell) {
  const auto found =
      std::find_if(matrix.begin(), matrix.end(), [&](const Entry& entry) { return entry.cell == cell; });
  return found == matrix.end() ? nullptr : &*found;
}

}  // namespace

std::string to_json(const Matrix& matrix) {
  std::string text = "[\n";
  for (const Entry& entry : matrix) {
    text.append(json_of(entry).dump()).append(&entry == &matrix.back() ? "\n" : ",\n");
  }
  return text.append("]\n");
}

Matrix from_json(const std::string& text) {
  Matrix matrix;
  try {
    for (const Json& json : Json::parse(text)) matrix.push_back(entry_of(json));
  } catch (const nlohmann::json::exception& problem) {
    throw StartupError(std::string("not a fault matrix: ") + problem.what() +
                       "; make one with motionlab-study --fault-matrix --report FILE");
  }
  return matrix;
}

std::vector<std::string> offences(const Matrix& matrix) {
  std::vector<std::string> all;
  for (const auto& [cell, outcome] : matrix) {
    const auto say = [&all, &title = cell](const std::string& what) {
      all.push_back(title.title() + ": " + what);
    };
    const std::string limit = outcome.overshoot.worst();
    if (!limit.empty() && !(limit == "joint speed" && obeys_others(cell.fault))) say("exceeds " + limit);
    if (outcome.ending == Ending::cannot_be) continue;
    if (!outcome.in_state) say("the gateway was not in this state when the fault came");
    if (outcome.moved_by_itself) say("something moved by itself");
    const bool no_watchdog = cell.fault.device == lab::kArm && cell.fault.program == Program::faithful;
    if (outcome.ending == Ending::not_stoppable && !no_watchdog) say("the arm did not stop");
  }
  return all;
}

std::vector<std::string> worse(const Matrix& now, const Matrix& recorded) {
  std::vector<std::string> all;
  for (const auto& [cell, outcome] : now) {
    const Entry* const before = find(recorded, cell);
    const std::string offence = before ? worse(outcome, before->outcome) : "nothing is recorded of it";
    if (!offence.empty()) all.push_back(cell.title() + ": " + offence);
  }
  for (const auto& [cell, outcome] : recorded) {
    if (!find(now, cell)) all.push_back(cell.title() + ": recorded, but there is no such cell any more");
  }
  return all;
}

}  // namespace motionlab::matrix
