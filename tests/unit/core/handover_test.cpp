// What is handed from one thread to another: Latest and BoundedQueue.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "drivers/core/bounded_queue.hpp"
#include "drivers/core/latest.hpp"

namespace motionlab {
namespace {

/// Large enough to be torn; whole when all words agree.
struct Block {
  std::array<std::uint64_t, 32> words{};
  static Block of(std::uint64_t value) {
    Block block;
    block.words.fill(value);
    return block;
  }
  [[nodiscard]] bool whole() const {
    for (const auto word : words) {
      if (word != words[0]) return false;
    }
    return true;
  }
};

TEST(Latest, SaysNothingBeforeTheFirstWrite) {
  Latest<int> latest;
  EXPECT_FALSE(latest.read());
  EXPECT_EQ(latest.version(), 0u);
  std::uint64_t seen = 0;
  EXPECT_FALSE(latest.read_newer(seen));
}

TEST(Latest, SaysTheNewestValueAndHowManyWereWritten) {
  Latest<double> latest;
  for (int i = 1; i <= 10; ++i) latest.write(i);
  const auto sample = latest.read();
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->value, 10.0);
  EXPECT_EQ(sample->version, 10u);
}

TEST(Latest, TellsEachReaderOnlyWhatIsNewToIt) {
  Latest<int> latest;
  std::uint64_t seen = 0;
  latest.write(1);
  latest.write(2);
  EXPECT_EQ(latest.read_newer(seen), 2);
  EXPECT_FALSE(latest.read_newer(seen));
  latest.write(3);
  EXPECT_EQ(latest.read_newer(seen), 3);
  EXPECT_EQ(seen, 3u);
}

TEST(Latest, NeverShowsATornOrAnOlderValueToReadersOfAnotherThread) {
  constexpr std::uint64_t kWrites = 200'000;
  Latest<Block> latest;
  std::atomic<int> failures{0};
  std::vector<std::thread> readers;
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back([&] {
      std::uint64_t last = 0;
      while (last < kWrites) {
        const auto sample = latest.read();
        if (!sample) continue;
        if (!sample->value.whole() || sample->value.words[0] != sample->version || sample->version < last)
          ++failures;
        last = sample->version;
      }
    });
  }
  for (std::uint64_t i = 1; i <= kWrites; ++i) latest.write(Block::of(i));
  for (auto& reader : readers) reader.join();
  EXPECT_EQ(failures, 0);
}

TEST(BoundedQueue, IsEmptyAtBirth) {
  BoundedQueue<int, 4> queue;
  EXPECT_FALSE(queue.pop());
  EXPECT_EQ(queue.overruns(), 0u);
}

TEST(BoundedQueue, KeepsTheOrderAndCountsWhatItRefuses) {
  BoundedQueue<int, 4> queue;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(queue.push(i));
    EXPECT_FALSE(queue.push(99));
    EXPECT_EQ(queue.overruns(), static_cast<std::uint64_t>(round + 1));
    for (int i = 0; i < 4; ++i) EXPECT_EQ(queue.pop(), i);
    EXPECT_FALSE(queue.pop());
  }
}

TEST(BoundedQueue, CarriesEveryItemWholeAndInOrderToAnotherThread) {
  constexpr std::uint64_t kItems = 200'000;
  BoundedQueue<Block, 64> queue;
  std::uint64_t failures = 0;
  std::thread consumer([&] {
    for (std::uint64_t expected = 1; expected <= kItems;) {
      const auto item = queue.pop();
      if (!item) {
        std::this_thread::yield();
        continue;
      }
      if (!item->whole() || item->words[0] != expected) ++failures;
      ++expected;
    }
  });
  std::uint64_t refused = 0;
  for (std::uint64_t i = 1; i <= kItems;) {
    if (queue.push(Block::of(i))) {
      ++i;
    } else {
      ++refused;
      std::this_thread::yield();
    }
  }
  consumer.join();
  EXPECT_EQ(failures, 0u);
  EXPECT_EQ(queue.overruns(), refused);
}

}  // namespace
}  // namespace motionlab
