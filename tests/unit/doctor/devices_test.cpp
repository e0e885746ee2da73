// What the doctor makes of what a gateway tells of its devices, and of devices without a gateway.
#include "gateway/doctor/devices.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "drivers/core/result.hpp"
#include "tests/unit/doctor/find.hpp"

namespace motionlab::doctor {
namespace {

using testing::HasSubstr;

topic::Health healthy(const char* device) {
  topic::Health health;
  health.device = device;
  health.link = topic::LinkState::up;
  health.required = true;
  health.rate_hz = 200.0;
  health.age_max_s = 0.008;
  health.stale_after_s = 0.025;
  return health;
}

monitor::Status ready() {
  topic::Mode mode;
  mode.state = topic::ModeState::ready;
  return {mode, {healthy("arm"), healthy("mru1")}};
}

TEST(DoctorsDevices, ThatAreWellPass) {
  const Findings findings = judge(ready());
  EXPECT_EQ(findings.size(), 3U);
  EXPECT_EQ(worst(findings), Grade::pass);
  EXPECT_THAT(find(findings, "mru1")->text, HasSubstr("200.0 Hz, oldest 8.0 of 25.0 ms"));
}

TEST(DoctorsDevices, TheControlThreadHasARateAndNoAge) {
  auto status = ready();
  status.devices[0].device = "gateway";
  status.devices[0].stale_after_s = 0;
  EXPECT_EQ(find(judge(status), "gateway")->text, "200.0 Hz");
}

TEST(DoctorsDevices, WhatIsNotUpFailsWhenItIsRequiredAndBringsItsAdvice) {
  auto status = ready();
  status.devices[0].link = topic::LinkState::down;
  status.devices[0].advice = "press START on the pendant";
  EXPECT_EQ(find(judge(status), "arm")->grade, Grade::fail);
  EXPECT_EQ(find(judge(status), "arm")->fix, "press START on the pendant");
  status.devices[0].required = false;
  EXPECT_EQ(find(judge(status), "arm")->grade, Grade::warn);
}

TEST(DoctorsDevices, TellWhatTheyRejectedAndHowNearTheyCame) {
  auto status = ready();
  status.devices[0].rejected[static_cast<std::size_t>(Reason::foreign)] = 3;
  status.devices[1].age_max_s = 0.024;
  const Findings findings = judge(status);
  EXPECT_EQ(find(findings, "arm")->grade, Grade::warn);
  EXPECT_THAT(find(findings, "arm")->text, HasSubstr("3 foreign"));
  EXPECT_EQ(find(findings, "mru1")->grade, Grade::warn);
  EXPECT_THAT(find(findings, "mru1")->text, HasSubstr("close to letting go"));
}

TEST(DoctorsDevices, ALatchedFaultIsToldWithTheWayOut) {
  auto status = ready();
  status.mode->state = topic::ModeState::fault;
  status.mode->reason = "mru1 is stale";
  const Findings findings = judge(status);
  EXPECT_EQ(find(findings, "mode")->grade, Grade::warn);
  EXPECT_THAT(find(findings, "mode")->fix, HasSubstr("motionlab reset"));
}

/// A TCP server that accepts and says nothing.
class Server {
 public:
  Server() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(socket_, reinterpret_cast<const sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(socket_, 1), 0);
    EXPECT_EQ(::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size), 0);
    endpoint_ = {INADDR_LOOPBACK, ntohs(address.sin_port)};
  }
  ~Server() { close(); }
  void close() {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }
  [[nodiscard]] Endpoint endpoint() const { return endpoint_; }

 private:
  int socket_;
  Endpoint endpoint_;
};

TEST(DoctorsDevices, WithoutAGatewayAreListenedForAndKnockedAt) {
  Server qtm, plc;
  plc.close();
  service::GatewayConfig config;
  service::MruLink mru;
  mru.driver.device = "mru1";
  mru.listen = {0, 0};  // any that is free: nothing comes
  mru.rule.required = true;
  config.mrus = {mru};
  config.qualisys.driver.device = "qualisys";
  config.qualisys.server = qtm.endpoint();
  config.winch.driver.device = "winch";
  config.winch.plc = plc.endpoint();
  config.winch.rule.required = true;
  config.comau.driver.device = "arm";
  const std::atomic<bool> interrupted{false};
  const Findings findings = look_for_devices(config, interrupted);
  EXPECT_EQ(find(findings, "mru1")->grade, Grade::fail);
  EXPECT_THAT(find(findings, "mru1")->text, HasSubstr("nothing comes"));
  EXPECT_EQ(find(findings, "qualisys")->grade, Grade::pass);
  EXPECT_EQ(find(findings, "winch")->grade, Grade::fail);
  EXPECT_THAT(find(findings, "winch")->text, HasSubstr("refused"));
  EXPECT_EQ(find(findings, "arm")->grade, Grade::warn);
}

}  // namespace
}  // namespace motionlab::doctor
