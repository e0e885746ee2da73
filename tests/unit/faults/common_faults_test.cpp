#include "simulators/faults/common_faults.hpp"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace motionlab::faults {
namespace {

TEST(CommonFaults, KnowsEveryNameItListsAndNoOther) {
  CommonFaults faults;
  std::istringstream names{std::string(CommonFaults::kNames)};
  int known = 0;
  for (std::string name; names >> name; ++known) EXPECT_TRUE(faults.set(name, true)) << name;
  EXPECT_EQ(known, 7);
  EXPECT_FALSE(faults.set("gremlins", true));
  EXPECT_FALSE(faults.set("", true));
}

TEST(CommonFaults, EndWhereTheyBegan) {
  CommonFaults faults;
  for (const char* const name : {"off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent"}) {
    faults.set(name, true, 3);
    faults.set(name, false);
  }
  EXPECT_FALSE(faults.off() || faults.stuck() || faults.garbage());
  EXPECT_EQ(faults.wrong_by(), 0.0);
  EXPECT_EQ(faults.slow_by(), 1.0);
  EXPECT_EQ(faults.delay(), 0ms);
  EXPECT_TRUE(faults.speaks(LabTime{} + 300ms));
}

TEST(CommonFaults, IntermittentSpeaksAndIsSilentInTurn) {
  CommonFaults faults;
  faults.set("intermittent", true);
  EXPECT_TRUE(faults.speaks(LabTime{} + 199ms));
  EXPECT_FALSE(faults.speaks(LabTime{} + 201ms));
  EXPECT_FALSE(faults.speaks(LabTime{} + 399ms));
  EXPECT_TRUE(faults.speaks(LabTime{} + 401ms));
  faults.set("off", true);
  EXPECT_FALSE(faults.speaks(LabTime{} + 401ms));
}

}  // namespace
}  // namespace motionlab::faults
