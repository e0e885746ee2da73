// Somebody with another DDS and types of his own operates the gateway: the programs are ours, the bus on his
// side is not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/integration/process_bench.hpp"

namespace motionlab::integration {
namespace {

using testing::HasSubstr;

TEST_F(Processes, AStrangerWithCycloneHearsEveryTopicEngagesMovesTheLoadAndSettles) {
  ::setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>"
           "</Interfaces></General></Domain></CycloneDDS>",
           1);
  Observer observer(domain_);
  const auto gateway = start_gateway();
  const auto simulator = start_simulator({"--scenario", "calm"});
  ASSERT_TRUE(eventually([&] { return observer.all_up(); }, kPatience))
      << gateway->output() << simulator->output();

  Child stranger({MOTIONLAB_CYCLONE_OPERATOR, std::to_string(domain_)}, folder_ / "stranger.log");
  EXPECT_EQ(stranger.exit_code(4 * kPatience), 0) << stranger.output();
  for (const char* const step :
       {"ready", "engaged", "heard motionlab/bodies", "heard truth/world", "moved", "settled"}) {
    EXPECT_THAT(stranger.output(), HasSubstr(step));
  }
  EXPECT_NE(observer.mode().state, topic::ModeState::engaged);
  EXPECT_FALSE(observer.mode().fault_latched) << observer.mode().reason.view();
  EXPECT_TRUE(gateway->running()) << gateway->output();
}

}  // namespace
}  // namespace motionlab::integration
