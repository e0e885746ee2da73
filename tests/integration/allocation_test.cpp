// A control step takes nothing from the heap, whatever the mode.
#include <gtest/gtest.h>

#include "tests/integration/taken_apart.hpp"
#include "tests/support/allocations.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

/// Runs on and counts what the control steps allocate.
class Counted {
 public:
  explicit Counted(TakenApart& line) : line_(line) {
    line_.before_control = [this] { before_ = test::allocations; };
    line_.after_control = [this] { total_ += test::allocations - before_; };
  }
  std::size_t during(double seconds_on) {
    total_ = 0;
    line_.run_to(line_.now_s() + seconds_on);
    return total_;
  }

 private:
  TakenApart& line_;
  std::size_t before_ = 0;
  std::size_t total_ = 0;
};

TEST(Allocation, NoControlStepTakesAnythingFromTheHeap) {
  for (const bool tracked : {true, false}) {
    TakenApart line(configure("thesis-wave", 1, tracked));
    Counted counted(line);
    EXPECT_EQ(counted.during(10), 0U) << "settled and ready";
    line.ask(ModeAction::engage);
    EXPECT_EQ(counted.during(10), 0U) << "engaged";
    ASSERT_EQ(line.mode().state, ModeState::engaged);
    line.ask(ModeAction::settle);
    EXPECT_EQ(counted.during(2), 0U) << "stopping";
    ASSERT_EQ(line.mode().state, ModeState::ready);
    line.ask(ModeAction::engage);
    (void)counted.during(2);
    ASSERT_TRUE(line.lab().set_fault("mru1", "silent", true));
    EXPECT_EQ(counted.during(3), 0U) << "fault";
    ASSERT_EQ(line.mode().state, ModeState::fault);
    ASSERT_TRUE(line.lab().set_fault("mru1", "silent", false));
    EXPECT_EQ(counted.during(3), 0U) << "the device is back, after more than the estimator bridges";
    line.ask(ModeAction::reset);
    EXPECT_EQ(counted.during(3), 0U) << "reset";
    ASSERT_TRUE(line.lab().set_fault("qualisys", "occlude", true));
    EXPECT_EQ(counted.during(5), 0U) << "blind";
  }
}

TEST(Allocation, TheCounterCounts) {
  const std::size_t before = test::allocations;
  const auto taken = std::make_unique<int>(1);
  EXPECT_EQ(test::allocations, before + 1) << *taken;
}

}  // namespace
}  // namespace motionlab::integration
