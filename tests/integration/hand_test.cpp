// What the user's hand sees of a running gateway: topics, samples, rates and delays, as processes on a real
// bus.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/integration/process_bench.hpp"

namespace motionlab::integration {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;
using testing::IsSupersetOf;
using testing::Not;
using Json = nlohmann::json;

class Hand : public Processes {
 protected:
  struct Answer {
    std::optional<int> exit_code;
    std::string output;  ///< standard error too
  };

  /// Runs one command to its end.
  Answer motionlab(const std::vector<std::string>& words) {
    std::vector<std::string> command{MOTIONLAB_HAND};
    command.insert(command.end(), words.begin(), words.end());
    for (const std::string& common :
         {std::string{"--domain"}, std::to_string(domain_), std::string{"--interface"},
          std::string{"127.0.0.1"}, std::string{"--timeout"}, std::string{"40"}}) {
      command.push_back(common);
    }
    Child child(command, folder_ / "hand.log");
    return {child.exit_code(2 * kPatience), child.output()};
  }

  /// Starts both programs and waits until everything is heard.
  void start_laboratory() {
    gateway_ = start_gateway();
    simulator_ = start_simulator({"--scenario", "calm"});
    const Observer observer(domain_);
    ASSERT_TRUE(eventually([&] { return observer.all_up(); }, kPatience))
        << gateway_->output() << simulator_->output();
  }

  /// The topics that are there, once they are all seen.
  Json topics(std::size_t at_least) {
    Json json;
    for (int i = 0; i < 10 && json["topics"].size() < at_least; ++i) {
      json = Json::parse(motionlab({"topics", "--wait", "4", "--json"}).output);
    }
    return json;
  }

  static const Json* named(const Json& json, const std::string& topic) {
    for (const Json& each : json["topics"]) {
      if (each["topic"] == topic) return &each;
    }
    return nullptr;
  }

