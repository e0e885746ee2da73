#include "gateway/bus/dds_bus.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/own_domain.hpp"
#include "tests/unit/bus/samples.hpp"

extern char** environ;

namespace motionlab::bus {
namespace {

/// A domain that no other test of this host uses at the same time, most likely.
int own_domain() {
  return test::own_domain();
}

DdsConfig loopback(std::string participant) {
  DdsConfig config;
  config.domain = own_domain();
  config.interface_whitelist = {"127.0.0.1"};
  config.participant = std::move(participant);
  return config;
}

DdsConfig loopback_with_truth(std::string participant) {
  DdsConfig config = loopback(std::move(participant));
  config.join_truth = true;
  return config;
}

/// Waits for a condition, generously: the machine may be busy.
[[nodiscard]] bool eventually(const std::function<bool()>& condition, Nanoseconds patience = 60s) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(2ms);
  }
  return true;
}

/// A process's worth of bus.
struct Side {
  explicit Side(const DdsConfig& config) : dds{config, local} {}
  LocalBus local;
  DdsBus dds;
};

template <class T>
class EveryTopicOverDds : public testing::Test {};
TYPED_TEST_SUITE(EveryTopicOverDds, AllTopics::Types::Into<testing::Types>);

TYPED_TEST(EveryTopicOverDds, ArrivesUnchanged) {
  Side here{loopback_with_truth("here")};
  Side there{loopback_with_truth("there")};
  here.dds.template out<TypeParam>();
  there.dds.template in<TypeParam>();
  auto publisher = here.local.template advertise<TypeParam>();
  auto inbox = there.local.template subscribe<TypeParam>();
  here.dds.start();
  there.dds.start();
  const auto sample = random_sample<TypeParam>(11);
  std::optional<TypeParam> arrived;
  ASSERT_TRUE(eventually([&] {
    publisher.publish(sample);  // again and again: the volatile classes may lose what is written too early
    return (arrived = inbox.next()).has_value();
  }));
  EXPECT_EQ(differences(*arrived, sample), std::vector<std::string>{});
  EXPECT_TRUE(eventually([&] { return here.dds.counters().written >= 1; }));
  EXPECT_GE(there.dds.counters().taken, 1u);
  // After a stall they come in a burst, and more than a control step can take are refused, rightly.
  EXPECT_EQ(there.dds.counters().refused() - there.dds.counters().refused_flood, 0u);
  EXPECT_EQ(here.dds.counters().incompatible_qos + there.dds.counters().incompatible_qos, 0u);
  EXPECT_EQ(here.dds.template matched<TypeParam>(), 1u);
}

TEST(DdsBus, DoesNotShowTheTruthToOneThatDidNotJoin) {
  Side simulator{loopback_with_truth("simulator")};
  Side gateway{loopback("gateway")};
  EXPECT_THROW(gateway.dds.in<topic::TruthWorld>(), StartupError);
  EXPECT_THROW(gateway.dds.out<topic::SimControl>(), StartupError);
  simulator.dds.out<topic::TruthWorld>();
  EXPECT_EQ(gateway.dds.matched<topic::TruthWorld>(), 0u);
}

TEST(DdsBus, TellsALateJoinerTheMode) {
  Side gateway{loopback("gateway")};
  gateway.dds.out<topic::Mode>();
  gateway.dds.start();
  topic::Mode mode;
  mode.sequence_number = 3;
  mode.reason = "every device is fresh";
  auto publisher = gateway.local.advertise<topic::Mode>();
  publisher.publish(mode);
  ASSERT_TRUE(eventually([&] { return gateway.dds.counters().written == 1; }));

  Side late{loopback("late")};
  late.dds.in<topic::Mode>();
  late.dds.start();
  auto reader = late.local.reader<topic::Mode>();
  ASSERT_TRUE(eventually([&] { return reader.newest().has_value(); }));
  EXPECT_EQ(reader.newest()->reason.view(), "every device is fresh");
}

