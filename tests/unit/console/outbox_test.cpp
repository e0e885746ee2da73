#include "gateway/console/outbox.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <vector>

namespace motionlab::console {
namespace {

Parcel parcel(std::uint32_t slot, std::int64_t t_ns, std::size_t bytes = 36, bool every_counts = false) {
  return {slot / 10, slot, t_ns, every_counts, std::make_shared<const std::vector<std::byte>>(bytes)};
}

TEST(Outbox, GivesInTheOrderOfArrival) {
  Outbox outbox{1000, false};
  for (int i = 0; i < 5; ++i) outbox.push(parcel(1, i));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(outbox.pop()->t_ns, i);
  EXPECT_FALSE(outbox.pop());
  EXPECT_EQ(outbox.missed(), 0U);
  EXPECT_EQ(outbox.bytes(), 0U);
}

TEST(Outbox, KeepsTheNewestOfEachSlotWhenItIsFull) {
  Outbox outbox{1000, false};  // ten parcels of 36 bytes and what they cost besides
  for (int i = 0; i < 10'000; ++i) outbox.push(parcel(i % 3 == 0 ? 20 : 10, i));
  EXPECT_LE(outbox.bytes(), 1000U + 2 * 100U);
  EXPECT_EQ(outbox.missed() + outbox.size(), 10'000U);
  std::int64_t newest_10 = -1, newest_20 = -1;
  while (const auto next = outbox.pop()) (next->slot == 10 ? newest_10 : newest_20) = next->t_ns;
  EXPECT_EQ(newest_20, 9999);
  EXPECT_EQ(newest_10, 9998);
}

TEST(Outbox, NeverForgetsASlotThatIsSeldomForOneThatIsOften) {
  Outbox outbox{1000, false};
  outbox.push(parcel(30, -1));
  for (int i = 0; i < 10'000; ++i) outbox.push(parcel(10, i));
  EXPECT_EQ(outbox.pop()->slot, 30U);
}

TEST(Outbox, GivesEachSlotItsTurnToAClientThatReadsSlowly) {
  Outbox outbox{100'000, true};
  std::set<std::uint32_t> seen;
  for (int i = 0; i < 60; ++i) {
    for (std::uint32_t slot = 0; slot < 20; ++slot) outbox.push(parcel(slot, i));
    const auto first = outbox.pop();
    EXPECT_EQ(first->t_ns, i) << "the newest of it";
    seen.insert(first->slot);
  }
  EXPECT_EQ(seen.size(), 20U);
}

TEST(Outbox, IsBoundedAlsoForWhatEveryOneOfCounts) {
  Outbox outbox{1000, false};
  for (int i = 0; i < 10'000; ++i) outbox.push(parcel(10, i, 36, true));
  EXPECT_LE(outbox.bytes(), 1100U);
  EXPECT_EQ(outbox.newly_missed().at(1), outbox.missed());
  EXPECT_TRUE(outbox.newly_missed().empty());
}

TEST(Outbox, HoldsOneOfEachSlotForWhoWantsTheNewestOnlyAndMissesNothing) {
  Outbox outbox{100'000, true};
  for (int i = 0; i < 100; ++i) outbox.push(parcel(i % 2 == 0 ? 10 : 20, i));
  for (int i = 0; i < 7; ++i) outbox.push(parcel(30, i, 36, true));
  EXPECT_EQ(outbox.size(), 2U + 7U);
  EXPECT_EQ(outbox.missed(), 0U);
  EXPECT_EQ(outbox.pop()->t_ns, 98);
  EXPECT_EQ(outbox.pop()->t_ns, 99);
}

TEST(Outbox, ForgetsAChannelThatIsNotWantedAnyMore) {
  Outbox outbox{1000, false};
  outbox.push(parcel(10, 1));
  outbox.push(parcel(20, 2));
  outbox.push(parcel(11, 3));
  outbox.forget(1);
  EXPECT_EQ(outbox.size(), 1U);
  EXPECT_EQ(outbox.bytes(), 100U);
  EXPECT_EQ(outbox.pop()->slot, 20U);
}

}  // namespace
}  // namespace motionlab::console
