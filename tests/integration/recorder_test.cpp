// `motionlab record` as a process: beside the real gateway, under a service manager, and killed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <nlohmann/json.hpp>

#include "tests/integration/notify_socket.hpp"
#include "tests/integration/process_bench.hpp"

namespace motionlab::integration {
namespace {

using testing::HasSubstr;

class Recorders : public Processes {
 protected:
  [[nodiscard]] std::string file(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] std::unique_ptr<Child> start_recorder(const std::vector<std::string>& more) const {
    std::vector<std::string> command{MOTIONLAB_HAND, "--domain",  std::to_string(domain_),
                                     "--interface",  "127.0.0.1", "record"};
    command.insert(command.end(), more.begin(), more.end());
    return std::make_unique<Child>(command, folder_ / "record.log");
  }
  /// What `verify` says; its exit code is in `verified_`.
  nlohmann::json verify(const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> command{MOTIONLAB_HAND, "verify", file(name), "--json"};
    command.insert(command.end(), more.begin(), more.end());
    Child hand(command, folder_ / "verify.log");
    verified_ = hand.exit_code(kPatience).value_or(-1000);
    return nlohmann::json::parse(hand.output(), nullptr, false);
  }
  [[nodiscard]] std::uint64_t size_of(const std::string& name) const {
    std::error_code none;
    const auto size = std::filesystem::file_size(folder_ / name, none);
    return none ? 0 : size;
  }
  int verified_ = 0;
};

std::uint64_t messages_of(const nlohmann::json& seen, const std::string& topic) {
  for (const auto& entry : seen.at("topics")) {
    if (entry.at("topic") == topic) return entry.at("messages");
  }
  return 0;
}

TEST_F(Recorders, WriteDownALaboratoryUnderAServiceManager) {
  NotifySocket systemd{std::chrono::seconds{10}};
  const auto recorder = start_recorder({"-o", file("run.mcap")});
  ASSERT_TRUE(eventually([&] { return systemd.heard("READY=1"); }, kPatience)) << recorder->output();
  Observer observer(domain_);
  const auto simulator = start_simulator({"--scenario", "sea"});
  const auto gateway = start_gateway();
  ASSERT_TRUE(eventually([&] { return observer.all_up(); }, kPatience)) << gateway->output();
  const double before = processor_s(recorder->pid());
  const auto start = std::chrono::steady_clock::now();
  const std::uint64_t steps = observer.control().sequence_number;
  ASSERT_TRUE(eventually([&] { return observer.control().sequence_number > steps + 5000; }, kPatience));
  const double share = (processor_s(recorder->pid()) - before) /
                       std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  std::cout << "recording everything takes " << 100 * share << " % of a core\n";
  systemd.forget();
  EXPECT_TRUE(eventually([&] { return systemd.heard("WATCHDOG=1\nSTATUS="); }, kPatience)) << systemd.all();
  recorder->send(SIGTERM);
  EXPECT_EQ(recorder->exit_code(kPatience), 0) << recorder->output();
  EXPECT_TRUE(systemd.heard("STOPPING=1"));
  const auto seen = verify("run.mcap");
  EXPECT_EQ(verified_, 0);
  for (const char* const topic : {"motionlab/mru", "motionlab/bodies", "motionlab/arm_state", "truth/world",
                                  "motionlab/winch_state", "motionlab/estimate", "motionlab/control"}) {
    EXPECT_GT(messages_of(seen, topic), 100U) << topic;
  }
  for (const char* const topic : {"motionlab/mode", "motionlab/health", "motionlab/timing"})
    EXPECT_GT(messages_of(seen, topic), 0U) << topic;
  for (const auto& topic : seen.at("topics")) EXPECT_EQ(topic.at("ledger").at("lost_in_queue"), "0") << topic;
}

TEST_F(Recorders, HaveAllButTheLastMomentWhenTheyAreKilled) {
  Observer observer(domain_);
  const auto recorder = start_recorder({"-o", file("run.mcap")});
  const auto gateway = start_gateway();
  ASSERT_TRUE(eventually([&] { return observer.control().sequence_number > 0; }, kPatience));
  const std::uint64_t small = size_of("run.mcap");
  ASSERT_TRUE(eventually([&] { return size_of("run.mcap") > small + 20'000; }, kPatience))
      << recorder->output();
  recorder->send(SIGKILL);
  EXPECT_EQ(recorder->exit_code(kPatience), -SIGKILL);
  const auto seen = verify("run.mcap");
  EXPECT_EQ(verified_, 1);
  EXPECT_EQ(seen.at("complete"), false);
  EXPECT_EQ(seen.at("damage_count"), 0);
  EXPECT_GT(messages_of(seen, "motionlab/control"), 0U);
  (void)verify("run.mcap", {"--repair", file("whole.mcap")});
  EXPECT_EQ(verified_, 0);
  const auto whole = verify("whole.mcap");
  EXPECT_EQ(verified_, 0);
  EXPECT_EQ(whole.at("messages"), seen.at("messages"));
}

TEST_F(Recorders, EndWithAWordWhenTheDiskIsFull) {
  // A limit on the size of a file is a full disk for this process alone; it is inherited by the recorder.
  signal(SIGXFSZ, SIG_IGN);
  const rlimit limit{100'000, RLIM_INFINITY}, none{RLIM_INFINITY, RLIM_INFINITY};
  const auto gateway = start_gateway();
  setrlimit(RLIMIT_FSIZE, &limit);
  const auto recorder = start_recorder({"-o", file("run.mcap")});
  setrlimit(RLIMIT_FSIZE, &none);
  EXPECT_EQ(recorder->exit_code(kPatience), 1) << recorder->output();
  EXPECT_THAT(recorder->output(), HasSubstr("disk takes no more"));
  const auto seen = verify("run.mcap");
  EXPECT_EQ(seen.at("complete"), false);
  EXPECT_GT(messages_of(seen, "motionlab/control"), 0U);
  EXPECT_GT(size_of("run.mcap"), 50'000U) << "all but what did not fit is there";
}

}  // namespace
}  // namespace motionlab::integration
