#include "gateway/record/loss_ledger.hpp"

namespace motionlab::record {

void LossLedger::heard(std::size_t topic, const bus::DdsId& writer, std::uint64_t writer_sequence) {
  auto& writers = writers_[topic];
  auto found = writers.find(writer);
  if (found == writers.end()) {
    if (writers.size() >= kMaxWriters) return;
    found = writers.try_emplace(writer).first;
  }
  SequenceLedger& ledger = found->second;
  const std::uint64_t before = ledger.missing();
  ledger.take(writer_sequence);
  losses_[topic].on_dds += ledger.missing() - before;  // a late one makes it less
}

}  // namespace motionlab::record
