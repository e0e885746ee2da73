#include "gateway/service/roll_call.hpp"

#include <algorithm>

namespace motionlab::service {
namespace {

struct Expected {
  std::string device;
  bool required;
};

std::vector<Expected> expected(const GatewayConfig& config) {
  std::vector<Expected> all;
  for (const auto& mru : config.mrus) all.push_back({mru.driver.device, mru.rule.required});
  all.push_back({config.qualisys.driver.device, config.qualisys.rule.required});
  all.push_back({config.comau.driver.device, config.comau.rule.required});
  all.push_back({config.winch.driver.device, config.winch.rule.required});
  if (config.plc_reply) all.push_back({config.plc_reply->driver.device, false});
  return all;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += ' ' + name;
  return text;
}

}  // namespace

std::vector<std::string> device_names(const GatewayConfig& config) {
  std::vector<std::string> names;
  for (const auto& each : expected(config)) names.push_back(each.device);
  return names;
}

bool RollCall::complete() const {
  return std::none_of(missing.begin(), missing.end(), [](const Missing& m) { return m.waited_for; });
}

std::string RollCall::waited_for() const {
  std::string names;
  for (const auto& each : missing) {
    if (each.waited_for) names += (names.empty() ? "" : ", ") + each.device;
  }
  return names;
}

std::string RollCall::sentence(const topic::Mode& mode) const {
  std::string text{"waiting for"};
  // What has run once tells its mode, which knows more of what a lost device means.
  const bool told_by_mode = complete() || mode.state != topic::ModeState::off;
  if (told_by_mode) {
    text = to_string(mode.state);
    if (!mode.fault_code.empty()) text += " " + mode.fault_code.str();
    if (!mode.reason.empty()) text += ": " + mode.reason.str();
  } else {
    const char* space = " ";
    for (const auto& each : missing) {
      if (!each.waited_for) continue;
      text += space + each.device + " (" + each.why + ")";
      space = ", ";
    }
  }
  if (!up.empty()) text += "; up:" + listed(up);
  const char* separator = "; missing: ";
  for (const auto& each : missing) {
    if (each.waited_for && !told_by_mode) continue;
    text += separator + each.device + " (" + each.why + ")";
    separator = ", ";
  }
  if (!absent.empty()) text += "; declared absent:" + listed(absent);
  return text;
}

RollCall call_roll(const GatewayConfig& config, const std::vector<topic::Health>& healths) {
  RollCall roll;
  for (const auto& [device, required] : expected(config)) {
    const auto health = std::find_if(healths.begin(), healths.end(),
                                     [&name = device](const auto& h) { return h.device.view() == name; });
    if (health != healths.end() && health->link == topic::LinkState::up) {
      roll.up.push_back(device);
    } else if (std::find(config.absent.begin(), config.absent.end(), device) != config.absent.end()) {
      roll.absent.push_back(device);
    } else {
      std::string why = "not looked at yet";
      bool connected = false;
      if (health != healths.end()) {
        connected = health->link == topic::LinkState::stale;  // late, but there
        why = to_string(health->link);
        if (!health->advice.empty()) why += ": " + health->advice.str();
      }
      roll.missing.push_back({device, why, required && !connected});
    }
  }
  return roll;
}

}  // namespace motionlab::service
