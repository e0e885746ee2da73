/// @file  `RateMeter`: how fast a topic really is, and what is missing of it.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "gateway/monitor/any_tap.hpp"
#include "gateway/monitor/percentiles.hpp"
#include "gateway/monitor/topic_table.hpp"
#include "gateway/record/sequence_ledger.hpp"

namespace motionlab::monitor {

/// One instance of the topic by one writer.
struct InstanceRate {
  std::string instance;  ///< empty for a topic without keys
  bus::DdsId writer;
  std::uint64_t heard = 0;
  std::uint64_t missing = 0;   ///< gaps in the sample's own numbers; of a paced topic: left out on purpose
  std::uint64_t repeated = 0;  ///< the same number again
  std::uint64_t restarts = 0;
  double span_s = 0;  ///< from the first stamp to the last
  std::optional<double>
      made_hz;  ///< numbers per second; nothing before the second sample or when stamps stand
  std::optional<double> on_bus_hz;  ///< samples that were heard, per second
  std::optional<double> period_ms;  ///< median
  Percentiles jitter_us;            ///< |period - median period|
};

struct RateReport {
  std::vector<InstanceRate> instances;  ///< in the order of their names
  std::uint64_t heard = 0;
  std::uint64_t lost_on_dds = 0;  ///< gaps in the writers' own DDS numbers: written, but not heard here
  std::uint64_t refused = 0;      ///< heard, but no sample of the type
  std::uint64_t overflowed = 0;   ///< heard, but not looked at in time by this program
};

/// Rates come from the samples' own numbers and stamps, never from when they arrived: a slow reader or a busy
/// host changes nothing.
class RateMeter {
 public:
  explicit RateMeter(const TopicDescription& topic);

  void take(const HeardSample& sample);
  [[nodiscard]] RateReport report(std::uint64_t overflowed = 0) const;
  /// Samples that were believed so far.
  [[nodiscard]] std::uint64_t heard() const noexcept { return heard_; }
  /// The stamp that is used: a field of the topic, or "DDS source timestamp" when it has none of its own.
  [[nodiscard]] std::string_view stamp() const noexcept;

 private:
  struct Stream {
    record::SequenceLedger ledger;
    std::optional<std::pair<std::uint64_t, std::int64_t>> newest;  ///< number, stamp
    std::uint64_t steps = 0, numbers = 0;
    std::int64_t span_ns = 0;
    std::vector<double> periods_us;
  };

  const TopicDescription& topic_;
  std::string_view stamp_field_;
  std::map<std::pair<std::string, bus::DdsId>, Stream> streams_;
  std::map<bus::DdsId, record::SequenceLedger> writers_;
  std::uint64_t heard_ = 0, refused_ = 0;
};

}  // namespace motionlab::monitor
