#include "gateway/service/nftables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/core/error.hpp"
#include "tests/unit/service/configs.hpp"

namespace motionlab::service {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::vector<InterfaceAddress> kHost{{"127.0.0.1", "lo"}, {"192.168.90.70", "eth1"}};

TEST(Nftables, AdmitAtEachDeviceSocketItsConfiguredPeerAndDropTheRest) {
  const std::string rules = nftables_rules(lab_config(), kHost);
  EXPECT_THAT(rules, HasSubstr("ip saddr 192.168.90.13 udp dport 50043 counter accept comment \"mru1\"\n"));
  EXPECT_THAT(rules, HasSubstr("ip saddr 192.168.90.14 udp dport 50044 counter accept comment \"mru2\"\n"));
  EXPECT_THAT(rules,
              HasSubstr("ip saddr 192.168.90.16 udp dport 50199 counter accept comment \"qualisys\"\n"));
  EXPECT_THAT(rules,
              HasSubstr("ip saddr 192.168.90.32 ip daddr 192.168.90.42 udp sport 50032 udp dport 50042 "
                        "counter accept comment \"arm\"\n"));
  EXPECT_THAT(rules, HasSubstr("udp dport { 50042, 50043, 50044, 50199 } counter name "
                               "\"strangers_at_devices\" drop\n"));
}

TEST(Nftables, FollowTheConfiguration) {
  const auto config = lab_config("[mru1]\nlisten = \"192.168.90.70:50999\"\nsource = \"10.1.2.3\"\n");
  EXPECT_THAT(nftables_rules(config, kHost),
              HasSubstr("ip saddr 10.1.2.3 ip daddr 192.168.90.70 udp dport 50999 counter accept"));
}

TEST(Nftables, AdmitThePlcsRemoteReplyWhereItIsAskedFor) {
  EXPECT_THAT(nftables_rules(lab_config(), kHost), Not(HasSubstr("50060")));
  const std::string rules = nftables_rules(lab_config("[plc_reply]\nenabled = true\n"), kHost);
  EXPECT_THAT(rules,
              HasSubstr("ip saddr 192.168.90.50 ip daddr 192.168.90.60 udp sport 50050 udp dport 50060 "
                        "counter accept comment \"plc\"\n"));
  EXPECT_THAT(rules, HasSubstr("udp dport { 50042, 50043, 50044, 50060, 50199 } counter name"));
}

TEST(Nftables, AdmitTheBusFromItsInterfacesAndThisHost) {
  const auto config = lab_config("[bus]\ndomain = 42\ninterfaces = [\"192.168.90.70\"]\n");
  const std::string rules = nftables_rules(config, kHost);
  EXPECT_THAT(rules, HasSubstr("iifname { \"eth1\", \"lo\" } udp dport 17900-18149 counter accept"));
  EXPECT_THAT(rules, HasSubstr("udp dport 17900-18149 counter name \"strangers_at_bus\" drop"));
}

TEST(Nftables, SayThatABusOnAllInterfacesIsOpen) {
  const std::string rules = nftables_rules(lab_config("[bus]\ndomain = 232\n"), kHost);
  EXPECT_THAT(rules, Not(HasSubstr("iifname")));
  EXPECT_THAT(rules, HasSubstr("udp dport 65400-65535 counter accept"));  // the ports end there
  EXPECT_THAT(rules, HasSubstr("from anywhere"));
}

TEST(Nftables, RefuseABusInterfaceThatThisHostDoesNotHave) {
  const auto config = lab_config("[bus]\ninterfaces = [\"192.168.90.71\"]\n");
  EXPECT_THROW((void)nftables_rules(config, kHost), StartupError);
}

}  // namespace
}  // namespace motionlab::service
