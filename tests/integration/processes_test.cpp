// The programs themselves, as separate processes on real sockets and a DDS domain of their own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

#include "tests/integration/process_bench.hpp"

namespace motionlab::integration {

const char* const kGatewayProgram = MOTIONLAB_GATEWAY;
const char* const kSimulatorProgram = MOTIONLAB_SIM;

namespace {

using testing::AnyOf;
using testing::HasSubstr;
using topic::LinkState;
using topic::ModeAction;
using topic::ModeState;

TEST_F(Processes, SurviveTheSimulatorsDeathAndGarbageAndEndWhenToldTo) {
  Observer observer(domain_);
  auto gateway = start_gateway();
  auto simulator = start_simulator();
  ASSERT_TRUE(eventually([&] { return observer.all_up(); }, kPatience))
      << gateway->output() << simulator->output();
  ASSERT_TRUE(observer.wait_for(ModeState::ready)) << observer.mode().reason.view();

  // The user's hand agrees.
  Child status(
      {MOTIONLAB_HAND, "status", "--json", "--domain", std::to_string(domain_), "--interface", "127.0.0.1"},
      folder_ / "status.log");
  EXPECT_EQ(status.exit_code(kPatience), 0) << status.output();
  EXPECT_THAT(status.output(), HasSubstr("\"healthy\": true"));

  ASSERT_TRUE(observer.ask_until(ModeAction::engage, ModeState::engaged)) << observer.mode().reason.view();
  ASSERT_TRUE(eventually([&] { return observer.control().following; }, kPatience));

  // Garbage on every UDP port.
  const RawSocket stranger(SOCK_DGRAM);
  const auto rejected = [&](const char* device) {
    std::uint64_t sum = 0;
    for (const auto n : observer.health(device).rejected) sum += n;
    return sum;
  };
  const std::array<std::pair<const char*, const char*>, 4> udp_ports{
      {{"mru1", "mru1"}, {"mru2", "mru2"}, {"qualisys", "frames"}, {"arm", "arm"}}};
  for (const auto& [device, port] : udp_ports) {
    const auto before = rejected(device);
    for (std::size_t size = 0; size < 200; ++size) {
      stranger.send_to(port_.at(port), std::vector<std::uint8_t>(size, static_cast<std::uint8_t>(size)));
    }
    EXPECT_TRUE(eventually([&] { return rejected(device) >= before + 150; }, kPatience)) << device;
  }
  EXPECT_TRUE(gateway->running());
  EXPECT_EQ(observer.mode().state, ModeState::engaged) << observer.mode().reason.view();

  // kill -9 while engaged.
  simulator->send(SIGKILL);
  ASSERT_TRUE(observer.wait_for(ModeState::fault));
  EXPECT_THAT(observer.mode().fault_code.str(), AnyOf("mru1_stale", "arm_stale", "winch_stale"));
  EXPECT_TRUE(eventually([&] { return !observer.control().following; }, kPatience));
  EXPECT_TRUE(eventually([&] { return observer.health("mru1").link != LinkState::up; }, kPatience));
  EXPECT_TRUE(gateway->running()) << gateway->output();

  // It is back: links up, nothing engaged.
  simulator = start_simulator();
  EXPECT_TRUE(eventually([&] { return observer.all_up(); }, kPatience)) << gateway->output();
  EXPECT_FALSE(eventually([&] { return observer.mode().state != ModeState::fault; }, 2s));
  EXPECT_TRUE(observer.ask_until(ModeAction::reset, ModeState::ready)) << observer.mode().reason.view();
  EXPECT_FALSE(eventually([&] { return observer.control().following; }, 1s));
  ASSERT_TRUE(observer.ask_until(ModeAction::engage, ModeState::engaged)) << observer.mode().reason.view();

  // SIGTERM settles.
  gateway->send(SIGTERM);
  EXPECT_EQ(gateway->exit_code(kPatience), 0);
  EXPECT_THAT(gateway->output(), HasSubstr("told to rest"));
}

/// Somebody in the partition of the truth, who breaks devices while they run.
class FaultHand {
 public:
  explicit FaultHand(int domain)
      : dds_({.domain = domain,
              .interface_whitelist = {"127.0.0.1"},
              .participant = "fault hand",
              .join_truth = true},
             local_),
        controls_(local_.advertise<topic::SimControl>()) {
    dds_.out<topic::SimControl>();
    dds_.start();
  }
  ~FaultHand() { dds_.stop(); }
  FaultHand(const FaultHand&) = delete;
  FaultHand& operator=(const FaultHand&) = delete;

