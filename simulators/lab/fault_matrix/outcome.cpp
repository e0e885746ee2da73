#include "simulators/lab/fault_matrix/outcome.hpp"

#include <array>
#include <utility>

namespace motionlab::matrix {

namespace {

constexpr std::array kEndings{
    std::pair{Ending::rests, std::string_view("rests")},
    std::pair{Ending::rides_through, std::string_view("rides through")},
    std::pair{Ending::refuses, std::string_view("refuses to engage")},
    std::pair{Ending::engages, std::string_view("engages")},
    std::pair{Ending::brakes_engaged, std::string_view("brakes, mode stays engaged")},
    std::pair{Ending::not_stoppable, std::string_view("runs to the box edge: not stoppable by us")},
    std::pair{Ending::cannot_be, std::string_view("cannot be")},
};

}  // namespace

std::string Overshoot::worst() const {
  constexpr double kJoint_rad = 0.002, kWire_m = 0.005;
  constexpr double kRounding = 1.001;  // velocities are 32-bit numbers on the arm's wire
  if (joint_position_rad > kJoint_rad) return "joint position";
  if (wire_length_m > kWire_m) return "wire length";
  if (joint_speed > 1) return "commanded joint speed";
  if (wire_speed > 1) return "commanded wire speed";
  if (plant_wire_speed_of_servo > 1) return "wire speed";
  if (joint_acceleration > kRounding) return "joint acceleration";
  if (wire_acceleration > kRounding) return "wire acceleration";
  if (plant_joint_speed_of_servo > 1) return "joint speed";
  return {};
}

std::string_view to_string(Ending ending) {
  for (const auto& [value, text] : kEndings) {
    if (value == ending) return text;
  }
  return "";
}

std::optional<Ending> ending_of(std::string_view text) {
  for (const auto& [value, name] : kEndings) {
    if (name == text) return value;
  }
  return std::nullopt;
}

}  // namespace motionlab::matrix
