#include "gateway/monitor/fault_log.hpp"

#include <algorithm>

namespace motionlab::monitor {
namespace {

bool moves_nothing(const topic::Control& control) {
  const bool arm_rests = !control.following ||
                         std::ranges::all_of(control.qd_command_radps, [](double qd) { return qd == 0.0; });
  return arm_rests && control.wire_speed_command_mps == 0.0;
}

}  // namespace

void FaultLog::caused(LabTime t, std::string_view name) {
  if (entries_.size() == kMost) return;
  entries_.push_back({.t = t,
                      .name = std::string{name},
                      .caused = true,
                      .code = {},
                      .latched = std::nullopt,
                      .at_rest = std::nullopt});
}

void FaultLog::take(const topic::Mode& mode) {
  const LabTime t = from_ns(mode.t_changed_ns);
  if (!mode.fault_latched || newest_latch_ == t) return;
  newest_latch_ = t;
  const std::string code = mode.fault_code.str();
  const auto cause = std::find_if(entries_.rbegin(), entries_.rend(), [t](const Entry& entry) {
    return entry.caused && !entry.latched && entry.t <= t;
  });
  if (cause != entries_.rend()) {
    cause->latched = t;
    cause->code = code;
  } else if (entries_.size() < kMost) {
    entries_.push_back(
        {.t = t, .name = code, .caused = false, .code = code, .latched = t, .at_rest = std::nullopt});
  }
}

void FaultLog::take(const topic::Control& control) {
  const LabTime t = from_ns(control.t_snapshot_ns);
  if (entries_.empty() || !moves_nothing(control)) return;
  for (Entry& entry : entries_) {
    if (entry.latched && !entry.at_rest && t >= *entry.latched) entry.at_rest = t;
  }
}

}  // namespace motionlab::monitor
