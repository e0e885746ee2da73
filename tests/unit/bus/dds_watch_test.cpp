#include "gateway/bus/dds_watch.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "idl/topics.hpp"
#include "tests/support/own_domain.hpp"

namespace motionlab::bus {
namespace {

/// A domain that no other test of this host uses at the same time, most likely.
DdsConfig loopback(std::string participant) {
  DdsConfig config;
  config.domain = test::own_domain();
  config.interface_whitelist = {"127.0.0.1"};
  config.participant = std::move(participant);
  config.join_truth = true;
  return config;
}

/// Waits for a condition, generously: the machine may be busy.
[[nodiscard]] bool eventually(const std::function<bool()>& condition) {
  const auto end = std::chrono::steady_clock::now() + 60s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(5ms);
  }
  return true;
}

SeenEndpoint writer(bool reliable, Durability durability, std::vector<std::string> partitions = {}) {
  SeenEndpoint end;
  end.writes = true;
  end.qos.reliable = reliable;
  end.qos.durability = durability;
  end.qos.partitions = std::move(partitions);
  return end;
}

TEST(SatisfiedByAll, AsksForTheStrongestThatAllOffer) {
  const SeenQos one = satisfied_by_all({writer(true, Durability::transient_local)});
  EXPECT_TRUE(one.reliable);
  EXPECT_EQ(one.durability, Durability::transient_local);
  const SeenQos both =
      satisfied_by_all({writer(true, Durability::transient_local), writer(false, Durability::persistent)});
  EXPECT_FALSE(both.reliable);
  EXPECT_EQ(both.durability, Durability::transient_local);
  EXPECT_EQ(satisfied_by_all({}).durability, Durability::not_kept);
  EXPECT_FALSE(satisfied_by_all({}).reliable);
}

TEST(SatisfiedByAll, LooksInEveryPartitionOnce) {
  const auto kept = Durability::not_kept;
  EXPECT_TRUE(satisfied_by_all({writer(true, kept)}).partitions.empty());
  EXPECT_EQ(satisfied_by_all({writer(true, kept, {"b", "a"}), writer(true, kept, {"a"})}).partitions,
            (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(satisfied_by_all({writer(true, kept, {"a"}), writer(true, kept)}).partitions,
            (std::vector<std::string>{"", "a"}));
}

TEST(DdsWatch, SeesWhoWritesAndReadsWhatInEveryPartition) {
  LocalBus local;
  DdsBus other{loopback("somebody"), local};
  other.out<topic::Mode>();
  other.out<topic::TruthWorld>();
  other.in<topic::Reference>();
  other.start();
  const DdsWatch watch{loopback("watch")};
  const auto of = [&watch](std::string_view topic) {
    const auto ends = watch.endpoints();
    const auto found = std::ranges::find(ends, topic, &SeenEndpoint::topic);
    return found == ends.end() ? SeenEndpoint{} : *found;
  };
  ASSERT_TRUE(
      eventually([&] { return watch.endpoints().size() == 3 && !of("motionlab/mode").participant.empty(); }));

  const SeenEndpoint mode = of("motionlab/mode");
  EXPECT_TRUE(mode.writes);
  EXPECT_EQ(mode.type, "motionlab::Mode");
  EXPECT_EQ(mode.participant, "somebody");
  EXPECT_EQ(mode.process, std::to_string(getpid()));
  std::array<char, 256> host{};
  ASSERT_EQ(gethostname(host.data(), host.size() - 1), 0);
  EXPECT_EQ(mode.host, host.data());
  EXPECT_TRUE(mode.qos.reliable);
  EXPECT_EQ(mode.qos.durability, Durability::transient_local);
  EXPECT_TRUE(mode.qos.xcdr1);
  EXPECT_TRUE(mode.qos.partitions.empty());
  EXPECT_EQ(of("truth/world").qos.partitions, std::vector<std::string>{"truth"});
  EXPECT_FALSE(of("truth/world").qos.reliable);
  EXPECT_GT(of("truth/world").qos.deadline_s, 0);
  EXPECT_FALSE(of("motionlab/reference").writes);
  ASSERT_EQ(watch.participants().size(), 1u);
  EXPECT_EQ(watch.participants()[0].name, "somebody");
}

TEST(DdsWatch, ForgetsWhoHasLeft) {
  const DdsWatch watch{loopback("watch")};
  {
    LocalBus local;
    DdsBus other{loopback("somebody"), local};
    other.out<topic::Mode>();
    ASSERT_TRUE(eventually([&] { return !watch.endpoints().empty(); }));
  }
  EXPECT_TRUE(eventually([&] { return watch.endpoints().empty() && watch.participants().empty(); }));
}

TEST(DdsWatch, HearsWithTheNumbersAndStampsOfDds) {
  LocalBus local;
  DdsBus other{loopback("somebody"), local};
  other.out<topic::Mru>();
  auto publisher = local.advertise<topic::Mru>();
  other.start();
  DdsWatch watch{loopback("watch")};
  auto tap = watch.hear<topic::Mru>("motionlab/mru");
  topic::Mru sample;
  sample.device = "mru1";
  std::vector<Heard<topic::Mru>> heard;
  ASSERT_TRUE(eventually([&] {
    ++sample.sequence_number;
    publisher.publish(sample);
    while (auto next = tap.next()) heard.push_back(*next);
    return heard.size() >= 5;
  }));
  const auto now =
      std::chrono::duration_cast<Nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
  for (std::size_t i = 0; i < heard.size(); ++i) {
    EXPECT_TRUE(heard[i].data);
    EXPECT_EQ(heard[i].refusal, Refusal::none);
    EXPECT_EQ(heard[i].sample.device.view(), "mru1");
    EXPECT_EQ(heard[i].writer, heard[0].writer);
    EXPECT_NEAR(static_cast<double>(now - heard[i].t_written_ns), 0, 120e9);
    EXPECT_NEAR(static_cast<double>(now - heard[i].t_heard_ns), 0, 120e9);
    if (other.counters().lost_locally > 0) continue;
    // Each sample was written once, so both numbers count alike: what is lost shows in both.
    EXPECT_EQ(heard[i].writer_sequence - heard[0].writer_sequence,
              heard[i].sample.sequence_number - heard[0].sample.sequence_number);
  }
}

TEST(DdsWatch, GetsAKeptSampleAndThoseOfAPartition) {
  LocalBus local;
  DdsBus other{loopback("somebody"), local};
  other.out<topic::Mode>();
  other.out<topic::TruthWorld>();
  auto modes = local.advertise<topic::Mode>();
  auto truths = local.advertise<topic::TruthWorld>();
  topic::Mode mode;
  mode.sequence_number = 7;
  modes.publish(mode);
  other.start();
  DdsWatch watch{loopback("watch")};
  auto mode_tap = watch.hear<topic::Mode>("motionlab/mode");
  auto truth_tap = watch.hear<topic::TruthWorld>("truth/world");
  std::optional<Heard<topic::Mode>> heard;
  EXPECT_TRUE(eventually([&] {
    if (!heard) heard = mode_tap.next();
    return heard.has_value();
  })) << "it was written before anybody listened";
  if (heard) {
    EXPECT_EQ(heard->sample.sequence_number, 7u);
  }
  EXPECT_TRUE(eventually([&] {
    truths.publish(topic::TruthWorld{});
    return truth_tap.next().has_value();
  }));
}

TEST(DdsWatch, RefusesToHearATopicTwice) {
  DdsWatch watch{loopback("watch")};
  const auto tap = watch.hear<topic::Mode>("motionlab/mode");
  EXPECT_THROW((void)watch.hear<topic::Event>("motionlab/mode"), StartupError);
}

}  // namespace
}  // namespace motionlab::bus
