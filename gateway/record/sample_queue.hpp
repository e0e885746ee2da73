/// @file  `SampleQueue`: samples from the thread that takes them to the one that writes them down.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "drivers/core/bytes.hpp"
#include "gateway/bus/dds_tap.hpp"
#include "gateway/record/byte_ring.hpp"
#include "gateway/record/loss_ledger.hpp"

namespace motionlab::record {

/// A sample on its way into the file; its CDR lies beside it.
struct SampleToRecord {
  std::size_t topic = 0;          ///< its row in `bus::kTopicList`
  std::uint64_t sequence = 0;     ///< the writer's own count
  std::int64_t t_heard_ns = 0;    ///< system clock of this host
  std::int64_t t_written_ns = 0;  ///< system clock of the writer's host, as far as it can be one
  TopicLosses losses;             ///< of its topic, up to this sample
};

/// Bounded, and nobody waits: what finds no room is counted in the ledger and gone. Each sample carries the
/// ledger of its topic along, so that the writer knows it without asking across threads.
class SampleQueue {
 public:
  /// Room for some ten seconds of everything that a laboratory says.
  static constexpr std::size_t kCapacity = 16 * 1024 * 1024;

  explicit SampleQueue(std::size_t capacity = kCapacity) : ring_(capacity) {}

  /// The side of DDS. @returns false when it found no room
  bool push(const bus::TappedSample& sample) {
    ledger_.heard(sample.topic, sample.writer, sample.writer_sequence);
    const SampleToRecord head{sample.topic, sample.writer_sequence, sample.t_heard_ns,
                              believable(sample.t_written_ns, sample.t_heard_ns), ledger_.of(sample.topic)};
    pushed_.resize(sizeof head + sample.cdr.size());
    std::memcpy(pushed_.data(), &head, sizeof head);
    if (!sample.cdr.empty()) std::memcpy(pushed_.data() + sizeof head, sample.cdr.data(), sample.cdr.size());
    if (ring_.push(pushed_)) return true;
    ledger_.dropped(sample.topic);
    return false;
  }
  /// The side of DDS, and of everybody once that thread has ended.
  [[nodiscard]] LossLedger& ledger() noexcept { return ledger_; }

  /// The side of the file: calls use(sample, cdr) with the oldest. @returns false when there is none
  template <class F>
  bool pop(F&& use) {
    if (!ring_.pop(popped_)) return false;
    SampleToRecord head;
    std::memcpy(&head, popped_.data(), sizeof head);
    use(head, Bytes{popped_}.subspan(sizeof head));
    return true;
  }

 private:
  /// A stranger's stamp may be any number; one from before 1970 or after 2096 is none.
  static std::int64_t believable(std::int64_t written_ns, std::int64_t heard_ns) noexcept {
    constexpr std::int64_t kYear2096 = 4'000'000'000'000'000'000;
    return written_ns >= 0 && written_ns <= kYear2096 ? written_ns : heard_ns;
  }

  ByteRing ring_;
  LossLedger ledger_;
  ByteBuffer pushed_, popped_;
};

}  // namespace motionlab::record
