/// @file  Gateway and simulator as separate processes with ports and a DDS domain of their own, and somebody
/// who watches them by DDS.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "idl/topics.hpp"
#include "tests/integration/processes.hpp"
#include "tests/support/own_domain.hpp"

namespace motionlab::integration {

/// Where the programs are.
extern const char* const kGatewayProgram;
extern const char* const kSimulatorProgram;

/// Timing is judged on the virtual clock; here the machine may stall.
inline constexpr auto kPatience = std::chrono::seconds{40};

inline std::string config_file(const std::string& name) {
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
      if (health(device).link != topic::LinkState::up) return false;
    }
    return true;
  }
  void ask(topic::ModeAction action) {
    topic::ModeRequest request;
    request.requester = "test";
    request.sequence_number = ++asked_;
    request.t_created_ns = to_ns(clock_.now());
    request.action = action;
    requests_.publish(request);
  }
  /// Asks until the mode is so.
  bool ask_until(topic::ModeAction action, topic::ModeState state) {
    return eventually(
        [&] {
          if (mode().state == state) return true;
          ask(action);
          return false;
        },
        kPatience);
  }
  bool wait_for(topic::ModeState state) {
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

/// A folder, ports and a DDS domain that nobody else uses, and the programs on them.
class ProcessBench {
 public:
  /// @param name  of the folder, to be removed at the end
  void set_up(const std::string& name) {
    folder_ =
        std::filesystem::path(testing::TempDir()) / ("motionlab-" + std::to_string(getpid()) + "-" + name);
    std::filesystem::create_directories(folder_);
    domain_ = test::own_domain();
    std::vector<std::unique_ptr<RawSocket>> held;  // all at once, so that no port is drawn twice
    const auto draw = [&](int type) {
      held.push_back(std::make_unique<RawSocket>(type));
      return held.back()->port();
    };
    for (const char* const udp : {"mru1", "mru2", "mru1_from", "mru2_from", "frames", "arm", "robot"}) {
      port_[udp] = draw(SOCK_DGRAM);
    }
    for (const char* const tcp : {"qtm", "plc"}) port_[tcp] = draw(SOCK_STREAM);
    write("gateway.toml", gateway_overlay());
    write("world.toml", world_overlay());
  }
  void tear_down() const { std::filesystem::remove_all(folder_); }

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
    text += "[deadman]\nheartbeat_s = 0.5\ncontrol_s = 1.0\n";
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
    return {kGatewayProgram,
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
  [[nodiscard]] std::unique_ptr<Child> start_simulator(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command{kSimulatorProgram, "--config", config_file("world.toml"), "--overlay",
                                     (folder_ / "world.toml").string()};
    command.insert(command.end(), more.begin(), more.end());
    return std::make_unique<Child>(command, folder_ / "sim.log");
  }

  std::filesystem::path folder_;
  int domain_ = 0;
  std::map<std::string, std::uint16_t> port_;
};

/// The same as a test's fixture.
class Processes : public testing::Test, protected ProcessBench {
 protected:
  void SetUp() override {
    std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
    std::replace(name.begin(), name.end(), '/', '-');
    set_up(name);
  }
  void TearDown() override { tear_down(); }
};

}  // namespace motionlab::integration
