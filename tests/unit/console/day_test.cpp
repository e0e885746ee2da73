// A day of everything that a laboratory says, in fast-forward: what the console remembers does not grow.
#include <gtest/gtest.h>
#include <malloc.h>

#include <array>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "gateway/console/board.hpp"
#include "gateway/console/outbox.hpp"
#include "idl/topics.hpp"

namespace motionlab::console {
namespace {

constexpr int kDay_s = 24 * 3600, kSamplesPerSecond = 20;
constexpr std::size_t kSampleBytes = 200;
constexpr std::array kDevices{"mru1", "mru2", "qualisys", "arm", "winch"};

/// What the heap has given to this program.
std::size_t allocated() {
  return mallinfo2().uordblks;
}

/// A client that wants the newest thirty times a second, one that wants all, and one that never reads.
struct Clients {
  Outbox page{1 << 20, true}, foxglove{1 << 20, false}, asleep{1 << 20, false};

  void offer(const Parcel& parcel) {
    for (Outbox* const outbox : {&page, &foxglove, &asleep}) outbox->push(parcel);
  }
  void read() {
    for (Outbox* const outbox : {&page, &foxglove}) {
      while (outbox->pop()) continue;
    }
    (void)asleep.newly_missed();
  }
};

TEST(ADayOfTheConsole, RemembersNoMoreInTheEveningThanInTheMorning) {
  Board board;
  Clients clients;
  std::size_t in_the_morning = 0;
  std::uint64_t samples = 0;
  for (int second = 0; second < kDay_s; ++second) {
    const LabTime now = LabTime{} + std::chrono::seconds{second};
    (void)board.look(now, std::vector<bool>(bus::kTopicList.size(), true));
    const auto say = [&](std::size_t topic, const std::string& instance) {
      clients.offer(
          board.accept(topic, instance, now, std::make_shared<const std::vector<std::byte>>(kSampleBytes)));
      ++samples;
    };
    for (int i = 0; i < kSamplesPerSecond; ++i) {
      for (const char* const device : kDevices) say(bus::topic_index<topic::Health>(), device);
      say(bus::topic_index<topic::Estimate>(), "");
      say(bus::topic_index<topic::Control>(), "");
      clients.read();
    }
    say(bus::topic_index<topic::Event>(), "");
    say(bus::topic_index<topic::Mode>(), "");
    say(bus::topic_index<topic::Mru>(),
        "stranger" + std::to_string(second));  // a name of his own each second
    if (second == kDay_s / 24) in_the_morning = allocated();
  }
  EXPECT_GT(samples, 12'000'000U);
  EXPECT_LE(allocated(), in_the_morning + 64 * 1024);
}

}  // namespace
}  // namespace motionlab::console
