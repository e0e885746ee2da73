// The small value types: Result, Endpoint, Text, LabTime.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <type_traits>

#include "drivers/core/endpoint.hpp"
#include "drivers/core/error.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/text.hpp"
#include "drivers/core/time.hpp"

namespace motionlab {
namespace {

using testing::HasSubstr;

TEST(Result, HoldsAValueOrAFault) {
  const Result<int> good = 5;
  ASSERT_TRUE(good.ok());
  EXPECT_TRUE(static_cast<bool>(good));
  EXPECT_EQ(*good, 5);
  const Result<int> bad = Fault{Reason::too_short, "more bytes please"};
  ASSERT_FALSE(bad.ok());
  EXPECT_EQ(bad.fault().reason, Reason::too_short);
  EXPECT_EQ(bad.fault().text, "more bytes please");
}

TEST(Result, GivesItsValueAway) {
  Result<std::unique_ptr<int>> result = std::make_unique<int>(7);
  const std::unique_ptr<int> taken = std::move(result).value();
  EXPECT_EQ(*taken, 7);
}

TEST(Result, ReachesIntoItsValue) {
  const Result<std::string> result = std::string("abc");
  EXPECT_EQ(result->size(), 3u);
}

TEST(Result, EveryReasonHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    const auto name = to_string(static_cast<Reason>(i));
    EXPECT_FALSE(name.empty());
    EXPECT_NE(name, "?");
    names.insert(name);
  }
  EXPECT_EQ(names.size(), kReasonCount);
  EXPECT_EQ(to_string(Reason::transport), "transport");
  EXPECT_EQ(to_string(Reason::count_), "?");
}

TEST(Endpoint, IsReadAndWrittenAsText) {
  const Endpoint endpoint = Endpoint::parse("192.168.90.13:50013");
  EXPECT_EQ(endpoint.address, 0xc0a85a0du);
  EXPECT_EQ(endpoint.port, 50013);
  EXPECT_EQ(to_string(endpoint), "192.168.90.13:50013");
  EXPECT_EQ(Endpoint::parse_address("127.0.0.1"), 0x7f000001u);
  EXPECT_EQ(Endpoint::parse("0.0.0.0:0"), Endpoint{});
  EXPECT_EQ(to_string(Endpoint::parse("255.255.255.255:65535")), "255.255.255.255:65535");
}

TEST(Endpoint, RefusesWhatIsNoneAndShowsTheForm) {
  for (const char* const text :
       {"", ":", "1.2.3.4", "1.2.3:4", "1.2.3.4:", "1.2.3.4:65536", "256.2.3.4:1", "1.2.3.4:1 ", " 1.2.3.4:1",
        "1.2.3.4.5:1", "-1.2.3.4:1", "host:1", "1.2.3.4:-1", "1..3.4:1"}) {
    try {
      (void)Endpoint::parse(text);
      ADD_FAILURE() << '"' << text << "\" was accepted";
    } catch (const StartupError& error) {
      EXPECT_THAT(error.what(), HasSubstr('"' + std::string(text) + '"'));
      EXPECT_THAT(error.what(), HasSubstr("192.168.90.13:50013"));
    }
  }
  EXPECT_THROW((void)Endpoint::parse_address("1.2.3.4:5"), StartupError);
  EXPECT_THROW((void)Endpoint::parse_address("1.2.3"), StartupError);
}

TEST(Text, KeepsWhatFitsAndCutsTheRest) {
  EXPECT_TRUE(Text<4>{}.empty());
  EXPECT_EQ(Text<4>("abc").view(), "abc");
  EXPECT_EQ(Text<4>("abcd").view(), "abcd");
  EXPECT_EQ(Text<4>(std::string("abcdef")).str(), "abcd");
  Text<4> text("abcd");
  text.assign("x");
  EXPECT_EQ(text.view(), "x") << "nothing of the old text is left";
  EXPECT_EQ(text, Text<4>("x"));
  EXPECT_NE(text, Text<4>("y"));
  static_assert(std::is_trivially_copyable_v<Text<32>>);
}

TEST(LabTime, ConvertsToSecondsAndNanoseconds) {
  EXPECT_DOUBLE_EQ(seconds(1500ms), 1.5);
  EXPECT_EQ(from_seconds(-1.5e-9), Nanoseconds{-2});
  EXPECT_EQ(from_seconds(0.005), 5ms);
  EXPECT_EQ(to_ns(from_ns(123)), 123);
}

TEST(SteppedClock, StandsStillUntilSomebodyMovesIt) {
  SteppedClock clock;
  EXPECT_EQ(clock.now(), LabTime{});
  clock.advance(2ms);
  clock.advance(1ms);
  EXPECT_EQ(clock.now(), LabTime{3ms});
  clock.set(LabTime{1s});
  EXPECT_EQ(clock.now(), LabTime{1s});
}

}  // namespace
}  // namespace motionlab
