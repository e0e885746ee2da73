#include "gateway/record/sequence_ledger.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <limits>

namespace motionlab::record {
namespace {

SequenceLedger fed(std::initializer_list<std::uint64_t> numbers) {
  SequenceLedger ledger;
  for (const std::uint64_t number : numbers) ledger.take(number);
  return ledger;
}

TEST(SequenceLedger, MissesNothingOfACompleteStream) {
  const SequenceLedger ledger = fed({7, 8, 9, 10});
  EXPECT_EQ(ledger.heard(), 4u);
  EXPECT_EQ(ledger.missing() + ledger.late() + ledger.repeated() + ledger.restarts(), 0u);
}

TEST(SequenceLedger, CountsEveryNumberThatIsLeftOut) {
  const SequenceLedger ledger = fed({1, 2, 5, 6, 106});
  EXPECT_EQ(ledger.heard(), 5u);
  EXPECT_EQ(ledger.missing(), 2u + 99u);
}

TEST(SequenceLedger, TakesALateNumberAsHeard) {
  const SequenceLedger ledger = fed({1, 4, 2, 5, 3});
  EXPECT_EQ(ledger.heard(), 5u);
  EXPECT_EQ(ledger.missing(), 0u);
  EXPECT_EQ(ledger.late(), 2u);
}

TEST(SequenceLedger, CountsARepetitionOnceAndNeverAsHeard) {
  const SequenceLedger ledger = fed({1, 1, 3, 2, 2, 3});
  EXPECT_EQ(ledger.heard(), 3u);
  EXPECT_EQ(ledger.repeated(), 3u);
  EXPECT_EQ(ledger.missing(), 0u);
}

TEST(SequenceLedger, MissesNothingFromBeforeTheFirstNumber) {
  const SequenceLedger ledger = fed({100, 99});
  EXPECT_EQ(ledger.missing(), 0u);
  EXPECT_EQ(ledger.repeated(), 1u);
}

TEST(SequenceLedger, BeginsAgainWhenTheStreamDoes) {
  const SequenceLedger back = fed({1000, 1001, 1, 2, 4});
  EXPECT_EQ(back.restarts(), 1u);
  EXPECT_EQ(back.missing(), 1u);
  EXPECT_EQ(back.heard(), 5u);
  const SequenceLedger ahead = fed({1, 2, std::numeric_limits<std::uint64_t>::max(), 0});
  EXPECT_EQ(ahead.restarts(), 2u);
  EXPECT_EQ(ahead.missing(), 0u);
}

}  // namespace
}  // namespace motionlab::record
