// Gateways that die while the crane is engaged in a sea, with both robot computers: the arm comes to rest on
// the wire and on the plant, and nothing moves again by itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ptrace.h>

#include "tests/integration/deadman_bench.hpp"

namespace motionlab::integration {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;
using topic::ModeAction;
using topic::ModeState;

/// One thread of another process, stopped from outside until the process is gone.
class FrozenThread {
 public:
  FrozenThread(pid_t process, const std::string& name) {
    for (const auto& entry :
         std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
      std::ifstream file(entry.path() / "comm");
      std::string comm;
      if (std::getline(file, comm) && comm == name) thread_ = std::stoi(entry.path().filename().string());
    }
    frozen_ = thread_ > 0 && ::ptrace(PTRACE_SEIZE, thread_, nullptr, nullptr) == 0 &&
              ::ptrace(PTRACE_INTERRUPT, thread_, nullptr, nullptr) == 0;
  }
  [[nodiscard]] bool frozen() const { return frozen_; }
  /// The thread was ended; whoever froze it has to take note before its process can go.
  [[nodiscard]] bool ended() const {
    return eventually(
        [this] {
          int status = 0;
          return ::waitpid(thread_, &status, WNOHANG | __WALL) == thread_ &&
                 (WIFSIGNALED(status) || WIFEXITED(status));
        },
        kPatience);
  }

 private:
  pid_t thread_ = 0;
  bool frozen_ = false;
};

class Deadman : public testing::TestWithParam<const char*>, protected DeadmanBench {
 protected:
  void SetUp() override {
    std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(name.begin(), name.end(), '/', '-');
    set_up(name, faithful());
    witness_ = std::make_unique<Witness>(domain_);
  }
  void TearDown() override { tear_down(); }

  [[nodiscard]] static bool faithful() { return std::string(GetParam()) == "faithful"; }

  /// The deadman speaks last, when its port is free again.
  [[nodiscard]] bool is_said(const std::string& words) const {
    return eventually([&] { return gateway_->output().find(words) != std::string::npos; }, kPatience);
  }

  /// What the wire says from `t_from_ns` on, and that the plant agrees.
  void expect_braked(std::int64_t t_from_ns) {
    ASSERT_TRUE(port_is_free());
    EXPECT_TRUE(witness_->arm_rests());
    const auto seen = tap_->seen();
    const auto first = first_braking(seen, t_from_ns);
    ASSERT_TRUE(first) << "no ramp among " << seen.size() << " datagrams";
    EXPECT_TRUE(brakes_to_the_end(seen, *first));
  }

  /// A new gateway holds the arm and waits to be asked.
  void expect_nothing_resumes() {
    tap_->clear();
    witness_->look_anew();
    gateway_ = start_gateway();
    observer_ = std::make_unique<Observer>(domain_);
    ASSERT_TRUE(eventually([this] { return observer_->all_up(); }, kPatience)) << gateway_->output();
    EXPECT_TRUE(observer_->wait_for(ModeState::ready)) << observer_->mode().reason.view();
    EXPECT_TRUE(witness_->arm_rests());
    EXPECT_LT(witness_->fastest_radps(), 0.01);
    for (const Seen& said : tap_->seen()) ASSERT_FALSE(said.follows());
  }

  [[nodiscard]] std::vector<std::string> settle_command() const {
    auto command = gateway_command();
    command.push_back("--settle");
    return command;
  }

