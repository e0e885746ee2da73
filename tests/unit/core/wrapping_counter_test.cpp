#include "drivers/core/wrapping_counter.hpp"

#include <gtest/gtest.h>

namespace motionlab {
namespace {

using Step = WrappingCounter::Step;

TEST(WrappingCounter, CallsTheFirstReadingFirst) {
  WrappingCounter dut{1000};
  EXPECT_EQ(dut.classify(42), Step::first);
  EXPECT_EQ(dut.advance(42), 0);
  EXPECT_EQ(dut.total(), 42);
}

TEST(WrappingCounter, TellsForwardRepeatedBackwardAndRestarted) {
  WrappingCounter dut{1000};
  dut.advance(5000);
  EXPECT_EQ(dut.classify(5001), Step::forward);
  EXPECT_EQ(dut.classify(5000), Step::repeated);
  EXPECT_EQ(dut.classify(4999), Step::backward);
  EXPECT_EQ(dut.classify(4000), Step::backward);
  EXPECT_EQ(dut.classify(3999), Step::restarted);
  EXPECT_EQ(dut.total(), 5000) << "classify changes nothing";
}

TEST(WrappingCounter, DoesNotSeeTheSignChangeOrTheWrap) {
  for (const std::uint32_t edge : {0x80000000u, 0u}) {
    WrappingCounter dut{1000};
    dut.advance(edge - 5);
    const auto start = dut.total();
    EXPECT_EQ(dut.classify(edge + 5), Step::forward);
    EXPECT_EQ(dut.unwrapped(edge + 5), start + 10);
    EXPECT_EQ(dut.advance(edge + 5), 10);
    EXPECT_EQ(dut.total(), start + 10);
    EXPECT_EQ(dut.classify(edge - 1), Step::backward);
  }
}

TEST(WrappingCounter, BeginsAnewAfterReset) {
  WrappingCounter dut{1000};
  dut.advance(5000);
  dut.reset();
  EXPECT_EQ(dut.classify(7), Step::first);
  EXPECT_EQ(dut.advance(7), 0);
  EXPECT_EQ(dut.total(), 7);
}

}  // namespace
}  // namespace motionlab
