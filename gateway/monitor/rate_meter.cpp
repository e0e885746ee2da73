#include "gateway/monitor/rate_meter.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace motionlab::monitor {
namespace {

/// When the sample came to be; the first of them that a topic has is used.
constexpr std::array<std::string_view, 5> kStamps{"t_measured_ns", "t_snapshot_ns", "t_computed_ns",
                                                  "t_created_ns", "t_ns"};
constexpr std::size_t kMaxStreams = 256;  // a stranger may invent any number of instances

}  // namespace

RateMeter::RateMeter(const TopicDescription& topic) : topic_(topic) {
  for (const std::string_view name : kStamps) {
    if (stamp_field_.empty() && topic.field(name)) stamp_field_ = name;
  }
}

std::string_view RateMeter::stamp() const noexcept {
  return stamp_field_.empty() ? "DDS source timestamp" : stamp_field_;
}

void RateMeter::take(const HeardSample& sample) {
  writers_[sample.writer].take(sample.writer_sequence);
  if (!sample.data) return;
  if (sample.refusal != bus::Refusal::none) {
    ++refused_;
    return;
  }
  ++heard_;
  const std::pair key{sample.instance, sample.writer};
  if (streams_.size() >= kMaxStreams && !streams_.contains(key)) return;
  Stream& stream = streams_[key];
  const auto number =
      static_cast<std::uint64_t>(integer_in(topic_, sample.values, "sequence_number").value_or(0));
  const std::int64_t t_ns =
      stamp_field_.empty() ? sample.t_written_ns : stamp_in(topic_, sample.values, stamp_field_).value_or(0);
  const std::uint64_t restarts = stream.ledger.restarts();
  stream.ledger.take(number);
  if (!stream.newest || stream.ledger.restarts() != restarts) {
    stream.newest.emplace(number, t_ns);
    return;
  }
  const auto [before, t_before_ns] = *stream.newest;
  if (number <= before) return;
  stream.newest.emplace(number, t_ns);
  if (t_ns <= t_before_ns) return;
  ++stream.steps;
  stream.numbers += number - before;
  stream.span_ns += t_ns - t_before_ns;
  stream.periods_us.push_back(1e-3 * static_cast<double>(t_ns - t_before_ns) /
                              static_cast<double>(number - before));
}

RateReport RateMeter::report(std::uint64_t overflowed) const {
  RateReport report;
  report.heard = heard_;
  report.refused = refused_;
  report.overflowed = overflowed;
  for (const auto& [writer, ledger] : writers_) report.lost_on_dds += ledger.missing();
  // What this program itself did not look at in time also leaves gaps.
  report.lost_on_dds -= std::min(report.lost_on_dds, overflowed);
  for (const auto& [key, stream] : streams_) {
    InstanceRate rate;
    rate.instance = key.first;
    rate.writer = key.second;
    rate.heard = stream.ledger.heard();
    rate.missing = stream.ledger.missing();
    rate.repeated = stream.ledger.repeated();
    rate.restarts = stream.ledger.restarts();
    rate.span_s = 1e-9 * static_cast<double>(stream.span_ns);
    if (stream.steps > 0) {
      rate.made_hz = static_cast<double>(stream.numbers) / rate.span_s;
      rate.on_bus_hz = static_cast<double>(stream.steps) / rate.span_s;
      const double median_us = percentiles_of(stream.periods_us).p50;
      rate.period_ms = 1e-3 * median_us;
      std::vector<double> jitter_us = stream.periods_us;
      for (double& period : jitter_us) period = std::abs(period - median_us);
      rate.jitter_us = percentiles_of(std::move(jitter_us));
    }
    report.instances.push_back(std::move(rate));
  }
  return report;
}

}  // namespace motionlab::monitor