TEST(DdsBus, DoesNotStarveALateJoinerWhileAStateIsWrittenFast) {
  Side gateway{loopback("gateway")};
  gateway.dds.out<topic::Mode>();
  gateway.dds.start();
  auto publisher = gateway.local.advertise<topic::Mode>();
  for (int joiner = 0; joiner < 6; ++joiner) {
    Side late{loopback("late")};
    late.dds.in<topic::Mode>();
    late.dds.start();
    auto reader = late.local.reader<topic::Mode>();
    EXPECT_TRUE(eventually(
        [&] {
          publisher.publish({});
          return reader.newest().has_value();
        },
        5s))
        << joiner;
  }
}

TEST(DdsBus, TellsALateJoinerTheLastHundredEvents) {
  Side gateway{loopback("gateway")};
  gateway.dds.out<topic::Event>();
  gateway.dds.start();
  auto publisher = gateway.local.advertise<topic::Event>();
  topic::Event event;
  for (event.sequence_number = 1; event.sequence_number <= 150; ++event.sequence_number)
    publisher.publish(event);
  ASSERT_TRUE(eventually([&] { return gateway.dds.counters().written == 150; }));

  Side late{loopback("late")};
  late.dds.in<topic::Event>();
  auto inbox = late.local.subscribe<topic::Event>();
  late.dds.start();
  ASSERT_TRUE(eventually([&] { return late.dds.counters().taken == 100; }));
  for (std::uint64_t number = 51; number <= 150; ++number) EXPECT_EQ(inbox.next()->sequence_number, number);
}

TEST(DdsBus, CarriesCommandsBothWaysWithoutACircleAndNobodySpeaksForAnother) {
  Side gateway{loopback("gateway")}, pilot{loopback("pilot")};
  for (Side* const side : {&gateway, &pilot}) {
    side->dds.both<topic::ArmCommand>();
    side->dds.start();
  }
  auto ours = gateway.local.advertise<topic::ArmCommand>();
  auto theirs = pilot.local.advertise<topic::ArmCommand>();
  auto forged = pilot.local.advertise<topic::ArmCommand>();
  topic::ArmCommand command;
  command.device = "arm";
  const auto say = [&command](auto& publisher, const char* who, std::uint64_t number) {
    command.requester = who;
    command.sequence_number = number;
    return publisher.publish(command);
  };
  ASSERT_TRUE(say(ours, "gateway", 1));
  std::uint64_t number = 1;
  ASSERT_TRUE(eventually([&] {
    ++number;
    (void)say(ours, "gateway", number);
    (void)say(theirs, "pilot", number);
    (void)say(forged, "gateway", 1'000'000);
    const auto here = gateway.local.newest<topic::ArmCommand>("arm", "pilot");
    return here && here->sequence_number > 1 && gateway.dds.counters().refused_instance > 3;
  }));
  EXPECT_LT(gateway.local.newest<topic::ArmCommand>("arm", "gateway")->sequence_number, 1'000'000U);
  EXPECT_FALSE(gateway.local.newest<topic::ArmCommand>("arm", "nobody"));
  // Nothing is sent on that came in, and nothing of one's own comes back.
  const auto written = gateway.dds.counters().written;
  EXPECT_LE(written, number);
}

TEST(DdsBus, CarriesRequestsOfTwoRequestersAndAllOfABurst) {
  Side gateway{loopback("gateway")};
  gateway.dds.in<topic::ModeRequest>();
  auto inbox = gateway.local.subscribe<topic::ModeRequest>();
  gateway.dds.start();
  std::vector<std::unique_ptr<Side>> requesters;
  for (const char* name : {"console", "hand"}) {
    requesters.push_back(std::make_unique<Side>(loopback(name)));
    requesters.back()->dds.out<topic::ModeRequest>();
    requesters.back()->dds.start();
  }
  ASSERT_TRUE(eventually([&] { return gateway.dds.matched<topic::ModeRequest>() == 2; }));
  for (const auto& side : requesters) {
    ASSERT_TRUE(eventually([&] { return side->dds.matched<topic::ModeRequest>() == 1; }));
    auto publisher = side->local.advertise<topic::ModeRequest>();
    topic::ModeRequest request;
    request.action = topic::ModeAction::reset;  // several settles would be one
    request.requester = side == requesters.front() ? "console" : "hand";
    for (request.sequence_number = 1; request.sequence_number <= 16; ++request.sequence_number) {
      EXPECT_TRUE(publisher.publish(request));
    }
  }
  std::set<std::string> seen;
  EXPECT_TRUE(eventually([&] {
    while (const auto request = inbox.next()) {
      seen.insert(request->requester.str() + std::to_string(request->sequence_number));
    }
    return seen.size() == 32;
  })) << seen.size();
}

