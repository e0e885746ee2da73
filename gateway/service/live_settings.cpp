#include "gateway/service/live_settings.hpp"

#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include <toml++/toml.h>

namespace motionlab::service {
namespace {

constexpr std::string_view kLogLevel = "[service] log_level";
constexpr std::string_view kAbsent = "[service] absent";
constexpr std::string_view kReference = "[reference] p_world_load_m";

/// Every value of an effective configuration as text, under "[table] key".
std::map<std::string, std::string> values_of(const std::string& effective) {
  std::map<std::string, std::string> values;
  for (const auto& [table_name, table] : toml::parse(effective)) {
    const auto* const keys = table.as_table();
    if (!keys) continue;
    for (const auto& [key, value] : *keys) {
      std::ostringstream text;
      value.visit([&text](const auto& node) { text << node; });
      std::string name{'['};
      name.append(table_name.str()).append("] ").append(key.str());
      values[name] = text.str();
    }
  }
  return values;
}

std::string why_refused(std::string_view key, topic::ModeState mode) {
  if (key == kLogLevel || key == kAbsent) return {};
  if (key != kReference) return "it is read at start only; settle, then restart the service";
  if (mode == topic::ModeState::engaged || mode == topic::ModeState::stopping) {
    return "the load's place does not change under an engaged crane this way; settle, then reload, or use "
           "motionlab reference";
  }
  return {};
}

}  // namespace

LiveSettings::LiveSettings(GatewayConfig config)
    : config_(std::move(config)), values_(values_of(config_.effective)) {}

std::vector<LiveSettings::Change> LiveSettings::take(const GatewayConfig& read, topic::ModeState mode) {
  const auto wanted = values_of(read.effective);
  std::set<std::string> keys;
  for (const auto& [key, value] : values_) keys.insert(key);
  for (const auto& [key, value] : wanted) keys.insert(key);
  std::vector<Change> changes;
  for (const auto& key : keys) {
    const auto now = values_.find(key);
    const auto then = wanted.find(key);
    if (now != values_.end() && then != wanted.end() && now->second == then->second) continue;
    changes.push_back({key, why_refused(key, mode)});
    if (!changes.back().refused.empty()) continue;
    if (key == kLogLevel) config_.log_level = read.log_level;
    if (key == kAbsent) config_.absent = read.absent;
    if (key == kReference) config_.p_world_load_reference_m = read.p_world_load_reference_m;
    if (then == wanted.end()) {
      values_.erase(key);
    } else {
      values_[key] = then->second;
    }
  }
  return changes;
}

}  // namespace motionlab::service
