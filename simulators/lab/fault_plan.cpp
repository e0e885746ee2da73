#include "simulators/lab/fault_plan.hpp"

#include <charconv>
#include <cmath>

#include "drivers/core/error.hpp"

namespace motionlab::lab {

namespace {

std::optional<double> number(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

}  // namespace

PlannedFault PlannedFault::parse(std::string_view text) {
  const auto refuse = [text](std::string_view why) {
    return StartupError(
        "--fault \"" + std::string(text) + "\": " + std::string(why) +
        "; write DEVICE:FAULT[=VALUE]@FROM[..UNTIL] with times in seconds, e.g. mru1:silent@12 or "
        "qualisys:loss=0.3@5..8");
  };
  const auto colon = text.find(':');
  const auto at = text.rfind('@');
  if (colon == std::string_view::npos || colon == 0) throw refuse("the device is missing");
  if (at == std::string_view::npos || at < colon) throw refuse("the time is missing");

  PlannedFault planned;
  planned.device = text.substr(0, colon);
  std::string_view fault = text.substr(colon + 1, at - colon - 1);
  if (const auto equals = fault.find('='); equals != std::string_view::npos) {
    const auto value = number(fault.substr(equals + 1));
    if (!value) throw refuse("the value is not a number");
    planned.value = *value;
    fault = fault.substr(0, equals);
  }
  if (fault.empty()) throw refuse("the fault is missing");
  planned.fault = fault;

  std::string_view when = text.substr(at + 1);
  if (const auto dots = when.find(".."); dots != std::string_view::npos) {
    planned.until_s = number(when.substr(dots + 2));
    if (!planned.until_s) throw refuse("the end is not a number of seconds");
    when = when.substr(0, dots);
  }
  const auto from = number(when);
  if (!from || *from < 0) throw refuse("the time is not a number of seconds from 0 on");
  planned.from_s = *from;
  if (planned.until_s && *planned.until_s <= planned.from_s) throw refuse("it ends before it begins");
  return planned;
}

}  // namespace motionlab::lab