TEST(DdsBus, CarriesTwelveInstancesOfHealth) {
  Side gateway{loopback("gateway")};
  Side console{loopback("console")};
  gateway.dds.out<topic::Health>();
  console.dds.in<topic::Health>();
  gateway.dds.start();
  console.dds.start();
  auto publisher = gateway.local.advertise<topic::Health>();
  topic::Health health;
  for (int i = 0; i < 12; ++i) {
    health.device = "device" + std::to_string(i);
    publisher.publish(health);
  }
  EXPECT_TRUE(eventually([&] {
    int devices = 0;
    console.local.for_each_newest<topic::Health>([&](const topic::Health&) { ++devices; });
    return devices == 12;
  }));
  EXPECT_EQ(gateway.dds.counters().write_failed, 0u);
}

TEST(DdsBus, RefusesAndCountsASampleThatIsNotFinite) {
  Side here{loopback("here")};
  Side there{loopback("there")};
  here.dds.out<topic::Reference>();
  there.dds.in<topic::Reference>();
  auto inbox = there.local.subscribe<topic::Reference>();
  here.dds.start();
  there.dds.start();
  auto publisher = here.local.advertise<topic::Reference>();
  topic::Reference reference;
  reference.p_world_load_m[1] = std::nan("");
  publisher.publish(reference);
  ASSERT_TRUE(eventually([&] { return there.dds.counters().refused_not_finite == 1; }));
  reference.p_world_load_m[1] = 1.5;
  publisher.publish(reference);  // and the writer is not cut off for it
  std::optional<topic::Reference> arrived;
  ASSERT_TRUE(eventually([&] { return (arrived = inbox.next()).has_value(); }));
  EXPECT_EQ(arrived->p_world_load_m[1], 1.5);
}

TEST(DdsBus, DoesNotLetTheWorldSpeakForADeviceOfThisProcess) {
  Side stranger{loopback("stranger")};
  Side gateway{loopback("gateway")};
  stranger.dds.out<topic::Mru>();
  gateway.dds.in<topic::Mru>();
  auto own = gateway.local.advertise<topic::Mru>();
  topic::Mru sample;
  sample.device = "mru1";
  sample.sequence_number = 1;
  ASSERT_TRUE(own.publish(sample));
  stranger.dds.start();
  gateway.dds.start();
  auto foreign = stranger.local.advertise<topic::Mru>();
  sample.sequence_number = 999;
  ASSERT_TRUE(eventually([&] {
    foreign.publish(sample);
    return gateway.dds.counters().refused_instance > 0;
  }));
  EXPECT_EQ(gateway.local.reader<topic::Mru>("mru1").newest()->sequence_number, 1u);
}

TEST(DdsBus, SendsThePacedTopicsLessOftenThanTheyAreMade) {
  Side gateway{loopback("gateway")};
  gateway.dds.out<topic::Estimate>();
  auto publisher = gateway.local.advertise<topic::Estimate>();
  topic::Estimate estimate;
  for (estimate.sequence_number = 1; estimate.sequence_number <= 100; ++estimate.sequence_number) {
    publisher.publish(estimate);
  }
  ASSERT_TRUE(eventually([&] { return gateway.dds.run_once(100ms) > 0; }));
  EXPECT_EQ(gateway.dds.counters().written, 1u);
  EXPECT_EQ(gateway.dds.counters().lost_locally, 0u);
}

