// What the doctor makes of a network.
#include "gateway/doctor/network.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include "tests/unit/doctor/find.hpp"

namespace motionlab::doctor {
namespace {

using testing::HasSubstr;

constexpr std::uint32_t kArmSide = 0xC0A85A2A;  // 192.168.90.42
constexpr std::uint32_t kLabSide = 0xC0A85A46;  // 192.168.90.70

service::GatewayConfig laboratory() {
  service::GatewayConfig config;
  service::MruLink mru;
  mru.driver.device = "mru1";
  mru.listen = {0, 50043};
  config.mrus = {mru};
  config.qualisys.driver.device = "qualisys";
  config.qualisys.listen = {0, 50199};
  config.comau.driver.device = "arm";
  config.comau.listen = {kArmSide, 50042};
  config.bus.interface_whitelist = {"192.168.90.70"};
  return config;
}

Network a_good_one() {
  return {.interfaces = {{"lo", 0x7F000001, true, false, true, {}},
                         {"eth0", kLabSide, true, true, false, 3},
                         {"eth1", kArmSide, true, true, false, {}}},
          .bound = {{{kLabSide, 53}, 1, "dnsmasq"}}};
}

TEST(DoctorsNetwork, ThatIsAsItShouldBePasses) {
  const Findings findings = judge(a_good_one(), laboratory());
  EXPECT_EQ(worst(findings), Grade::pass);
  EXPECT_THAT(find(findings, "port of arm")->text, HasSubstr("udp 192.168.90.42:50042 is free"));
  EXPECT_TRUE(find(findings, "interface eth0"));
  EXPECT_TRUE(find(findings, "interface eth1")) << "the robot computer comes in by it";
}

TEST(DoctorsNetwork, WhoHasAPortDecides) {
  Network network = a_good_one();
  network.bound.push_back({{0, 50043}, 2, "motionlab-gatew"});
  network.bound.push_back({{kArmSide, 50042}, 3, "matlab"});
  network.bound.push_back({{0, 50199}, 4, ""});
  const Findings findings = judge(network, laboratory());
  EXPECT_EQ(find(findings, "port of mru1")->grade, Grade::pass);
  EXPECT_EQ(find(findings, "port of arm")->grade, Grade::fail);
  EXPECT_THAT(find(findings, "port of arm")->text, HasSubstr("matlab has"));
  EXPECT_EQ(find(findings, "port of qualisys")->grade, Grade::warn);
}

TEST(DoctorsNetwork, APortAtAnotherAddressIsNoHindrance) {
  Network network = a_good_one();
  network.bound.push_back({{kLabSide, 50042}, 3, "matlab"});
  EXPECT_EQ(find(judge(network, laboratory()), "port of arm")->grade, Grade::pass);
}

TEST(DoctorsNetwork, AnAddressThatIsNotHereFails) {
  Network network = a_good_one();
  network.interfaces.pop_back();
  EXPECT_EQ(find(judge(network, laboratory()), "port of arm")->grade, Grade::fail);
  network.interfaces.pop_back();
  EXPECT_EQ(find(judge(network, laboratory()), "[bus] interfaces")->grade, Grade::fail);
}

TEST(DoctorsNetwork, AnInterfaceIsLookedAtForWhatDelaysOrLosesDatagrams) {
  Network network = a_good_one();
  network.interfaces[1].held_back_us = 200;
  network.interfaces[2].up = false;
  Findings findings = judge(network, laboratory());
  EXPECT_EQ(find(findings, "interface eth0")->grade, Grade::warn);
  EXPECT_THAT(find(findings, "interface eth0")->fix, HasSubstr("ethtool -C eth0"));
  EXPECT_EQ(find(findings, "interface eth1")->grade, Grade::fail);
  network.interfaces[1].held_back_us.reset();
  network.interfaces[1].multicast = false;
  findings = judge(network, laboratory());
  EXPECT_EQ(find(findings, "interface eth0")->grade, Grade::warn);
}

TEST(DoctorsNetwork, ReadsTheKernelsTable) {
  const auto ports = bound_ports(
      "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref "
      "pointer\n"
      " 1234: 2A5AA8C0:C37A 00000000:0000 07 00000000:00000000 00:00000000 00000000     0        0 987654 2 "
      "0000 0\n"
      "not a line\n");
  ASSERT_EQ(ports.size(), 1U);
  EXPECT_EQ(to_string(ports[0].local), "192.168.90.42:50042");
  EXPECT_EQ(ports[0].inode, 987654U);
}

TEST(DoctorsNetwork, KnowsItsOwnProgramByItsPort) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(::getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const Network network = look_at_network();
  ::close(socket);
  const auto mine =
      std::ranges::find(network.bound, Endpoint{INADDR_LOOPBACK, ntohs(address.sin_port)}, &BoundPort::local);
  ASSERT_NE(mine, network.bound.end());
  EXPECT_EQ(mine->program, "unit_doctor");
  EXPECT_TRUE(std::ranges::any_of(network.interfaces, &Interface::loopback));
}

}  // namespace
}  // namespace motionlab::doctor
