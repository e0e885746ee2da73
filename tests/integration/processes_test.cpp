// The programs themselves, as separate processes on real sockets and a DDS domain of their own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>

#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "idl/topics.hpp"
#include "tests/integration/processes.hpp"

namespace motionlab::integration {
namespace {

using testing::AnyOf;
using testing::HasSubstr;
using topic::LinkState;
using topic::ModeAction;
using topic::ModeState;

/// Timing is judged on the virtual clock; here the machine may stall.
constexpr auto kPatience = std::chrono::seconds{40};

std::string config_file(const std::string& name) {
  return std::string(MOTIONLAB_SOURCE_DIR) + "/deploy/config/" + name;
}

/// What a person with DDS sees of the gateway.
class Observer {
 public:
  explicit Observer(int domain)
      : dds_({.domain = domain, .interface_whitelist = {"127.0.0.1"}, .participant = "test"}, local_),
        mode_(local_.reader<topic::Mode>()),
        control_(local_.reader<topic::Control>()),
        requests_(local_.advertise<topic::ModeRequest>()) {
    dds_.in<topic::Mode>();
    dds_.in<topic::Control>();
    dds_.in<topic::Health>();
    dds_.out<topic::ModeRequest>();
    dds_.start();
  }
  ~Observer() { dds_.stop(); }

  [[nodiscard]] topic::Mode mode() const { return mode_.newest().value_or(topic::Mode{}); }
  [[nodiscard]] topic::Control control() const { return control_.newest().value_or(topic::Control{}); }
  [[nodiscard]] topic::Health health(std::string_view device) const {
    topic::Health found;
    local_.for_each_newest<topic::Health>([&](const topic::Health& health) {
      if (health.device.view() == device) found = health;
    });
    return found;
  }
  [[nodiscard]] bool all_up() const {
    for (const char* const device : {"mru1", "mru2", "qualisys", "arm", "winch"}) {
      if (health(device).link != LinkState::up) return false;
    }
    return true;
  }
  void ask(ModeAction action) {
    topic::ModeRequest request;
    request.requester = "test";
    request.sequence_number = ++asked_;
    request.t_created_ns = to_ns(clock_.now());
    request.action = action;
    requests_.publish(request);
  }
  /// Asks until the mode is so.
  bool ask_until(ModeAction action, ModeState state) {
    return eventually(
        [&] {
          if (mode().state == state) return true;
          ask(action);
          return false;
        },
        kPatience);
  }
  bool wait_for(ModeState state) {
    return eventually([&] { return mode().state == state; }, kPatience);
  }

 private:
  RealClock clock_;
  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Reader<topic::Mode> mode_;
  bus::Reader<topic::Control> control_;
  bus::Publisher<topic::ModeRequest> requests_;
  std::uint64_t asked_ = 0;
};

/// A folder, ports and a DDS domain that nobody else uses.
class Processes : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("motionlab-" + std::to_string(getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    domain_ = 100 + getpid() % 130;
    std::vector<std::unique_ptr<RawSocket>> held;  // all at once, so that no port is drawn twice
    const auto draw = [&](int type) {
      held.push_back(std::make_unique<RawSocket>(type));
      return held.back()->port();
    };
    for (const char* const name : {"mru1", "mru2", "mru1_from", "mru2_from", "frames", "arm", "robot"}) {
      port_[name] = draw(SOCK_DGRAM);
    }
    for (const char* const name : {"qtm", "plc"}) port_[name] = draw(SOCK_STREAM);
    write("gateway.toml", gateway_overlay());
    write("world.toml", world_overlay());
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] std::string endpoint(const std::string& name) const {
    return std::string("127.0.0.1:").append(std::to_string(port_.at(name)));
  }
  [[nodiscard]] std::string at(const std::string& name) const { return '"' + endpoint(name) + "\"\n"; }
  [[nodiscard]] std::string gateway_overlay() const {
    std::string text = "[bus]\ndomain = " + std::to_string(domain_) + "\n";
    for (const char* const mru : {"mru1", "mru2"}) {
      text += std::string("[").append(mru) + "]\nlisten = " + at(mru) + "stale_after_s = 1.0\n";
    }
    text += "[qualisys]\nserver = " + at("qtm") + "listen = " + at("frames") + "stale_after_s = 1.0\n";
    text += "[comau]\nrobot_computer = " + at("robot") + "listen = " + at("arm") + "stale_after_s = 1.0\n";
    text += "[winch]\nplc = " + at("plc") + "stale_after_s = 1.0\n";
    return text;
  }
  [[nodiscard]] std::string world_overlay() const {
    return "[bus]\ndomain = " + std::to_string(domain_) + "\n[devices.mru1]\nfrom = " + at("mru1_from") +
           "to = " + at("mru1") + "[devices.mru2]\nfrom = " + at("mru2_from") + "to = " + at("mru2") +
           "[devices.qualisys]\nlisten = " + at("qtm") + "[devices.arm]\nlisten = " + at("robot") +
           "[devices.winch]\nlisten = " + at("plc");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }

  [[nodiscard]] std::vector<std::string> gateway_command() const {
    return {MOTIONLAB_GATEWAY,
            "--config",
            config_file("lab.toml"),
            "--overlay",
            config_file("loopback.toml"),
            "--overlay",
            (folder_ / "gateway.toml").string()};
  }
  [[nodiscard]] std::unique_ptr<Child> start_gateway() const {
    return std::make_unique<Child>(gateway_command(), folder_ / "gateway.log");
  }
  [[nodiscard]] std::unique_ptr<Child> start_simulator() const {
    return std::make_unique<Child>(
        std::vector<std::string>{MOTIONLAB_SIM, "--config", config_file("world.toml"), "--overlay",
                                 (folder_ / "world.toml").string()},
        folder_ / "sim.log");
  }

  std::filesystem::path folder_;
  int domain_ = 0;
  std::map<std::string, std::uint16_t> port_;
};

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