  /// Says it again and again until it has come true: who has just begun may not be heard yet.
  template <class Condition>
  bool set_until(const char* device, const char* fault, const Condition& condition) {
    return eventually(
        [&] {
          if (condition()) return true;
          topic::SimControl control;
          control.device = device;
          control.sequence_number = ++said_;
          control.fault = fault;
          control.active = true;
          controls_.publish(control);
          return false;
        },
        kPatience);
  }

 private:
  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Publisher<topic::SimControl> controls_;
  std::uint64_t said_ = 0;
};

TEST_F(Processes, FaultsComeAndGoAtRunTime) {
  Observer observer(domain_);
  const auto gateway = start_gateway();
  const auto simulator = start_simulator({"--scenario", "calm"});
  ASSERT_TRUE(eventually([&] { return observer.all_up(); }, kPatience))
      << gateway->output() << simulator->output();
  FaultHand hand(domain_);
  const auto link = [&](const char* device) { return observer.health(device).link; };
  EXPECT_TRUE(hand.set_until("mru1", "silent", [&] { return link("mru1") != LinkState::up; }));
  EXPECT_TRUE(hand.set_until("mru1", "cut", [&] {
    return simulator->output().find("mru1: fault cut begins") != std::string::npos;
  }));
  EXPECT_TRUE(hand.set_until("mru1", "ok", [&] { return link("mru1") == LinkState::up; }));
  EXPECT_TRUE(hand.set_until("winch", "gremlins", [&] {
    return simulator->output().find("unknown fault; the winch knows") != std::string::npos;
  }));
  EXPECT_TRUE(simulator->running());
  EXPECT_TRUE(observer.all_up());
}

TEST_F(Processes, APortInUseIsSaidBeforeAnythingIsSent) {
  const RawSocket robot(SOCK_DGRAM, port_.at("robot"));
  for (const char* const name : {"mru1", "mru2", "frames", "arm"}) {
    const RawSocket occupied(SOCK_DGRAM, port_.at(name));
    const auto gateway = start_gateway();
    EXPECT_EQ(gateway->exit_code(kPatience), 2) << name;
    EXPECT_THAT(gateway->output(), HasSubstr(endpoint(name)));
    EXPECT_FALSE(robot.heard()) << name;
  }
}

TEST_F(Processes, ASimulatorWhosePortIsInUseSaysSo) {
  const RawSocket occupied(SOCK_DGRAM, port_.at("robot"));
  const auto simulator = start_simulator();
  EXPECT_EQ(simulator->exit_code(kPatience), 2);
  EXPECT_THAT(simulator->output(), HasSubstr(endpoint("robot")));
}

TEST_F(Processes, HostsThatDoNotAnswerAreSaidAndLivedWith) {
  // 192.0.2.0/24 is reserved for documentation: nobody is there.
  std::string overlay = gateway_overlay();
  overlay.replace(overlay.find("plc = ") + 6, at("plc").size(), "\"192.0.2.1:48898\"\n");
  write("gateway.toml", overlay);
  Observer observer(domain_);
  const auto gateway = start_gateway();
  for (const char* const device : {"mru1", "qualisys", "arm", "winch"}) {
    ASSERT_TRUE(eventually(
        [&] {
          const auto health = observer.health(device);
          return !health.device.empty() && health.link != LinkState::up && !health.advice.empty();
        },
        kPatience))
        << device << ": " << observer.health(device).advice.view();
  }
  EXPECT_EQ(observer.mode().state, ModeState::off);
  EXPECT_TRUE(gateway->running());
  EXPECT_TRUE(eventually([&] { return gateway->output().find("winch") != std::string::npos; }, kPatience));
  gateway->send(SIGTERM);
  EXPECT_EQ(gateway->exit_code(kPatience), 0) << gateway->output();
}

TEST_F(Processes, AWrongConfigurationEndsTheGatewayWithItsPlace) {
  write("gateway.toml", gateway_overlay() + "periode_s = 1\n");
  const RawSocket robot(SOCK_DGRAM, port_.at("robot"));
  const auto gateway = start_gateway();
  EXPECT_EQ(gateway->exit_code(kPatience), 2);
  EXPECT_THAT(gateway->output(), HasSubstr("gateway.toml:"));
  EXPECT_THAT(gateway->output(), HasSubstr("periode_s"));
  EXPECT_FALSE(robot.heard());
}

TEST_F(Processes, CheckPrintsTheWiringAndOpensNothing) {
  const RawSocket occupied(SOCK_DGRAM, port_.at("mru1"));
  auto command = gateway_command();
  command.push_back("--check");
  Child check(command, folder_ / "check.log");
  EXPECT_EQ(check.exit_code(kPatience), 0);
  EXPECT_THAT(check.output(), HasSubstr(endpoint("mru1")));
  EXPECT_THAT(check.output(), HasSubstr("domain = " + std::to_string(domain_)));
}

}  // namespace
}  // namespace motionlab::integration
