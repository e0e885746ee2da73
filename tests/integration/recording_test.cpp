// The gateway as a process records its control thread; the study runs that again, to the bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/integration/process_bench.hpp"

namespace motionlab::integration {
namespace {

using testing::HasSubstr;
using topic::ModeAction;
using topic::ModeState;

class Recordings : public Processes {
 protected:
  void SetUp() override {
    Processes::SetUp();
    write("gateway.toml",
          gateway_overlay() + "[record]\ninputs = \"" + file("run.mcap") + "\"\noutputs_every = 7\n");
  }
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  /// Replays and returns the exit code; the words go to `said_`.
  int replay(const std::string& name) {
    Child study({MOTIONLAB_STUDY, "--replay", file(name), "--report", file("report.json")},
                folder_ / "study.log");
    const auto code = study.exit_code(std::chrono::seconds{200});
    said_ = study.output();
    return code.value_or(-1000);
  }
  std::string said_;
};

TEST_F(Recordings, OfTheRealProcessComeOutTheSameToTheBit) {
  {
    Observer observer(domain_);
    const auto gateway = start_gateway();
    const auto simulator = start_simulator({"--scenario", "sea"});
    ASSERT_TRUE(observer.wait_for(ModeState::ready)) << gateway->output() << simulator->output();
    ASSERT_TRUE(observer.ask_until(ModeAction::engage, ModeState::engaged)) << observer.mode().reason.view();
    ASSERT_TRUE(eventually([&] { return observer.control().sequence_number > 5000; }, kPatience));
    gateway->send(SIGTERM);
    ASSERT_EQ(gateway->exit_code(kPatience), 0) << gateway->output();
    EXPECT_THAT(gateway->output(), HasSubstr("recording to " + file("run.mcap")));
    // A machine that stands still for seconds leaves gaps, which are said and refused.
    if (gateway->output().find("has gaps") != std::string::npos) GTEST_SKIP() << gateway->output();
  }
  EXPECT_EQ(replay("run.mcap"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("equal to the bit"));
  std::ifstream report(file("report.json"));
  const std::string text(std::istreambuf_iterator<char>(report), {});
  EXPECT_THAT(text, HasSubstr("\"equal\": true"));
  EXPECT_THAT(text, HasSubstr("\"cut_off\": false"));
}

TEST_F(Recordings, OfAGatewayThatWasKilledAreGoodUpToItsLastMoments) {
  std::ofstream(file("run.mcap")) << "an older recording";
  {
    Observer observer(domain_);
    const auto gateway = start_gateway();
    ASSERT_TRUE(eventually([&] { return observer.control().sequence_number > 3000; }, kPatience))
        << gateway->output();
    gateway->send(SIGKILL);
    EXPECT_EQ(gateway->exit_code(kPatience), -SIGKILL);
  }
  std::ifstream older(file("run.mcap"));
  const std::string kept(std::istreambuf_iterator<char>(older), {});
  EXPECT_EQ(kept, "an older recording");
  EXPECT_EQ(replay("run-2.mcap"), 0) << said_;
  EXPECT_THAT(said_, HasSubstr("cut off"));
}

}  // namespace
}  // namespace motionlab::integration
