#include "gateway/monitor/nearest_name.hpp"

#include <gtest/gtest.h>

namespace motionlab::monitor {
namespace {

const std::vector<std::string> kNames{"motionlab/estimate", "motionlab/mode", "motionlab/mode_request",
                                      "swing_rad"};

TEST(NearestName, IsTheOneWithTheFewestChanges) {
  EXPECT_EQ(did_you_mean("motionlab/estimat", kNames), "; do you mean motionlab/estimate?");
  EXPECT_EQ(did_you_mean("swing_rda", kNames), "; do you mean swing_rad?");
}

TEST(NearestName, MayContainWhatWasWritten) {
  EXPECT_EQ(did_you_mean("estimate", kNames), "; do you mean motionlab/estimate?");
}

TEST(NearestName, IsNotGuessedWhenNothingIsNear) {
  EXPECT_EQ(did_you_mean("xyz", kNames), "");
  EXPECT_EQ(did_you_mean("", kNames), "");
  EXPECT_EQ(did_you_mean("mode", {}), "");
}

}  // namespace
}  // namespace motionlab::monitor