TEST(DdsBus, SendsOfCommandsThatGoBothWaysTheNewestOfEachWhoCommands) {
  Side gateway{loopback("gateway")};
  gateway.dds.both<topic::ArmCommand>();
  auto publisher = gateway.local.advertise<topic::ArmCommand>();
  topic::ArmCommand command;
  for (const char* const requester : {"gateway", "second"}) {
    command.requester = requester;
    for (command.sequence_number = 1; command.sequence_number <= 100; ++command.sequence_number)
      publisher.publish(command);
  }
  ASSERT_TRUE(eventually([&] { return gateway.dds.run_once(100ms) > 0; }));
  EXPECT_EQ(gateway.dds.counters().written, 2u);
  EXPECT_EQ(gateway.dds.counters().lost_locally, 0u);
}

TEST(DdsBus, SaysWhatToDoAboutAConfigurationThatCannotWork) {
  LocalBus local;
  DdsConfig config = loopback("wrong");
  config.interface_whitelist = {"203.0.113.77"};
  try {
    DdsBus dut{config, local};
    FAIL() << "an interface that nobody has";
  } catch (const StartupError& error) {
    EXPECT_NE(std::string{error.what()}.find("203.0.113.77"), std::string::npos) << error.what();
    EXPECT_NE(std::string{error.what()}.find("127.0.0.1"), std::string::npos) << error.what();
  }
  for (const int domain : {-1, 233}) {
    config = loopback("wrong");
    config.domain = domain;
    EXPECT_THROW((DdsBus{config, local}), StartupError) << domain;
  }
  DdsBus dut{loopback("right"), local};
  dut.in<topic::Mru>();
  EXPECT_THROW(dut.out<topic::Mru>(), StartupError) << "samples would circle";
  EXPECT_THROW(dut.in<topic::Mru>(), StartupError) << "twice";
}

TEST(DdsBus, StartsAndStopsAgainAndAgain) {
  LocalBus local;
  DdsBus dut{loopback("restless"), local};
  dut.in<topic::Mode>();
  for (int i = 0; i < 3; ++i) {
    dut.start();
    dut.start();
    dut.stop();
    dut.stop();
  }
}

TEST(DdsBus, LeavesNoSegmentInSharedMemory) {
  Side dut{loopback("tidy")};
  dut.dds.out<topic::Mode>();
  dut.dds.in<topic::Event>();
  std::ifstream maps{"/proc/self/maps"};
  for (std::string line; std::getline(maps, line);) {
    EXPECT_EQ(line.find("/dev/shm/fast"), std::string::npos) << line;
  }
}

/// Not a test: the other process of the one below.
TEST(Peer, DISABLED_CommandsForEver) {
  ASSERT_NE(std::getenv("MOTIONLAB_TEST_DOMAIN"), nullptr);
  DdsConfig config = loopback("peer");
  config.domain = std::atoi(std::getenv("MOTIONLAB_TEST_DOMAIN"));
  Side side{config};
  side.dds.out<topic::ArmCommand>();
  side.dds.start();
  auto publisher = side.local.advertise<topic::ArmCommand>();
  const pid_t parent = getppid();
  while (getppid() == parent) {
    publisher.publish(random_sample<topic::ArmCommand>(5));
    std::this_thread::sleep_for(10ms);
  }
}

TEST(DdsBus, NoticesThatAPeerWasKilled) {
  Side survivor{loopback("survivor")};
  survivor.dds.in<topic::ArmCommand>();
  survivor.dds.start();

  setenv("MOTIONLAB_TEST_DOMAIN", std::to_string(own_domain()).c_str(), 1);
  std::vector<std::string> words{"/proc/self/exe", "--gtest_also_run_disabled_tests",
                                 "--gtest_filter=Peer.DISABLED_CommandsForEver"};
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t peer = 0;
  ASSERT_EQ(posix_spawn(&peer, arguments[0], nullptr, nullptr, arguments.data(), environ), 0);

  const bool heard = eventually([&] { return survivor.dds.counters().taken > 3; });
  const std::uint64_t lost_before = survivor.dds.counters().liveliness_lost;
  kill(peer, SIGKILL);
  waitpid(peer, nullptr, 0);
  ASSERT_TRUE(heard);
  EXPECT_TRUE(eventually([&] { return survivor.dds.counters().liveliness_lost > lost_before; }));
  EXPECT_TRUE(eventually([&] { return survivor.dds.matched<topic::ArmCommand>() == 0; }));
}

}  // namespace
}  // namespace motionlab::bus