  std::unique_ptr<Child> gateway_;
  std::unique_ptr<Child> simulator_;
};

TEST_F(Hand, SeesEveryTopicWithItsWriterAndQuality) {
  start_laboratory();
  const Json json = topics(15);
  std::vector<std::string> names;
  for (const Json& topic : json["topics"]) names.push_back(topic["topic"]);
  EXPECT_THAT(
      names, IsSupersetOf({"motionlab/mru", "motionlab/bodies", "motionlab/arm_state",
                           "motionlab/arm_command", "motionlab/winch_state", "motionlab/winch_command",
                           "motionlab/estimate", "motionlab/control", "motionlab/reference", "motionlab/mode",
                           "motionlab/mode_request", "motionlab/health", "motionlab/event", "truth/world"}));
  for (const Json& topic : json["topics"]) EXPECT_EQ(topic["known"], true) << topic;
  const Json* const mode = named(json, "motionlab/mode");
  ASSERT_NE(mode, nullptr);
  ASSERT_EQ((*mode)["writers"].size(), 1u);
  EXPECT_EQ((*mode)["writers"][0]["reliability"], "reliable");
  EXPECT_EQ((*mode)["writers"][0]["durability"], "transient_local");
  EXPECT_NE((*mode)["writers"][0]["process"], "");
  const Json* const truth = named(json, "truth/world");
  ASSERT_NE(truth, nullptr);
  ASSERT_EQ((*truth)["writers"].size(), 1u);
  EXPECT_EQ((*truth)["writers"][0]["partitions"], Json::array({"truth"}));
  EXPECT_NE((*truth)["writers"][0]["process"], (*mode)["writers"][0]["process"]);
}

TEST_F(Hand, EchoesBestEffortKeptAndTruth) {
  start_laboratory();
  const Answer mru = motionlab({"echo", "mru", "--device", "mru2", "--json", "--count", "3"});
  ASSERT_EQ(mru.exit_code, 0) << mru.output;
  std::istringstream lines{mru.output};
  std::uint64_t before = 0;
  for (std::string line; std::getline(lines, line);) {
    const Json sample = Json::parse(line);
    EXPECT_EQ(sample["device"], "mru2");
    EXPECT_GT(sample["sequence_number"].get<std::uint64_t>(), before);
    before = sample["sequence_number"];
    EXPECT_GE(sample["t_received_ns"].get<std::int64_t>(), sample["t_measured_ns"].get<std::int64_t>());
  }
  EXPECT_GT(before, 0u);
  const Answer mode = motionlab({"echo", "mode", "--once"});  // written long before anybody asked
  EXPECT_EQ(mode.exit_code, 0) << mode.output;
  EXPECT_THAT(mode.output, ContainsRegex("\nauthority +(observe|shadow|limited|full)\n"));
  const Answer truth = motionlab({"echo", "truth/world", "--once", "--csv", "--field", "p_world_load_m"});
  EXPECT_EQ(truth.exit_code, 0) << truth.output;
  EXPECT_THAT(truth.output,
              ContainsRegex("^p_world_load_m\\[0\\],p_world_load_m\\[1\\],p_world_load_m\\[2\\]\n"
                            "-?[0-9.e-]+,-?[0-9.e-]+,-?[0-9.e-]+\n$"));
}

TEST_F(Hand, MeasuresRatesByTheSamplesOwnNumbersAndStamps) {
  start_laboratory();
  const Answer mru = motionlab({"rate", "mru", "--window", "3", "--json"});
  ASSERT_EQ(mru.exit_code, 0) << mru.output;
  const Json json = Json::parse(mru.output);
  EXPECT_EQ(json["stamp"], "t_measured_ns");
  ASSERT_EQ(json["instances"].size(), 2u) << mru.output;
  for (const Json& unit : json["instances"]) {
    // Two hundred a second, less what a busy machine makes the gateway's socket drop.
    EXPECT_GT(unit["made_hz"].get<double>(), 20) << mru.output;
    EXPECT_LT(unit["made_hz"].get<double>(), 250) << mru.output;
    EXPECT_GT(unit["heard"].get<int>(), 10);
  }
  const Answer control = motionlab({"rate", "control", "--window", "3"});
  EXPECT_EQ(control.exit_code, 0) << control.output;
  EXPECT_THAT(control.output, ContainsRegex("motionlab/control: [0-9]+ samples, by t_snapshot_ns\n"));
  EXPECT_THAT(control.output, HasSubstr("(made at "));
  const Answer slow = motionlab({"rate", "health", "--window", "2", "--at-least", "5000"});
  EXPECT_EQ(slow.exit_code, 1) << slow.output;
}

TEST_F(Hand, MeasuresTheDelayOfEveryHop) {
  start_laboratory();
  const Answer delay = motionlab({"delay", "--window", "3", "--json"});
  ASSERT_EQ(delay.exit_code, 0) << delay.output;
  const Json json = Json::parse(delay.output);
  EXPECT_EQ(json["other_hosts"].size(), 0u) << "all on this host";
  const auto samples = [&json](const std::string& hop, const std::string& of) {
    std::size_t count = 0;
    for (const Json& each : json["hops"]) {
      if (each["hop"] == hop && each["of"] == of) count += each["samples"].get<std::size_t>();
    }
    return count;
  };
  for (const char* const device : {"mru1", "mru2", "qualisys/load", "arm", "winch"}) {
    EXPECT_GT(samples("measured -> received", device), 0u) << device << delay.output;
  }
  for (const char* const source : {"mru", "bodies", "arm", "winch"}) {
    EXPECT_GT(samples("received -> control step", source), 0u) << source << delay.output;
    EXPECT_GT(samples("measured -> control step", source), 0u) << source << delay.output;
  }
  for (const char* const topic : {"motionlab/mru", "motionlab/estimate", "motionlab/control"}) {
    EXPECT_GT(samples("last stamp -> on DDS", topic), 0u) << topic << delay.output;
    EXPECT_GT(samples("on DDS -> heard here", topic), 0u) << topic << delay.output;
  }
}

TEST_F(Hand, TellsTheGatewayWhereTheLoadShallBe) {
  start_laboratory();
  const Answer answer = motionlab({"reference", "0.85", "-0.3", "3.9"});
  EXPECT_EQ(answer.exit_code, 0) << answer.output;
  EXPECT_THAT(answer.output, HasSubstr("told: 0.8500 -0.3000 3.9000 m in world; the gateway is "));
  const Answer load = motionlab({"reference"});
  EXPECT_EQ(load.exit_code, 0) << load.output;
  EXPECT_THAT(load.output, ContainsRegex("load +[0-9.-]+ [0-9.-]+ [0-9.-]+ m in world, estimated\n"));
}

#ifdef MOTIONLAB_CYCLONE_STRANGER
TEST_F(Hand, SeesAStrangersTopicsAndIsNotHarmedByThem) {
  ::setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/>"
           "</Interfaces></General></Domain></CycloneDDS>",
           1);
  Child stranger({MOTIONLAB_CYCLONE_STRANGER, std::to_string(domain_)}, folder_ / "stranger.log");
  const Json json = topics(2);
  const Json* const fish = named(json, "stranger/fish");
  ASSERT_NE(fish, nullptr) << json;
  EXPECT_EQ((*fish)["type"], "stranger::Fish");
  EXPECT_EQ((*fish)["known"], false);
  ASSERT_EQ((*fish)["writers"].size(), 1u);
  EXPECT_EQ((*fish)["writers"][0]["reliability"], "best_effort");
  EXPECT_EQ((*fish)["writers"][0]["participant"], "stranger");
  EXPECT_NE((*fish)["writers"][0]["host"], "");

  const Answer unknown = motionlab({"echo", "stranger/fish"});
  EXPECT_EQ(unknown.exit_code, 64);
  EXPECT_THAT(unknown.output, HasSubstr("its type stranger::Fish is not known"));

  // A type of the house below a foreign name is understood; the name of its device is an attack on the
  // terminal.
  const Answer mru = motionlab({"echo", "stranger/mru", "--once"});
  EXPECT_EQ(mru.exit_code, 0) << mru.output;
  EXPECT_THAT(mru.output, ContainsRegex("device +\\\\x1b\\[2Jevil\n"));
  EXPECT_THAT(mru.output, Not(HasSubstr("\033")));

  // Its own numbers and stamps say exactly a hundred a second, of which every tenth was left out; when it
  // writes does not matter.
  const Answer rate = motionlab({"rate", "stranger/mru", "--count", "100", "--window", "60", "--json"});
  ASSERT_EQ(rate.exit_code, 0) << rate.output;
  const Json measured = Json::parse(rate.output);
  ASSERT_EQ(measured["instances"].size(), 1u);
  const Json& one = measured["instances"][0];
  EXPECT_NEAR(one["made_hz"].get<double>(), 100, 1e-6);
  EXPECT_EQ(one["period_median_ms"], 10.0);
  EXPECT_NEAR(one["jitter_us"]["max"].get<double>(), 0, 1e-6);
  EXPECT_GE(one["missing"].get<int>(), 10);
  if (measured["lost_on_dds"] == 0) {
    EXPECT_LE(one["missing"].get<int>(), 12);
  }
  EXPECT_TRUE(stranger.running()) << stranger.output();
}
#endif

}  // namespace
}  // namespace motionlab::integration
