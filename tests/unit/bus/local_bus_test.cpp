#include "gateway/bus/local_bus.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

namespace motionlab::bus {
namespace {

topic::Mru mru(const char* device, std::uint64_t number) {
  topic::Mru sample;
  sample.device = device;
  sample.sequence_number = number;
  return sample;
}

TEST(LocalBus, HasNothingBeforeTheFirstSample) {
  LocalBus bus;
  auto reader = bus.reader<topic::Mru>("mru1");
  auto inbox = bus.subscribe<topic::Mru>();
  EXPECT_FALSE(reader.newest());
  EXPECT_FALSE(reader.newer());
  EXPECT_FALSE(inbox.next());
}

TEST(LocalBus, GivesTheNewestOfTheInstanceThatWasAskedFor) {
  LocalBus bus;
  auto one = bus.reader<topic::Mru>("mru1");
  auto publisher = bus.advertise<topic::Mru>();
  EXPECT_TRUE(publisher.publish(mru("mru1", 1)));
  EXPECT_TRUE(publisher.publish(mru("mru1", 2)));
  EXPECT_TRUE(publisher.publish(mru("mru2", 7)));
  EXPECT_EQ(one.newest()->sequence_number, 2u);
  EXPECT_EQ(bus.reader<topic::Mru>("mru2").newest()->sequence_number, 7u);
}

TEST(LocalBus, TellsBodiesApartByAllTheirKeyFields) {
  LocalBus bus;
  auto publisher = bus.advertise<topic::Bodies>();
  topic::Bodies sample;
  sample.device = "qualisys";
  sample.body = "load";
  sample.frame_number = 1;
  publisher.publish(sample);
  sample.body = "platform";
  sample.frame_number = 2;
  publisher.publish(sample);
  EXPECT_EQ(bus.reader<topic::Bodies>("qualisys", "load").newest()->frame_number, 1u);
  EXPECT_EQ(bus.reader<topic::Bodies>("qualisys", "platform").newest()->frame_number, 2u);
  EXPECT_FALSE(bus.reader<topic::Bodies>("other", "load").newest());
}

TEST(LocalBus, HandsOutEachSampleOnceAsNewer) {
  LocalBus bus;
  auto publisher = bus.advertise<topic::Estimate>();
  auto reader = bus.reader<topic::Estimate>();
  publisher.publish({});
  EXPECT_TRUE(reader.newer());
  EXPECT_FALSE(reader.newer());
  EXPECT_TRUE(reader.newest());
  publisher.publish({});
  EXPECT_TRUE(reader.newer());
}

TEST(LocalBus, LetsAnInstanceHaveOnePublisherAtATime) {
  LocalBus bus;
  auto inbox = bus.subscribe<topic::Mru>();
  auto second = bus.advertise<topic::Mru>();
  {
    auto first = bus.advertise<topic::Mru>();
    EXPECT_TRUE(first.publish(mru("mru1", 1)));
    EXPECT_FALSE(second.publish(mru("mru1", 2)));
    EXPECT_TRUE(second.publish(mru("mru2", 3)));
    EXPECT_EQ(bus.refused<topic::Mru>(), 1u);
  }
  EXPECT_TRUE(second.publish(mru("mru1", 4)));  // the first has left
  std::vector<std::uint64_t> numbers;
  while (const auto sample = inbox.next()) numbers.push_back(sample->sequence_number);
  EXPECT_EQ(numbers, (std::vector<std::uint64_t>{1, 3, 4}));
}

TEST(LocalBus, KeepsSixteenInstancesAndRefusesTheNext) {
  LocalBus bus;
  auto publisher = bus.advertise<topic::Health>();
  topic::Health sample;
  for (int i = 0; i < 16; ++i) {
    sample.device = std::to_string(i);
    EXPECT_TRUE(publisher.publish(sample)) << i;
  }
  sample.device = "one too many";
  EXPECT_FALSE(publisher.publish(sample));
  EXPECT_EQ(bus.refused<topic::Health>(), 1u);
  EXPECT_THROW((void)bus.reader<topic::Health>("one too many"), StartupError);
  int seen = 0;
  bus.for_each_newest<topic::Health>(
      [&](const topic::Health& health) { EXPECT_EQ(health.device.view(), std::to_string(seen++)); });
  EXPECT_EQ(seen, 16);
}

TEST(LocalBus, GivesEverySubscriptionEverySample) {
  LocalBus bus;
  auto a = bus.subscribe<topic::Event>();
  auto b = bus.subscribe<topic::Event>();
  auto publisher = bus.advertise<topic::Event>();
  auto another = bus.advertise<topic::Event>();
  topic::Event event;
  event.code = "first";
  EXPECT_TRUE(publisher.publish(event));
  event.code = "second";
  EXPECT_TRUE(another.publish(event));
  for (auto* inbox : {&a, &b}) {
    EXPECT_EQ(inbox->next()->code.view(), "first");
    EXPECT_EQ(inbox->next()->code.view(), "second");
    EXPECT_FALSE(inbox->next());
  }
}

TEST(LocalBus, CountsWhatNobodyTook) {
  LocalBus bus;
  auto inbox = bus.subscribe<topic::Event>();
  auto publisher = bus.advertise<topic::Event>();
  topic::Event event;
  for (int i = 0; i < 300; ++i) {
    event.sequence_number += 1;
    publisher.publish(event);
  }
  EXPECT_EQ(inbox.lost(), 300u - 256u);
  EXPECT_EQ(inbox.next()->sequence_number, 1u);  // the oldest stay
}

TEST(LocalBus, ForgetsASubscriptionThatHasEnded) {
  LocalBus bus;
  auto publisher = bus.advertise<topic::Event>();
  { auto inbox = bus.subscribe<topic::Event>(); }
  for (int i = 0; i < 1000; ++i) EXPECT_TRUE(publisher.publish({}));
}

TEST(LocalBus, SaysWhenThereAreTooManySubscriptions) {
  LocalBus bus;
  std::vector<Subscription<topic::Event>> inboxes;
  for (int i = 0; i < 8; ++i) inboxes.push_back(bus.subscribe<topic::Event>());
  EXPECT_THROW((void)bus.subscribe<topic::Event>(), StartupError);
}

TEST(LocalBus, ReadersOnOtherThreadsSeeWholeSamplesThatNeverGoBack) {
  LocalBus bus;
  constexpr std::uint64_t kLast = 20'000;
  std::vector<std::thread> readers;
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back([reader = bus.reader<topic::Control>()]() mutable {
      std::uint64_t seen = 0;
      while (seen < kLast) {
        const auto sample = reader.newer();
        if (!sample) {
          std::this_thread::yield();
          continue;
        }
        ASSERT_GT(sample->sequence_number, seen);
        seen = sample->sequence_number;
        for (const double value : sample->qd_wish_radps) ASSERT_EQ(value, static_cast<double>(seen));
        ASSERT_EQ(sample->step_time_us, static_cast<double>(seen));
      }
    });
  }
  auto publisher = bus.advertise<topic::Control>();
  topic::Control sample;
  for (std::uint64_t n = 1; n <= kLast; ++n) {
    sample.sequence_number = n;
    sample.qd_wish_radps.fill(static_cast<double>(n));
    sample.step_time_us = static_cast<double>(n);
    publisher.publish(sample);
  }
  for (auto& reader : readers) reader.join();
}

TEST(LocalBus, TwoThreadsMeetingANewInstanceShareOneEntry) {
  for (int round = 0; round < 50; ++round) {
    LocalBus bus;
    std::atomic<bool> go{false};
    std::thread other{[&] {
      while (!go) std::this_thread::yield();
      (void)bus.reader<topic::Mru>("mru1");
    }};
    auto publisher = bus.advertise<topic::Mru>();
    go = true;
    publisher.publish(mru("mru1", 1));
    other.join();
    EXPECT_EQ(bus.reader<topic::Mru>("mru1").newest()->sequence_number, 1u);
  }
}

TEST(LocalBus, RequestsFromSeveralThreadsAllArriveAndRing) {
  LocalBus bus;
  const auto wakeup = std::make_shared<Wakeup>();
  auto inbox = bus.subscribe<topic::ModeRequest>(wakeup);
  constexpr std::uint64_t kEach = 100;
  std::vector<std::thread> requesters;
  for (const char* name : {"a", "b"}) {
    requesters.emplace_back([&bus, name] {
      auto publisher = bus.advertise<topic::ModeRequest>();
      topic::ModeRequest request;
      request.requester = name;
      for (std::uint64_t n = 1; n <= kEach; ++n) {
        request.sequence_number = n;
        EXPECT_TRUE(publisher.publish(request));
      }
    });
  }
  std::uint64_t got = 0;
  while (got < 2 * kEach && wakeup->wait(30s)) {
    while (inbox.next()) ++got;
  }
  EXPECT_EQ(got, 2 * kEach);
  for (auto& requester : requesters) requester.join();
}

TEST(LocalBus, DoesNotLoseASettleWhenNobodyTookTheOtherRequests) {
  LocalBus bus;
  auto inbox = bus.subscribe<topic::ModeRequest>();
  auto publisher = bus.advertise<topic::ModeRequest>();
  topic::ModeRequest request;
  for (int i = 0; i < 10'000; ++i) {  // the last one said is a settle, whatever was lost before
    request.action = i % 3 == 0 ? topic::ModeAction::settle : topic::ModeAction::engage;
    request.sequence_number += 1;
    publisher.publish(request);
  }
  EXPECT_GT(inbox.lost(), 0u);
  topic::ModeAction last{};
  while (const auto taken = inbox.next()) last = taken->action;
  EXPECT_EQ(last, topic::ModeAction::settle);
}

topic::ArmCommand command(const std::string& requester, std::uint64_t number = 0) {
  topic::ArmCommand sample;
  sample.device = "arm";
  sample.requester = requester;
  sample.sequence_number = number;
  return sample;
}

TEST(LocalBus, AStrangerUnderANewNameTakesThePlaceOfTheOneSilentForLongest) {
  LocalBus bus;
  auto ours = bus.advertise<topic::ArmCommand>();
  auto strangers = bus.advertise_for_strangers<topic::ArmCommand>();
  ASSERT_TRUE(ours.publish(command("gateway", 7)));
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(strangers.publish(command(std::to_string(i), 1))) << i;
  EXPECT_TRUE(strangers.publish(command("pilot", 1)));
  EXPECT_TRUE(bus.newest<topic::ArmCommand>("arm", "pilot"));
  EXPECT_TRUE(bus.newest<topic::ArmCommand>("arm", "999"));
  EXPECT_FALSE(bus.newest<topic::ArmCommand>("arm", "900"));
  EXPECT_EQ(bus.newest<topic::ArmCommand>("arm", "gateway")->sequence_number, 7u)
      << "ours is nobody's to take";
  EXPECT_FALSE(strangers.publish(command("gateway", 8)));
}

TEST(LocalBus, AStrangerWhoIsHeededKeepsHisPlace) {
  LocalBus bus;
  auto strangers = bus.advertise_for_strangers<topic::ArmCommand>();
  ASSERT_TRUE(strangers.publish(command("pilot", 1)));
  for (int i = 0; i < 20'000; ++i) {
    ASSERT_TRUE(bus.newest<topic::ArmCommand>("arm", "pilot")) << i;
    ASSERT_TRUE(strangers.publish(command(std::to_string(i), 1))) << i;
  }
  auto reader = bus.reader<topic::ArmCommand>("arm", "19999");
  std::this_thread::sleep_for(500ms);  // nobody has looked for long
  for (int i = 0; i < 40; ++i) ASSERT_TRUE(strangers.publish(command("late " + std::to_string(i), 1))) << i;
  EXPECT_EQ(reader.newest()->requester.view(), "19999") << "a Reader's place is its own for ever";
  EXPECT_TRUE(strangers.publish(command("19999", 2)));
  EXPECT_EQ(reader.newest()->sequence_number, 2u);
}

TEST(LocalBus, NobodyIsTakenForAnotherWhileNamesChange) {
  LocalBus bus;
  std::atomic<bool> over{false};
  std::vector<std::thread> readers;
  for (int i = 0; i < 2; ++i) {
    readers.emplace_back([&] {
      for (int k = 0; !over; k = (k + 1) % 40) {
        const std::string name = std::to_string(k);
        const auto sample = bus.newest<topic::ArmCommand>("arm", name);
        if (!sample) continue;
        ASSERT_EQ(sample->requester.view(), name);
      }
    });
  }
  auto strangers = bus.advertise_for_strangers<topic::ArmCommand>();
  for (int i = 0; i < 50'000; ++i) (void)strangers.publish(command(std::to_string(i * 7 % 40)));
  over = true;
  for (auto& reader : readers) reader.join();
}

TEST(Wakeup, ManyRingsAreOne) {
  Wakeup dut;
  EXPECT_FALSE(dut.wait(0ns));
  for (int i = 0; i < 5; ++i) dut.ring();
  EXPECT_TRUE(dut.wait(0ns));
  EXPECT_FALSE(dut.wait(1ms));
  dut.ring();
  EXPECT_TRUE(dut.wait(10s));
}

}  // namespace
}  // namespace motionlab::bus
