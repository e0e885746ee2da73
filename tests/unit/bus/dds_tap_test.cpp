#include "gateway/bus/dds_tap.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "gateway/bus/cdr_reader.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/topic_list.hpp"
#include "tests/support/own_domain.hpp"
#include "tests/unit/bus/samples.hpp"

namespace motionlab::bus {
namespace {

DdsConfig loopback(bool join_truth) {
  DdsConfig config;
  config.domain = test::own_domain();
  config.interface_whitelist = {"127.0.0.1"};
  config.join_truth = join_truth;
  return config;
}

template <class Done>
bool eventually(Done&& done) {
  const auto end = std::chrono::steady_clock::now() + 30s;
  while (!done()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(10ms);
  }
  return true;
}

/// Publishes random samples of every topic until a tap has handed over one of each, and reads them back.
class TappedTopic : public ::testing::Test {
 protected:
  template <class T>
  void look_for() {
    LocalBus local;
    DdsBus out{loopback(true), local};
    out.out<T>();
    out.start();
    DdsTap tap{loopback(true)};
    auto publisher = local.advertise<T>();
    const T sent = random_sample<T>(7);
    bool same = false;
    EXPECT_TRUE(eventually([&] {
      publisher.publish(sent);
      tap.take([&](const TappedSample& sample) {
        if (sample.topic != topic_index<T>()) return;
        std::vector<std::byte> bytes{sample.cdr.begin(), sample.cdr.end()};
        T back;
        const Refusal refusal = read_cdr(reinterpret_cast<char*>(bytes.data()), bytes.size(), back);
        same = same || (refusal == Refusal::none && differences(sent, back).empty());
        EXPECT_EQ(sample.instance.empty(), !T::kKeyed);
      });
      return same;
    })) << TopicTraits<T>::name;
    EXPECT_EQ(tap.refused(), 0U);
    EXPECT_GE(tap.writers(topic_index<T>()), 1U);
  }
};

TEST_F(TappedTopic, ComesThroughTheTapWithItsBytes) {
#define MOTIONLAB_LOOK(Type) look_for<topic::Type>();
  MOTIONLAB_FOR_EACH_TOPIC_TYPE(MOTIONLAB_LOOK)
#undef MOTIONLAB_LOOK
}

TEST(DdsTap, TellsTheInstancesOfATopicApart) {
  LocalBus local;
  DdsBus out{loopback(false), local};
  out.out<topic::Bodies>();
  out.start();
  DdsTap tap{loopback(false)};
  auto publisher = local.advertise<topic::Bodies>();
  std::set<std::string> seen;
  EXPECT_TRUE(eventually([&] {
    for (const char* body : {"load", "platform"}) {
      topic::Bodies sample;
      sample.device = "qualisys";
      sample.body = body;
      publisher.publish(sample);
    }
    tap.take([&](const TappedSample& sample) { seen.emplace(sample.instance); });
    return seen == std::set<std::string>{"qualisys/load", "qualisys/platform"};
  }));
}

TEST(DdsTap, DoesNotSeeTheTruthUnlessItIsToldTo) {
  LocalBus local;
  DdsBus out{loopback(true), local};
  out.out<topic::TruthWorld>();
  out.out<topic::Mode>();
  out.start();
  DdsTap tap{loopback(false)};
  auto truth = local.advertise<topic::TruthWorld>();
  auto mode = local.advertise<topic::Mode>();
  std::map<std::size_t, int> seen;
  EXPECT_TRUE(eventually([&] {
    truth.publish({});
    mode.publish({});
    tap.take([&](const TappedSample& sample) { ++seen[sample.topic]; });
    return seen[topic_index<topic::Mode>()] > 3;
  }));
  EXPECT_EQ(seen.count(topic_index<topic::TruthWorld>()), 0U);
  EXPECT_EQ(tap.writers(topic_index<topic::TruthWorld>()), 0U);
}

TEST(DdsTap, KeepsTheNewestWhenNobodyTakes) {
  LocalBus local;
  DdsBus out{loopback(false), local};
  out.out<topic::Control>();
  out.start();
  DdsTap tap{loopback(false)};
  auto publisher = local.advertise<topic::Control>();
  ASSERT_TRUE(eventually([&] { return tap.writers(topic_index<topic::Control>()) > 0; }));
  topic::Control sample;
  std::uint64_t last = 0;
  EXPECT_TRUE(eventually([&] {  // it is paced: a few are written each round
    sample.sequence_number += 1;
    publisher.publish(sample);
    last = sample.sequence_number;
    return last > 200;
  }));
  std::uint64_t newest = 0;
  EXPECT_TRUE(eventually([&] {
    tap.take([&](const TappedSample& tapped) {
      std::vector<std::byte> bytes{tapped.cdr.begin(), tapped.cdr.end()};
      topic::Control back;
      ASSERT_EQ(read_cdr(reinterpret_cast<char*>(bytes.data()), bytes.size(), back), Refusal::none);
      newest = back.sequence_number;
    });
    return newest == last;
  }));
}

}  // namespace
}  // namespace motionlab::bus
