#include "gateway/bus/bounded_queue.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <thread>
#include <vector>

namespace motionlab::bus {
namespace {

TEST(BoundedQueue, GivesBackInOrder) {
  BoundedQueue<int> dut{4};
  EXPECT_FALSE(dut.pop());
  for (int round = 0; round < 3; ++round) {
    EXPECT_TRUE(dut.push(1));
    EXPECT_TRUE(dut.push(2));
    EXPECT_EQ(dut.pop(), 1);
    EXPECT_EQ(dut.pop(), 2);
    EXPECT_FALSE(dut.pop());
  }
}

TEST(BoundedQueue, RefusesTheNewWhenFullAndKeepsTheOld) {
  BoundedQueue<int> dut{3};
  EXPECT_EQ(dut.capacity(), 4u);
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(dut.push(i));
  EXPECT_FALSE(dut.push(4));
  EXPECT_EQ(dut.pop(), 0);
  EXPECT_TRUE(dut.push(5));
  EXPECT_FALSE(dut.push(6));
  for (const int expected : {1, 2, 3, 5}) EXPECT_EQ(dut.pop(), expected);
}

TEST(BoundedQueue, LeavesCellsFreeForWhatMattersMore) {
  BoundedQueue<int> dut{8};
  for (int round = 0; round < 5; ++round) {  // at every place of the ring
    for (int i = 0; i < 5; ++i) EXPECT_TRUE(dut.push(i, 3));
    EXPECT_FALSE(dut.push(5, 3));
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(dut.push(100));
    EXPECT_FALSE(dut.push(100));
    for (const int expected : {0, 1, 2}) EXPECT_EQ(dut.pop(), expected);
    EXPECT_FALSE(dut.push(6, 3)) << "the three free cells are the kept ones";
    EXPECT_EQ(dut.pop(), 3);
    EXPECT_TRUE(dut.push(6, 3));
    for (const int expected : {4, 100, 100, 100, 6}) EXPECT_EQ(dut.pop(), expected);
    EXPECT_FALSE(dut.pop());
  }
}

struct Numbered {
  std::uint64_t producer;
  std::uint64_t number;
  std::array<std::uint64_t, 16> copies;  // of the number: a torn sample would show
};

TEST(BoundedQueue, LosesTearsAndReordersNothingWithSeveralProducers) {
  constexpr std::uint64_t kProducers = 3;
  constexpr std::uint64_t kEach = 20'000;
  BoundedQueue<Numbered> dut{64};
  std::vector<std::thread> producers;
  for (std::uint64_t producer = 0; producer < kProducers; ++producer) {
    producers.emplace_back([&dut, producer] {
      for (std::uint64_t n = 0; n < kEach; ++n) {
        Numbered sample{producer, n, {}};
        sample.copies.fill(n);
        while (!dut.push(sample)) std::this_thread::yield();
      }
    });
  }
  std::array<std::uint64_t, kProducers> expected{};
  for (std::uint64_t taken = 0; taken < kProducers * kEach;) {
    const auto sample = dut.pop();
    if (!sample) {
      std::this_thread::yield();
      continue;
    }
    ++taken;
    ASSERT_EQ(sample->number, expected[sample->producer]++);
    for (const std::uint64_t copy : sample->copies) ASSERT_EQ(copy, sample->number);
  }
  for (auto& producer : producers) producer.join();
  EXPECT_FALSE(dut.pop());
}

}  // namespace
}  // namespace motionlab::bus
