#include "drivers/mru/mru_wire_variables.hpp"

#include <algorithm>

namespace motionlab::mru {
namespace {

using enum Variable;

constexpr std::array kFacts{
    VariableFacts{ang_rate_r, "AngRate_R", ValueType::f32, Quantity::rate, "rad/s", "body"},
    VariableFacts{ang_rate_p, "AngRate_P", ValueType::f32, Quantity::rate, "rad/s", "body"},
    VariableFacts{ang_rate_y, "AngRate_Y", ValueType::f32, Quantity::rate, "rad/s", "body"},
    VariableFacts{ang_rate_d, "AngRate_D", ValueType::f32, Quantity::rate, "rad/s", "heading"},
    VariableFacts{sensor_temperature, "SensorTemp", ValueType::f32, Quantity::temperature, "degC", ""},
    VariableFacts{ang_acc_r, "AngAcc_R", ValueType::f32, Quantity::motion, "rad/s2", "body"},
    VariableFacts{ang_acc_p, "AngAcc_P", ValueType::f32, Quantity::motion, "rad/s2", "body"},
    VariableFacts{ang_acc_y, "AngAcc_Y", ValueType::f32, Quantity::motion, "rad/s2", "body"},
    VariableFacts{roll, "Roll", ValueType::f32, Quantity::tilt, "rad", "heading"},
    VariableFacts{pitch, "Pitch", ValueType::f32, Quantity::tilt, "rad", "heading"},
    VariableFacts{yaw, "Yaw", ValueType::f32, Quantity::heading, "rad", "heading"},
    VariableFacts{system_time, "SystemTime", ValueType::i32, Quantity::time, "ms", ""},
    VariableFacts{acc_mru_r, "AccMru_R", ValueType::f32, Quantity::motion, "m/s2", "body"},
    VariableFacts{acc_mru_p, "AccMru_P", ValueType::f32, Quantity::motion, "m/s2", "body"},
    VariableFacts{acc_mru_y, "AccMru_Y", ValueType::f32, Quantity::motion, "m/s2", "body"},
    VariableFacts{vel_mru_r, "VelMru_R", ValueType::f32, Quantity::motion, "m/s", "body"},
    VariableFacts{vel_mru_p, "VelMru_P", ValueType::f32, Quantity::motion, "m/s", "body"},
    VariableFacts{vel_mru_y, "VelMru_Y", ValueType::f32, Quantity::motion, "m/s", "body"},
    VariableFacts{acc_cg_f, "AccCg_F", ValueType::f32, Quantity::motion, "m/s2", "heading"},
    VariableFacts{acc_cg_s, "AccCg_S", ValueType::f32, Quantity::motion, "m/s2", "heading"},
    VariableFacts{acc_cg_d, "AccCg_D", ValueType::f32, Quantity::motion, "m/s2", "heading"},
    VariableFacts{vel_cg_f, "VelCg_F", ValueType::f32, Quantity::motion, "m/s", "heading"},
    VariableFacts{vel_cg_s, "VelCg_S", ValueType::f32, Quantity::motion, "m/s", "heading"},
    VariableFacts{vel_cg_d, "VelCg_D", ValueType::f32, Quantity::motion, "m/s", "heading"},
    VariableFacts{pos_cg_f, "PosCg_F", ValueType::f32, Quantity::motion, "m", "heading"},
    VariableFacts{pos_cg_s, "PosCg_S", ValueType::f32, Quantity::motion, "m", "heading"},
    VariableFacts{pos_cg_d, "PosCg_D", ValueType::f32, Quantity::heave, "m", "heading"},
};

constexpr std::array kLaboratory{system_time, sensor_temperature, ang_rate_d, roll,      pitch,     yaw,
                                 ang_rate_r,  ang_rate_p,         ang_rate_y, vel_mru_r, vel_mru_p, vel_mru_y,
                                 acc_mru_r,   acc_mru_p,          acc_mru_y,  pos_cg_f,  pos_cg_s,  pos_cg_d,
                                 vel_cg_f,    vel_cg_s,           vel_cg_d,   acc_cg_f,  acc_cg_s,  acc_cg_d};

}  // namespace

const VariableFacts* facts_of(Variable variable) noexcept {
  for (const auto& facts : kFacts) {
    if (facts.variable == variable) return &facts;
  }
  return nullptr;
}

Result<VariableList> VariableList::of(std::span<const Variable> variables,
                                      std::span<const Variable> unlisted_f32,
                                      std::span<const Variable> unlisted_i32) noexcept {
  if (variables.empty()) return Fault{Reason::bad_value, "the variable list is empty: name at least one"};
  if (variables.size() > kMaxVariables) {
    return Fault{Reason::bad_value, "more than 63 variables do not fit into one MRU datagram"};
  }
  VariableList list;
  for (const Variable variable : variables) {
    if (list.index_of(variable)) return Fault{Reason::bad_value, "a variable is listed twice"};
    VariableFacts& facts = list.facts_[list.size_];
    if (const VariableFacts* known = facts_of(variable)) {
      facts = *known;
    } else if (std::ranges::find(unlisted_f32, variable) != unlisted_f32.end()) {
      facts = {variable, "", ValueType::f32, Quantity::unlisted, "", ""};
    } else if (std::ranges::find(unlisted_i32, variable) != unlisted_i32.end()) {
      facts = {variable, "", ValueType::i32, Quantity::unlisted, "", ""};
    } else {
      return Fault{Reason::bad_value,
                   "a variable number is not known: say its type, among the unlisted f32 or i32"};
    }
    ++list.size_;
  }
  return list;
}

const VariableList& VariableList::laboratory() noexcept {
  static const VariableList list = VariableList::of(kLaboratory).value();
  return list;
}

std::optional<std::size_t> VariableList::index_of(Variable variable) const noexcept {
  for (std::size_t i = 0; i < size_; ++i) {
    if (facts_[i].variable == variable) return i;
  }
  return std::nullopt;
}

}  // namespace motionlab::mru
