#include "gateway/monitor/delay_meter.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace motionlab::monitor {
namespace {

/// Which topic stands behind an age of the control step.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kSources{{
    {"mru", bus::TopicTraits<topic::Mru>::name},
    {"bodies", bus::TopicTraits<topic::Bodies>::name},
    {"arm", bus::TopicTraits<topic::ArmState>::name},
    {"winch", bus::TopicTraits<topic::WinchState>::name},
}};
/// The stamps that may be a sample's last ones, in the order of the way.
constexpr std::array<std::string_view, 5> kLastStamps{"t_computed_ns", "t_received_ns", "t_snapshot_ns",
                                                      "t_created_ns", "t_ns"};
/// An age is a double in seconds: the stamp that comes from it is exact to this.
constexpr std::int64_t kAgeResolutionNs = 500;
constexpr double kGreatest = 1e6;       // seconds or microseconds that are worth telling; NaN is not below it
constexpr std::size_t kMaxKinds = 512;  // a stranger may invent any number of devices

std::optional<double> number_in(const TopicDescription& topic, const Values& values, std::string_view name) {
  const Field* const field = topic.field(name);
  const auto* const number = field ? std::get_if<double>(&values[field->first]) : nullptr;
  return number && std::abs(*number) < kGreatest ? std::optional{*number} : std::nullopt;
}

std::string device_of(const TopicDescription& topic, const HeardSample& sample) {
  return sample.instance.empty() ? std::string{topic.name} : sample.instance;
}

}  // namespace

std::string_view name_of(Hop hop) noexcept {
  constexpr std::array<std::string_view, static_cast<std::size_t>(Hop::count_)> kNames{
      "measured -> received",  "received -> control step", "measured -> control step", "state -> estimate",
      "control step -> guard", "last stamp -> on DDS",     "on DDS -> heard here"};
  const auto index = static_cast<std::size_t>(hop);
  return index < kNames.size() ? kNames[index] : std::string_view{"?"};
}

void DelayMeter::add(Hop hop, std::string what, std::int64_t delay_ns) {
  Key key{hop, std::move(what)};
  if (delays_.size() >= kMaxKinds && !delays_.contains(key)) return;
  delays_[std::move(key)].push_back(1e-3 * static_cast<double>(delay_ns));
}

void DelayMeter::take(const TopicDescription& topic, const HeardSample& sample) {
  if (!sample.data || sample.refusal != bus::Refusal::none) return;
  const auto stamp = [&](std::string_view name) { return stamp_in(topic, sample.values, name); };
  if (const auto measured = stamp("t_measured_ns"), received = stamp("t_received_ns"); measured && received) {
    add(Hop::link, device_of(topic, sample), *received - *measured);
    received_[topic.name].insert_or_assign(*measured, *received);
  }
  if (const auto estimated = stamp("t_estimated_ns"), computed = stamp("t_computed_ns");
      estimated && computed) {
    add(Hop::estimate, std::string{topic.name}, *computed - *estimated);
  }
  if (stamp("t_snapshot_ns")) take_control(topic, sample);
  for (const std::string_view name : kLastStamps) {
    const auto last = stamp(name);
    if (!last) continue;
    const double step_us = number_in(topic, sample.values, "step_time_us").value_or(0);
    add(Hop::publish, std::string{topic.name}, sample.t_written_ns - *last - std::llround(1e3 * step_us));
    break;
  }
  add(Hop::network, std::string{topic.name}, sample.t_heard_ns - sample.t_written_ns);
}

void DelayMeter::take_control(const TopicDescription& topic, const HeardSample& sample) {
  const std::int64_t snapshot = *stamp_in(topic, sample.values, "t_snapshot_ns");
  for (const auto& [source, of] : kSources) {
    const auto age_s = number_in(topic, sample.values, std::string{"age_"}.append(source).append("_s"));
    if (!age_s || *age_s < 0) continue;  // negative: not heard yet
    const auto age_ns = static_cast<std::int64_t>(std::llround(1e9 * *age_s));
    add(Hop::actuation, std::string{source}, age_ns);
    steps_.push_back({std::string{source}, snapshot, snapshot - age_ns});
  }
  if (const auto step_us = number_in(topic, sample.values, "step_time_us"); step_us && *step_us > 0) {
    add(Hop::control, std::string{topic.name}, std::llround(1e3 * *step_us));
  }
}

std::vector<HopDelay> DelayMeter::report() const {
  std::map<Key, std::vector<double>> all = delays_;
  for (const Step& step : steps_) {
    const auto source =
        std::ranges::find(kSources, step.source, [](const auto& entry) { return entry.first; });
    const auto samples = received_.find(source->second);
    if (samples == received_.end()) continue;
    const auto used = samples->second.lower_bound(step.t_measured_ns - kAgeResolutionNs);
    if (used == samples->second.end() || used->first > step.t_measured_ns + kAgeResolutionNs) continue;
    all[{Hop::snapshot, step.source}].push_back(1e-3 *
                                                static_cast<double>(step.t_snapshot_ns - used->second));
  }
  std::vector<HopDelay> report;
  for (auto& [key, delays] : all) {
    HopDelay hop;
    hop.hop = key.first;
    hop.what = key.second;
    hop.negative =
        static_cast<std::size_t>(std::ranges::count_if(delays, [](double delay) { return delay < 0; }));
    hop.delay_us = percentiles_of(std::move(delays));
    report.push_back(std::move(hop));
  }
  return report;
}

}  // namespace motionlab::monitor