  std::unique_ptr<Witness> witness_;
};

TEST_P(Deadman, BrakesTheArmWhenTheGatewayIsKilledAndNothingResumes) {
  ASSERT_EQ(engage_in_a_sea(), "");
  const std::int64_t t_kill_ns = real_time_ns();
  gateway_->send(SIGKILL);
  EXPECT_EQ(gateway_->exit_code(kPatience), -SIGKILL);
  expect_braked(t_kill_ns);
  EXPECT_TRUE(is_said("the gateway is gone; the arm is at rest; the winch is at rest")) << gateway_->output();
  expect_nothing_resumes();
}

TEST_P(Deadman, EndsAGatewayThatIsStoppedSoThatItNeverGoesOn) {
  ASSERT_EQ(engage_in_a_sea(), "");
  const std::int64_t t_stop_ns = real_time_ns();
  gateway_->send(SIGSTOP);
  siginfo_t ended{};  // without taking note, so that its number stays its own
  ASSERT_TRUE(eventually(
      [&] {
        return ::waitid(P_PID, static_cast<id_t>(gateway_->pid()), &ended, WEXITED | WNOHANG | WNOWAIT) ==
                   0 &&
               ended.si_pid == gateway_->pid();
      },
      kPatience));
  gateway_->send(SIGCONT);
  EXPECT_EQ(gateway_->exit_code(kPatience), -SIGKILL);
  expect_braked(t_stop_ns);
  EXPECT_TRUE(is_said("io thread was silent")) << gateway_->output();
}

TEST_P(Deadman, EndsAGatewayWhoseControlThreadStandsStill) {
  ASSERT_EQ(engage_in_a_sea(), "");
  const FrozenThread control(gateway_->pid(), "control");
  if (!control.frozen()) GTEST_SKIP() << "this machine does not let a test stop a thread of another process";
  // The driver sees no new command and brakes at once; the deadman ends what will not come back.
  ASSERT_TRUE(control.ended());
  EXPECT_EQ(gateway_->exit_code(kPatience), -SIGKILL);
  ASSERT_TRUE(port_is_free());
  EXPECT_TRUE(witness_->arm_rests());
  EXPECT_FALSE(tap_->seen().back().follows());
  EXPECT_TRUE(is_said("control thread was silent")) << gateway_->output();
}

TEST_P(Deadman, BrakesWhenAServiceManagerAbortsEveryProcessOfTheService) {
  ASSERT_EQ(engage_in_a_sea(), "");
  const auto deadman = child_named(gateway_->pid(), "deadman");
  ASSERT_TRUE(deadman);
  const std::int64_t t_abort_ns = real_time_ns();
  ::kill(*deadman, SIGABRT);
  gateway_->send(SIGABRT);
  EXPECT_EQ(gateway_->exit_code(kPatience), -SIGABRT);
  expect_braked(t_abort_ns);
  EXPECT_TRUE(is_said("the gateway is gone; the arm is at rest; the winch is at rest")) << gateway_->output();
}

TEST_P(Deadman, IsLetGoByAnOrderlyEnd) {
  ASSERT_EQ(engage_in_a_sea(), "");
  const auto deadman = child_named(gateway_->pid(), "deadman");
  ASSERT_TRUE(deadman);
  // What ends a service or a terminal's programs does not end the deadman before its gateway.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) ::kill(*deadman, signal);
  EXPECT_FALSE(eventually([&] { return child_named(gateway_->pid(), "deadman") != deadman; },
                          std::chrono::seconds{1}));
  gateway_->send(SIGTERM);
  EXPECT_EQ(gateway_->exit_code(kPatience), 0) << gateway_->output();
  EXPECT_TRUE(eventually([&] { return ::kill(*deadman, 0) != 0; }, kPatience));
  EXPECT_THAT(gateway_->output(), Not(HasSubstr("deadman:")));
  EXPECT_TRUE(witness_->arm_rests());
}

TEST_P(Deadman, IsMissedByItsGatewayWhichLetsGoAndStaysLatched) {
  ASSERT_EQ(engage_in_a_sea(), "");
  const auto deadman = child_named(gateway_->pid(), "deadman");
  ASSERT_TRUE(deadman);
  ::kill(*deadman, SIGKILL);
  ASSERT_TRUE(observer_->wait_for(ModeState::fault));
  EXPECT_EQ(observer_->mode().fault_code.str(), "deadman_lost");
  EXPECT_TRUE(witness_->arm_rests());
  EXPECT_FALSE(eventually(
      [&] {
        observer_->ask(ModeAction::reset);
        observer_->ask(ModeAction::engage);
        const auto state = observer_->mode().state;
        return state == ModeState::engaged || state == ModeState::ready;
      },
      std::chrono::seconds{2}));
  gateway_->send(SIGTERM);
  EXPECT_EQ(gateway_->exit_code(kPatience), 0) << gateway_->output();
  EXPECT_TRUE(is_said("deadman process is gone")) << gateway_->output();
}

TEST_P(Deadman, IsFollowedByTheSecondLineWhenItDiesToo) {
  ASSERT_EQ(engage_in_a_sea(), "");
  const auto deadman = child_named(gateway_->pid(), "deadman");
  ASSERT_TRUE(deadman);
  ::kill(*deadman, SIGKILL);
  gateway_->send(SIGKILL);
  EXPECT_EQ(gateway_->exit_code(kPatience), -SIGKILL);
  Child settle(settle_command(), folder_ / "settle.log");
  EXPECT_EQ(settle.exit_code(kPatience), 0) << settle.output();
  EXPECT_THAT(settle.output(), HasSubstr("the arm is at rest; the winch is at rest"));
  EXPECT_TRUE(witness_->arm_rests());
  EXPECT_FALSE(tap_->seen().back().follows());

  // Nobody answers any more: that is not at rest.
  simulator_.reset();
  Child in_vain(settle_command(), folder_ / "in_vain.log");
  EXPECT_EQ(in_vain.exit_code(kPatience), 1);
  EXPECT_THAT(in_vain.output(), HasSubstr("does not answer"));
}

TEST_P(Deadman, SecondLineDoesNothingBesideAGatewayThatLives) {
  ASSERT_EQ(engage_in_a_sea(), "");
  Child settle(settle_command(), folder_ / "settle.log");
  EXPECT_EQ(settle.exit_code(kPatience), 2);
  EXPECT_THAT(settle.output(), HasSubstr("motionlab settle"));
  EXPECT_TRUE(gateway_->running());
  // Engaged as before, unless this machine stood still for longer than a device may be silent.
  const auto mode = observer_->mode();
  if (mode.state != ModeState::engaged) {
    EXPECT_THAT(mode.fault_code.str(), EndsWith("_stale"));
  }
}

INSTANTIATE_TEST_SUITE_P(Robot, Deadman, testing::Values("hardened", "faithful"),
                         [](const auto& robot) { return std::string(robot.param); });

}  // namespace
}  // namespace motionlab::integration
