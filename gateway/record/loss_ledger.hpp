/// @file  `LossLedger`: what of each topic did not make it to whoever records, and where it went.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>

#include "gateway/bus/dds_id.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/record/sequence_ledger.hpp"

namespace motionlab::record {

/// Of one topic, since the beginning.
struct TopicLosses {
  std::uint64_t on_dds = 0;    ///< written by somebody, but not heard here: gaps in the writers' DDS numbers
  std::uint64_t in_queue = 0;  ///< heard, but the writer of the file was behind
  std::uint64_t refused = 0;   ///< heard, but no sample of the type; such a number also counts as `on_dds`

  friend TopicLosses operator-(TopicLosses late, const TopicLosses& early) noexcept {
    late.on_dds -= early.on_dds;
    late.in_queue -= early.in_queue;
    late.refused -= early.refused;
    return late;
  }
  bool operator==(const TopicLosses&) const = default;
};

/// By row of `bus::kTopicList`.
using LossesByTopic = std::array<TopicLosses, bus::kTopicList.size()>;

/// Kept by the thread that takes samples from DDS.
class LossLedger {
 public:
  /// Writers that are told apart in each topic; of further ones nothing is said to be lost.
  static constexpr std::size_t kMaxWriters = 1024;

  /// A sample has arrived, with the writer's own count of its samples.
  void heard(std::size_t topic, const bus::DdsId& writer, std::uint64_t writer_sequence);
  void dropped(std::size_t topic) noexcept { ++losses_[topic].in_queue; }
  /// So many samples of the topic were refused up to now.
  void refused(std::size_t topic, std::uint64_t count) noexcept { losses_[topic].refused = count; }

  [[nodiscard]] const TopicLosses& of(std::size_t topic) const noexcept { return losses_[topic]; }
  [[nodiscard]] const LossesByTopic& all() const noexcept { return losses_; }

 private:
  std::array<std::map<bus::DdsId, SequenceLedger>, bus::kTopicList.size()> writers_;
  LossesByTopic losses_{};
};

}  // namespace motionlab::record
