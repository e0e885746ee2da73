#include "gateway/record/sequence_ledger.hpp"

namespace motionlab::record {
namespace {

constexpr std::uint64_t kFarAhead = 1'000'000;
constexpr std::uint64_t kWindow = 64;

}  // namespace

void SequenceLedger::begin(std::uint64_t number) noexcept {
  newest_ = number;
  seen_ = ~std::uint64_t{0};
  ++heard_;
}

void SequenceLedger::take(std::uint64_t number) noexcept {
  if (heard_ == 0) return begin(number);
  if (number > newest_) {
    const std::uint64_t step = number - newest_;
    if (step > kFarAhead) {
      ++restarts_;
      return begin(number);
    }
    missing_ += step - 1;
    seen_ = step < kWindow ? (seen_ << step) | 1u : 1u;
    newest_ = number;
    ++heard_;
    return;
  }
  const std::uint64_t behind = newest_ - number;
  if (behind >= kWindow) {
    ++restarts_;
    return begin(number);
  }
  const std::uint64_t bit = std::uint64_t{1} << behind;
  if ((seen_ & bit) != 0) {
    ++repeated_;
    return;
  }
  seen_ |= bit;
  --missing_;
  ++late_;
  ++heard_;
}

}  // namespace motionlab::record
