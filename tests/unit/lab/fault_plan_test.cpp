#include "simulators/lab/fault_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/core/error.hpp"

namespace motionlab::lab {
namespace {

TEST(FaultPlan, ReadsDeviceFaultAndTime) {
  const PlannedFault f = PlannedFault::parse("mru1:silent@12.5");
  EXPECT_EQ(f.device, "mru1");
  EXPECT_EQ(f.fault, "silent");
  EXPECT_EQ(f.value, 0);
  EXPECT_EQ(f.from_s, 12.5);
  EXPECT_FALSE(f.until_s);
}

TEST(FaultPlan, ReadsValueAndEnd) {
  const PlannedFault f = PlannedFault::parse("qualisys:loss=0.3@5..8");
  EXPECT_EQ(f.fault, "loss");
  EXPECT_EQ(f.value, 0.3);
  EXPECT_EQ(f.from_s, 5);
  EXPECT_EQ(f.until_s, 8);
}

TEST(FaultPlan, LeavesAColonInsideTheFaultsNameAlone) {
  const PlannedFault f = PlannedFault::parse("qualisys:occlude:load@20..22");
  EXPECT_EQ(f.device, "qualisys");
  EXPECT_EQ(f.fault, "occlude:load");
}

TEST(FaultPlan, RefusesWhatItDoesNotUnderstandAndShowsTheForm) {
  for (const char* text :
       {"", "mru1", "mru1:silent", ":silent@1", "mru1:@1", "mru1:silent@", "mru1:silent@soon",
        "mru1:silent@-1", "mru1:loss=much@1", "mru1:silent@5..5", "mru1:silent@5..x", "@1:x"}) {
    try {
      (void)PlannedFault::parse(text);
      ADD_FAILURE() << text;
    } catch (const StartupError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr("DEVICE:FAULT[=VALUE]@FROM[..UNTIL]")) << text;
    }
  }
}

}  // namespace
}  // namespace motionlab::lab
