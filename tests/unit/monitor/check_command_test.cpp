#include "gateway/monitor/check_command.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "drivers/core/asio_network.hpp"
#include "drivers/core/error.hpp"
#include "gateway/monitor/command_line.hpp"
#include "tests/mru/mru_golden.hpp"

namespace motionlab::monitor {
namespace {

using testing::HasSubstr;
using Json = nlohmann::ordered_json;

constexpr Endpoint kUnit{0x7F000001, 50013};

TEST(CheckMru, KnowsEveryFormatAndDecodesASample) {
  for (const mru::Golden& golden : mru::all_golden()) {
    MruStream stream{golden.layout.variables};
    for (int i = 0; i < 25; ++i) stream.take(golden.bytes, kUnit, from_ns(5'000'000 * i));
    EXPECT_EQ(stream.detector().format(), golden.format);
    EXPECT_NEAR(stream.rate_hz(), 200.0, 1e-9);
    EXPECT_FALSE(stream.fault());
    const std::string_view text = as_text(golden.bytes);
    const bool attitude = !text.starts_with("$PSXN,20") && !text.starts_with("$PSXN,24");
    EXPECT_EQ(stream.newest().has_value(), attitude);
    EXPECT_EQ(stream.checksums().good, stream.checksums().decoded);
  }
}

TEST(CheckMru, CountsWhichChecksumRuleMatches) {
  MruStream stream{mru::VariableList::laboratory()};
  for (int i = 0; i < 10; ++i) stream.take(mru::kLaboratoryFrame, kUnit, from_ns(5'000'000 * i));
  EXPECT_EQ(stream.checksums().decoded, 8u) << "from the third on, when the format is known";
  EXPECT_EQ(stream.checksums().ones_complement, 8u);
  EXPECT_EQ(stream.checksums().sum8, 0u);
}

TEST(CheckMru, NeedsTheListOfAnotherMrubin) {
  MruStream laboratory{mru::VariableList::laboratory()};
  const std::array list{mru::Variable::roll, mru::Variable::pitch, mru::Variable::yaw,
                        mru::Variable::pos_cg_d};
  MruStream told{mru::VariableList::of(list).value()};
  for (int i = 0; i < 5; ++i) {
    laboratory.take(mru::kPublished, kUnit, from_ns(5'000'000 * i));
    told.take(mru::kPublished, kUnit, from_ns(5'000'000 * i));
  }
  EXPECT_EQ(laboratory.detector().format(), mru::Format::mrubin);
  EXPECT_FALSE(laboratory.newest());
  EXPECT_TRUE(laboratory.fault());
  ASSERT_TRUE(told.newest());
  EXPECT_NEAR(told.newest()->euler_heading_mru_rad[0], 0.051, 1e-7);
}

/// The command on a real port, with somebody who sends to it.
class CheckMruOnAPort : public testing::Test {
 protected:
  struct Answer {
    int exit_code;
    std::string out, err;
  };

  CheckMruOnAPort() {
    boost::asio::io_context io;
    AsioNetwork network{io, clock_};
    port_ = network.datagram(Endpoint::parse("127.0.0.1:0"))->local().port;
  }

  Answer check(Bytes datagram, std::vector<std::string> options, bool send = true) {
    std::atomic<bool> interrupted{false}, done{false};
    std::thread sender([&] {
      boost::asio::io_context io;
      AsioNetwork network{io, clock_};
      const auto socket = network.datagram(Endpoint::parse("127.0.0.1:0"));
      while (send && !done) {
        (void)socket->send({0x7F000001, port_}, datagram);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    });
    std::vector<std::string> arguments{"motionlab", "check", "mru", "--listen", std::to_string(port_)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    std::ostringstream out, err;
    const int code =
        run_command_line(static_cast<int>(argv.size()), argv.data(), {out, err, false, interrupted});
    done = true;
    sender.join();
    return {code, out.str(), err.str()};
  }

  RealClock clock_;
  std::uint16_t port_ = 0;
};

TEST_F(CheckMruOnAPort, SaysFormatTokenVariablesAndOneSample) {
  const Answer answer = check(mru::kLaboratoryFrame, {"--seconds", "1"});
  EXPECT_EQ(answer.exit_code, kExitGood) << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("mrubin, 100 bytes, token 11, 24 variables"));
  EXPECT_THAT(answer.out,
              HasSubstr("stable: roll 1.146 deg, pitch -1.719 deg, yaw 28.648 deg, heave -0.350 m"));
}

TEST_F(CheckMruOnAPort, AnswersInJson) {
  const Answer answer = check(mru::kBin23Frame, {"--seconds", "1", "--json"});
  EXPECT_EQ(answer.exit_code, kExitGood) << answer.err;
  const Json json = Json::parse(answer.out);
  EXPECT_EQ(json["format"], "bin23");
  EXPECT_EQ(json["bytes"], 44);
  EXPECT_NEAR(json["sample"]["p_heading_origin_m"][2].get<double>(), 0.25, 1e-9);
  EXPECT_TRUE(json["sample"]["p_heading_origin_m"][0].is_null());
}

TEST_F(CheckMruOnAPort, TakesTheVariablesOfAnotherList) {
  EXPECT_EQ(check(mru::kPublished, {"--seconds", "1"}).exit_code, kExitWrong);
  const Answer answer = check(mru::kPublished, {"--seconds", "1", "--variables", "63,64,65,276"});
  EXPECT_EQ(answer.exit_code, kExitGood) << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("heave 1.234 m"));
}

TEST_F(CheckMruOnAPort, SaysThatNobodySends) {
  const Answer answer = check({}, {"--seconds", "0.1"}, false);
  EXPECT_EQ(answer.exit_code, kExitNobody);
  EXPECT_THAT(answer.err, HasSubstr("nothing has come"));
}

TEST_F(CheckMruOnAPort, SaysThatItIsNoKnownFormat) {
  const Answer answer = check(as_bytes("hello"), {"--seconds", "1"});
  EXPECT_EQ(answer.exit_code, kExitWrong);
  EXPECT_THAT(answer.err, HasSubstr("no known format"));
}

TEST_F(CheckMruOnAPort, SaysThatThePortIsTaken) {
  boost::asio::io_context io;
  AsioNetwork network{io, clock_};
  const auto taken = network.datagram({0, port_});
  const Answer answer = check({}, {"--seconds", "0.1"}, false);
  EXPECT_EQ(answer.exit_code, kExitUsage);
  EXPECT_THAT(answer.err, HasSubstr(std::to_string(port_)));
}

}  // namespace
}  // namespace motionlab::monitor
