#include "simulators/qualisys/qualisys_device_faults.hpp"

#include <algorithm>
#include <array>

#include "drivers/qualisys/qualisys_wire_text.hpp"

namespace motionlab::qualisys {

namespace {

struct Known {
  std::string_view name;
  double default_value = 0.0;
};
constexpr auto kKnown = std::to_array<Known>(
    {{"silent"},           {"occlude"},           {"residual", 0.005},    {"drop_rate", 0.5},
     {"out_of_sync", 0.5}, {"skip_frames", 2},    {"stop_measurement"},   {"calibrate"},
     {"restart"},          {"restart_timestamp"}, {"stuck_frame_number"}, {"close_mid_frame"},
     {"half_open"},        {"no_state"},          {"split_header"},       {"split_frame"},
     {"oversize"},         {"old_version", 20},   {"body_list_change"},   {"matrix_by_rows"},
     {"other_angles"}});

const Known* find(std::string_view name) noexcept {
  const auto found =
      std::find_if(kKnown.begin(), kKnown.end(), [&](const Known& known) { return known.name == name; });
  return found == kKnown.end() ? nullptr : &*found;
}

}  // namespace

bool DeviceFaults::knows(std::string_view name) noexcept {
  return find(name) != nullptr;
}

std::vector<std::string_view> DeviceFaults::names() {
  std::vector<std::string_view> names;
  for (const Known& known : kKnown) names.push_back(known.name);
  return names;
}

bool DeviceFaults::set(std::string_view name, bool active, double value) {
  const bool was_active = is_on(name);
  if (active)
    values_.insert_or_assign(std::string{name}, value != 0.0 ? value : find(name)->default_value);
  else if (was_active)
    values_.erase(values_.find(name));
  return active != was_active;
}

void DeviceFaults::set_occluded(std::string_view body, bool active) {
  std::erase_if(occluded_, [&](const std::string& o) { return same_name(o, body); });
  if (active) occluded_.emplace(body);
}

std::optional<double> DeviceFaults::value(std::string_view name) const noexcept {
  const auto found = values_.find(name);
  return found == values_.end() ? std::nullopt : std::optional{found->second};
}

bool DeviceFaults::occludes(std::string_view body) const noexcept {
  return occludes_all() || std::any_of(occluded_.begin(), occluded_.end(),
                                       [&](const std::string& o) { return same_name(o, body); });
}

}  // namespace motionlab::qualisys
