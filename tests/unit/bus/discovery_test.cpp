// Two programs of one host find each other without multicast; what cannot be is refused before DDS starts.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "drivers/core/error.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "tests/support/own_domain.hpp"

namespace motionlab::bus {
namespace {

using testing::HasSubstr;

DdsConfig loopback(std::string participant) {
  DdsConfig config;
  config.domain = test::own_domain();
  config.interface_whitelist = {"127.0.0.1"};
  config.participant = std::move(participant);
  return config;
}

struct Side {
  explicit Side(const DdsConfig& config) : dds{config, local} {}
  LocalBus local;
  DdsBus dds;
};

/// What keeps a bus with this configuration from starting; empty: nothing.
std::string complaint(const DdsConfig& config) {
  try {
    const Side side{config};
    return {};
  } catch (const StartupError& error) {
    return error.what();
  }
}

TEST(Discovery, ByAddressFindsTheProgramsOfTheSameHost) {
  DdsConfig here = loopback("here"), there = loopback("there");
  here.peers = there.peers = {"127.0.0.1"};
  Side gateway{here}, tool{there};
  gateway.dds.out<topic::Mode>();
  tool.dds.in<topic::Mode>();
  gateway.dds.start();
  tool.dds.start();
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds{60};
  while (tool.dds.matched<topic::Mode>() == 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds{2});
  }
  EXPECT_EQ(tool.dds.matched<topic::Mode>(), 1U);
}

TEST(Discovery, GoesOneWayOnly) {
  DdsConfig config = loopback("both");
  config.peers = {"127.0.0.1"};
  config.server = "127.0.0.1:11811";
  EXPECT_THAT(complaint(config), HasSubstr("choose one"));
  config.peers = {};
  config.security = "identity";
  EXPECT_THAT(complaint(config), HasSubstr("no identity"));
}

TEST(Discovery, RefusesWhatIsNoAddress) {
  DdsConfig config = loopback("lost");
  config.peers = {"desk"};
  EXPECT_THAT(complaint(config), HasSubstr("desk"));
  config.peers = {};
  config.server = "127.0.0.1";
  EXPECT_THAT(complaint(config), HasSubstr("127.0.0.1"));
}

TEST(Security, AMissingFileIsNamedWithWhatMakesIt) {
  DdsConfig config = loopback("nobody");
  config.security = testing::TempDir() + "/no-such-identity";
  EXPECT_THAT(complaint(config), HasSubstr("no-such-identity/authority.pem"));
  EXPECT_THAT(complaint(config), HasSubstr("identities.sh"));
}

TEST(Security, AKeyThatOthersCanReadIsRefused) {
  const std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("identity-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  for (const char* const file : {"authority.pem", "certificate.pem", "key.pem"}) std::ofstream(folder / file);
  ASSERT_EQ(chmod((folder / "key.pem").c_str(), 0640), 0);
  DdsConfig config = loopback("careless");
  config.security = folder.string();
  EXPECT_THAT(complaint(config), HasSubstr("chmod 600"));
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace motionlab::bus
