#include "gateway/monitor/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "drivers/core/real_clock.hpp"
#include "idl/topics.hpp"
#include "tests/support/own_domain.hpp"

namespace motionlab::monitor {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using topic::ModeAction;
using topic::ModeState;
using Json = nlohmann::ordered_json;

/// A domain that no other test of this host uses at the same time, most likely.
int own_domain() {
  return test::own_domain();
}

/// What a command said and how it ended.
struct Answer {
  int exit_code;
  std::string out;
  std::string err;
};

class CommandLine : public testing::Test {
 protected:
  Answer motionlab(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {"motionlab", "--domain", std::to_string(own_domain()), "--interface", "127.0.0.1"});
    return bare(arguments);
  }

  Answer bare(const std::vector<std::string>& arguments) {
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    std::ostringstream out, err;
    const int code =
        run_command_line(static_cast<int>(argv.size()), argv.data(), {out, err, false, interrupted_});
    return {code, out.str(), err.str()};
  }

  std::atomic<bool> interrupted_{false};
};

/// The side of the gateway and of the simulator: publishes mode, health and truth, answers requests.
class FakeGateway {
 public:
  explicit FakeGateway(ModeState state, const char* code = "", const char* reason = "")
      : dds_{config(), local_},
        requests_{local_.subscribe<topic::ModeRequest>()},
        modes_{local_.advertise<topic::Mode>()},
        healths_{local_.advertise<topic::Health>()} {
    dds_.out<topic::Mode>();
    dds_.out<topic::Health>();
    dds_.in<topic::ModeRequest>();
    dds_.out<topic::TruthWorld>();
    dds_.out<topic::Control>();
    dds_.out<topic::Estimate>();
    dds_.start();
    enter(state, code, reason);
    for (const char* device : {"winch", "mru1", "arm"}) {
      topic::Health health;
      health.device = device;
      health.link = topic::LinkState::up;
      health.rate_hz = 200;
      health.stale_after_s = 0.03;
      devices_.push_back(health);
    }
  }

  ~FakeGateway() { stop(); }

  void start() {
    thread_ = std::thread{[this] {
      while (!stopping_) {
        step();
        std::this_thread::sleep_for(5ms);
      }
    }};
  }
  void stop() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

  /// Set these before `start`.
  topic::Health& device(std::size_t i) { return devices_[i]; }
  bool has_truth = false;
  bool has_estimate = false;
  std::optional<Nanoseconds> ready_after;
  std::function<void(FakeGateway&, const topic::ModeRequest&)> answer = [](FakeGateway&,
                                                                           const topic::ModeRequest&) {};

  void enter(ModeState state, std::string_view code = "", std::string_view reason = "") {
    mode_.state = state;
    mode_.fault_latched = state == ModeState::fault;
    mode_.fault_code = code;
    mode_.reason = reason;
    mode_.t_changed_ns = to_ns(clock_.now());
    ++mode_.sequence_number;
    modes_.publish(mode_);
  }
  topic::Mode& mode() { return mode_; }

  /// Every request that came, after `stop`.
  [[nodiscard]] const std::vector<topic::ModeRequest>& heard() const { return heard_; }

 private:
  static bus::DdsConfig config() {
    bus::DdsConfig config;
    config.domain = own_domain();
    config.interface_whitelist = {"127.0.0.1"};
    config.participant = "fake gateway";
    config.join_truth = true;
    return config;
  }

  void step() {
    while (const auto request = requests_.next()) {
      heard_.push_back(*request);
      answer(*this, *request);
    }
    const LabTime now = clock_.now();
    if (ready_after && now - from_ns(mode_.t_changed_ns) >= *ready_after) {
      ready_after.reset();
      enter(ModeState::ready);
    }
    for (topic::Health& health : devices_) {
      health.t_ns = to_ns(now);
      healths_.publish(health);
    }
    if (has_truth) {
      topic::TruthWorld truth;
      truth.t_ns = to_ns(now);
      truth.swing_rad = {0.001, 0};
      truth.twin_swing_rad = {0.1, 0};
      truth.p_world_load_m = {0.847625, -0.407825, 3.929269};
      truths_.publish(truth);
    }
    if (has_estimate) {
      topic::Estimate estimate;
      estimate.t_estimated_ns = to_ns(now);
      estimate.valid = true;
      estimate.platform_tracked = true;
      estimate.swing_rad = {0.002, 0};
      estimates_.publish(estimate);
    }
    topic::Control control;
    control.t_snapshot_ns = to_ns(now);
    control.following = true;
    control.age_mru_s = 0.0025;
    controls_.publish(control);
  }

  RealClock clock_;
  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Subscription<topic::ModeRequest> requests_;
  bus::Publisher<topic::Mode> modes_;
  bus::Publisher<topic::Health> healths_;
  bus::Publisher<topic::TruthWorld> truths_ = local_.advertise<topic::TruthWorld>();
  bus::Publisher<topic::Estimate> estimates_ = local_.advertise<topic::Estimate>();
  bus::Publisher<topic::Control> controls_ = local_.advertise<topic::Control>();
  topic::Mode mode_;
  std::vector<topic::Health> devices_;
  std::vector<topic::ModeRequest> heard_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

TEST_F(CommandLine, ShowsExamplesWithHelp) {
  const Answer run = bare({"motionlab", "--help"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.out, HasSubstr("motionlab engage --wait 30"));
}

TEST_F(CommandLine, DoesNotKnowWhatDoesNotWorkYet) {
  for (const char* word : {"teleport", "dance"}) {
    const Answer run = bare({"motionlab", word});
    EXPECT_EQ(run.exit_code, 64) << word;
    EXPECT_THAT(run.err, HasSubstr(word));
    EXPECT_THAT(run.out, IsEmpty());
  }
  EXPECT_EQ(bare({"motionlab"}).exit_code, 64);
  EXPECT_EQ(bare({"motionlab", "status", "--nonsense"}).exit_code, 64);
  EXPECT_EQ(bare({"motionlab", "settle", "--wait", "3"}).exit_code, 64);
  EXPECT_EQ(bare({"motionlab", "status", "--domain", "300"}).exit_code, 64);
}

TEST_F(CommandLine, NamesTheInterfacesWhenTheGivenOneDoesNotExist) {
  const Answer run = bare({"motionlab", "status", "--interface", "203.0.113.7"});
  EXPECT_EQ(run.exit_code, 64);
  EXPECT_THAT(run.err, HasSubstr("203.0.113.7"));
  EXPECT_THAT(run.err, HasSubstr("127.0.0.1"));
}

TEST_F(CommandLine, SaysWhereItLookedWhenNobodyAnswers) {
  const std::string domain = "domain " + std::to_string(own_domain());
  for (const char* word : {"status", "engage", "settle", "reset", "score", "delay"}) {
    const Answer run = motionlab({word, "--timeout", "0.2"});
    EXPECT_EQ(run.exit_code, 2) << word;
    EXPECT_THAT(run.err, HasSubstr("nobody answers on DDS " + domain + ", interface 127.0.0.1"));
    EXPECT_THAT(run.out, IsEmpty());
  }
}

TEST_F(CommandLine, StopsWaitingWhenInterrupted) {
  interrupted_ = true;
  for (const char* word : {"status", "engage", "settle", "reset", "score", "delay"}) {
    EXPECT_EQ(motionlab({word, "--timeout", "600"}).exit_code, 130) << word;
  }
}

TEST_F(CommandLine, ShowsTheStatusOfAHealthyGateway) {
  FakeGateway gateway{ModeState::ready, "", "everything is fresh and healthy"};
  gateway.start();
  const Answer run = motionlab({"status", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("gateway    ready, authority observe: everything is fresh and healthy\n"));
  EXPECT_THAT(run.out, testing::ContainsRegex("arm .*up.*\nmru1 .*up.*\nwinch .*up.*200.0 Hz"));
}

TEST_F(CommandLine, ShowsTheStatusAsJson) {
  FakeGateway gateway{ModeState::ready};
  gateway.start();
  const Json json = Json::parse(motionlab({"status", "--timeout", "60", "--json"}).out);
  EXPECT_EQ(json["healthy"], true);
  EXPECT_EQ(json["mode"]["state"], "ready");
  ASSERT_EQ(json["devices"].size(), 3u);
  EXPECT_EQ(json["devices"][0]["device"], "arm");
  EXPECT_EQ(json["devices"][0]["link"], "up");
  EXPECT_EQ(json["devices"][0]["rejected"].size(), 11u);
}

TEST_F(CommandLine, EndsTheStatusWithOneWhenADeviceIsStale) {
  FakeGateway gateway{ModeState::settled};
  gateway.device(1).link = topic::LinkState::stale;
  gateway.device(1).advice = "see whether the unit has power";
  gateway.start();
  const Answer run = motionlab({"status", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, HasSubstr("see whether the unit has power"));
}

TEST_F(CommandLine, EndsTheStatusWithOneWhenAFaultIsLatched) {
  FakeGateway gateway{ModeState::fault, "mru1_stale", "mru1 was silent for too long"};
  gateway.start();
  const Answer run = motionlab({"status", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.out, HasSubstr("fault, authority observe, mru1_stale: mru1 was silent for too long"));
}

TEST_F(CommandLine, EngagesOnceAndInTheNameOfTheUser) {
  FakeGateway gateway{ModeState::ready};
  gateway.answer = [](FakeGateway& self, const topic::ModeRequest& request) {
    if (request.action != ModeAction::engage || self.mode().state != ModeState::ready) return;
    self.mode().owner = request.requester;
    self.enter(ModeState::engaged);
  };
  gateway.start();
  const Answer run = motionlab({"engage", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "engaged\n");
  gateway.stop();
  ASSERT_FALSE(gateway.heard().empty());
  EXPECT_EQ(gateway.heard()[0].requester.view(), requester_name().substr(0, 32));
  for (const topic::ModeRequest& request : gateway.heard()) {
    EXPECT_EQ(request.sequence_number, gateway.heard()[0].sequence_number);
  }
}

TEST_F(CommandLine, SaysWhyTheGatewayDoesNotEngage) {
  FakeGateway gateway{ModeState::settled};
  gateway.answer = [](FakeGateway& self, const topic::ModeRequest&) {
    self.enter(ModeState::settled, "cameras_lost", "the cameras do not see the load");
  };
  gateway.start();
  const Answer run = motionlab({"engage", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "engage: refused (cameras_lost): the cameras do not see the load\n");
}

TEST_F(CommandLine, WaitsForReadyBeforeItAsksToEngage) {
  FakeGateway gateway{ModeState::settled, "mru1_stale", "mru1 is not there yet"};
  gateway.answer = [](FakeGateway& self, const topic::ModeRequest& request) {
    if (self.mode().state == ModeState::ready) {
      self.mode().owner = request.requester;
      self.enter(ModeState::engaged);
    } else {
      ADD_FAILURE() << "asked before the gateway was ready";
    }
  };
  gateway.ready_after = 600ms;
  gateway.start();
  const Answer run = motionlab({"engage", "--wait", "600", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(CommandLine, EngagesNoEarlierThanItIsTold) {
  FakeGateway gateway{ModeState::ready};
  gateway.answer = [](FakeGateway& self, const topic::ModeRequest& request) {
    if (self.mode().state != ModeState::ready) return;
    self.mode().owner = request.requester;
    self.enter(ModeState::engaged);
  };
  gateway.start();
  const std::int64_t at_ns = to_ns(RealClock{}.now() + 2s);
  const Answer run = motionlab({"engage", "--at-ns", std::to_string(at_ns), "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  gateway.stop();
  ASSERT_FALSE(gateway.heard().empty());
  EXPECT_GE(gateway.heard()[0].t_created_ns, at_ns);
  EXPECT_GE(gateway.mode().t_changed_ns, at_ns);
}

TEST_F(CommandLine, GivesUpOnAGatewayThatDoesNotReact) {
  FakeGateway gateway{ModeState::ready, "", "engage when you like"};
  gateway.start();
  const Answer run = motionlab({"engage", "--timeout", "3", "--json"});
  EXPECT_EQ(run.exit_code, 1);
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["granted"], false);
  EXPECT_EQ(json["sentence"], "the gateway stays ready: engage when you like");
  EXPECT_EQ(json["mode"]["state"], "ready");
  gateway.stop();
  EXPECT_GE(gateway.heard().size(), 2u);  // it asked again
}

TEST_F(CommandLine, SettlesAndWaitsUntilEverythingRests) {
  FakeGateway gateway{ModeState::engaged};
  int asked = 0;
  gateway.answer = [&asked](FakeGateway& self, const topic::ModeRequest& request) {
    if (request.action != ModeAction::settle) return;
    if (++asked == 1) self.enter(ModeState::stopping);
    if (asked == 4) self.enter(ModeState::settled);
  };
  gateway.start();
  const Answer run = motionlab({"settle", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "settled: nothing is commanded\n");
  gateway.stop();
  EXPECT_GE(asked, 4);
}

TEST_F(CommandLine, GoesOnAskingForAResetWhileTheArmStillBrakes) {
  FakeGateway gateway{ModeState::fault, "arm_stale", "the arm was silent"};
  int asked = 0;
  gateway.answer = [&asked](FakeGateway& self, const topic::ModeRequest& request) {
    if (request.action != ModeAction::reset) return;
    if (++asked < 3) {
      self.enter(ModeState::fault, "arm_stale", "a fault is reset only at rest; ask again");
    } else {
      self.enter(ModeState::settled);
    }
  };
  gateway.start();
  const Answer run = motionlab({"reset", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "the fault is reset\n");
}

TEST_F(CommandLine, SaysWhyAFaultStays) {
  FakeGateway gateway{ModeState::fault, "arm_stale", "the arm is silent"};
  gateway.answer = [](FakeGateway& self, const topic::ModeRequest&) {
    self.enter(ModeState::fault, "arm_stale", "the arm is still silent");
  };
  gateway.start();
  const Answer run = motionlab({"reset", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "reset: the fault stays (arm_stale): the arm is still silent\n");
}

TEST_F(CommandLine, OffersTheNearestCommand) {
  EXPECT_THAT(bare({"motionlab", "statsu"}).err, HasSubstr("there is no statsu; do you mean status?"));
}

TEST_F(CommandLine, HasExamplesForEveryCommand) {
  for (const char* word : {"status", "topics", "echo", "rate", "delay", "engage", "settle", "reset",
                           "authority", "reference", "score", "completion"}) {
    const Answer run = bare({"motionlab", word, "--help"});
    EXPECT_EQ(run.exit_code, 0) << word;
    EXPECT_THAT(run.out,
                testing::ContainsRegex("Examples?:\n  (source <\\()?motionlab " + std::string{word}));
  }
}

TEST_F(CommandLine, GrantsAnAuthorityWhenTheModeShowsIt) {
  FakeGateway gateway{ModeState::ready};
  gateway.answer = [](FakeGateway& self, const topic::ModeRequest& request) {
    if (request.action != ModeAction::authority) return;
    self.mode().authority = request.authority;
    self.enter(ModeState::ready);
  };
  gateway.start();
  const Answer run = motionlab({"authority", "limited", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(run.out, "authority is limited\n");
  EXPECT_EQ(bare({"motionlab", "authority", "some"}).exit_code, 64);
  EXPECT_EQ(bare({"motionlab", "authority"}).exit_code, 64);
}

TEST_F(CommandLine, SaysWhyAnAuthorityIsRefused) {
  FakeGateway gateway{ModeState::engaged};
  gateway.answer = [](FakeGateway& self, const topic::ModeRequest&) {
    self.enter(ModeState::engaged, "authority_refused", "settle first");
  };
  gateway.start();
  const Answer run = motionlab({"authority", "full", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(run.err, "authority: refused (authority_refused): settle first\n");
}

TEST_F(CommandLine, LetsTheGatewayWriteNoControlCharacters) {
  FakeGateway gateway{ModeState::ready, "", "\033[2Jall is well"};
  gateway.start();
  const Answer run = motionlab({"status", "--timeout", "60"});
  EXPECT_THAT(run.out, HasSubstr("\\x1b[2Jall is well"));
}

TEST_F(CommandLine, EchoesAKeptSampleAndSelectedFields) {
  FakeGateway gateway{ModeState::ready, "", "all is well"};
  gateway.start();
  const Answer text = motionlab({"echo", "mode", "--once", "--field", "reason", "--timeout", "60"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_EQ(text.out, "reason all is well\n");
  const Answer block = motionlab({"echo", "motionlab/mode", "--once", "--timeout", "60"});
  EXPECT_THAT(block.out, testing::ContainsRegex("\nstate +ready\n"));
}

TEST_F(CommandLine, EchoesJsonLinesAndCsvOfOneDevice) {
  FakeGateway gateway{ModeState::ready};
  gateway.start();
  const Answer lines =
      motionlab({"echo", "health", "--json", "--count", "3", "--device", "arm", "--timeout", "60"});
  EXPECT_EQ(lines.exit_code, 0) << lines.err;
  std::istringstream in{lines.out};
  int count = 0;
  for (std::string line; std::getline(in, line); ++count) EXPECT_EQ(Json::parse(line)["device"], "arm");
  EXPECT_EQ(count, 3);
  const Answer csv = motionlab({"echo", "health", "--csv", "--count", "2", "--device", "arm", "--field",
                                "device", "--field", "rejected[2]", "--timeout", "60"});
  EXPECT_EQ(csv.out, "device,rejected[2]\narm,0\narm,0\n");
}

TEST_F(CommandLine, EchoNamesWhatDoesNotExistAndWhatIsNear) {
  const Answer field = motionlab({"echo", "estimate", "--field", "swing_rd"});
  EXPECT_EQ(field.exit_code, 64);
  EXPECT_THAT(field.err, HasSubstr("no field swing_rd in motionlab/estimate; do you mean swing_rad?"));
  const Answer topic = motionlab({"echo", "estimat", "--timeout", "0.1"});
  EXPECT_EQ(topic.exit_code, 64);
  EXPECT_THAT(topic.err, HasSubstr("no topic estimat; do you mean motionlab/estimate?"));
  EXPECT_EQ(motionlab({"echo", "mode", "--device", "arm"}).exit_code, 64);
  EXPECT_EQ(motionlab({"echo", "mode", "--json", "--csv"}).exit_code, 64);
  EXPECT_EQ(motionlab({"echo", "mode", "--once", "--count", "2"}).exit_code, 64);
  EXPECT_EQ(motionlab({"echo"}).exit_code, 64);
}

TEST_F(CommandLine, EndsWithTwoWhenNothingIsHeardAndSaysWhetherAnybodyWrites) {
  for (const char* word : {"echo", "rate"}) {
    const Answer nobody = motionlab({word, "mru", "--timeout", "0.2"});
    EXPECT_EQ(nobody.exit_code, 2) << word;
    EXPECT_THAT(nobody.err, HasSubstr("nobody writes motionlab/mru"));
    EXPECT_THAT(nobody.out, IsEmpty());
  }
  FakeGateway gateway{ModeState::ready};  // has a writer of the truth, which says nothing
  gateway.start();
  for (const char* const patience : {"3.0", "15.0", "60.0"}) {  // until the writer is discovered
    const Answer silent = motionlab({"echo", "truth/world", "--timeout", patience});
    EXPECT_EQ(silent.exit_code, 2);
    if (silent.err.find("nobody writes") != std::string::npos) continue;
    EXPECT_THAT(silent.err, HasSubstr("fake gateway on"));
    EXPECT_THAT(silent.err, HasSubstr("has a writer of truth/world, but it said nothing within " +
                                      std::string{patience} + " s"));
    return;
  }
  FAIL() << "the writer was never discovered";
}

TEST_F(CommandLine, MeasuresARateAndJudgesIt) {
  FakeGateway gateway{ModeState::ready};
  gateway.start();
  const Answer run =
      motionlab({"rate", "control", "--count", "20", "--window", "60", "--json", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["stamp"], "t_snapshot_ns");
  EXPECT_EQ(json["heard"], 20);
  const Answer slow = motionlab(
      {"rate", "control", "--count", "20", "--window", "60", "--at-least", "100000", "--timeout", "60"});
  EXPECT_EQ(slow.exit_code, 1);
  EXPECT_THAT(slow.out, HasSubstr("lost on DDS"));
}

TEST_F(CommandLine, MeasuresDelays) {
  FakeGateway gateway{ModeState::ready};
  gateway.start();
  const Answer run = motionlab({"delay", "--window", "1", "--json", "--timeout", "60"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  bool found = false;
  for (const Json& hop : json["hops"]) {
    if (hop["hop"] != "measured -> control step" || hop["of"] != "mru") continue;
    found = true;
    EXPECT_EQ(hop["p50"], 2500.0);
  }
  EXPECT_TRUE(found) << run.out;
}

TEST_F(CommandLine, ListsTheTopicsOnTheBus) {
  FakeGateway gateway{ModeState::ready};
  gateway.start();
  Json json;
  for (int i = 0; i < 20 && json["topics"].size() < 6; ++i) {  // discovery takes as long as it takes
    json = Json::parse(motionlab({"topics", "--wait", "2", "--json"}).out);
  }
  std::vector<std::string> names;
  for (const Json& topic : json["topics"]) names.push_back(topic["topic"]);
  EXPECT_THAT(names, testing::IsSupersetOf({"motionlab/mode", "motionlab/mode_request", "truth/world"}));
  const Answer nobody =
      bare({"motionlab", "topics", "--wait", "0.2", "--domain", "76", "--interface", "127.0.0.1"});
  EXPECT_EQ(nobody.exit_code, 2);
  EXPECT_THAT(nobody.err, HasSubstr("nobody answers on DDS domain 76"));
}

TEST_F(CommandLine, TellsAReferenceAndSaysThatTheGatewayIsNotEngaged) {
  const Answer nobody = motionlab({"reference", "0.8", "0.3", "3.9", "--timeout", "0.2"});
  EXPECT_EQ(nobody.exit_code, 2);
  EXPECT_THAT(nobody.err, HasSubstr("nobody listens"));
  const Answer behind_dashes =
      bare({"motionlab", "--domain", std::to_string(own_domain()), "--interface", "127.0.0.1", "--timeout",
            "0.2", "reference", "--", "-0.8", "-0.3", "3.9"});
  EXPECT_EQ(behind_dashes.exit_code, 2);
  EXPECT_THAT(behind_dashes.err, HasSubstr("nobody listens"));
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"reference", "1", "2"},
                                                {"reference", "1", "2", "nan"},
                                                {"reference", "--by"},
                                                {"reference", "--frame", "moon", "1", "2", "3"},
                                                {"reference", "1", "2", "3", "--frame", "em1500", "--by"}}) {
    EXPECT_EQ(motionlab(wrong).exit_code, 64) << wrong.back();
  }
}

TEST_F(CommandLine, TakesDomainAndInterfaceFromTheEnvironment) {
  setenv("MOTIONLAB_DOMAIN", std::to_string(own_domain()).c_str(), 1);
  setenv("MOTIONLAB_INTERFACE", "127.0.0.1", 1);
  const Answer run = bare({"motionlab", "status", "--timeout", "0.1"});
  unsetenv("MOTIONLAB_DOMAIN");
  unsetenv("MOTIONLAB_INTERFACE");
  EXPECT_THAT(run.err, HasSubstr("domain " + std::to_string(own_domain()) + ", interface 127.0.0.1 within"));
}

TEST_F(CommandLine, ScoresByTheTruthWithALineASecondAndAReport) {
  FakeGateway gateway{ModeState::engaged};
  gateway.has_truth = gateway.has_estimate = true;
  gateway.start();
  const std::string path = testing::TempDir() + "motionlab_score_" + std::to_string(getpid()) + ".json";
  const Answer run = motionlab({"score", "--timeout", "60", "--seconds", "2.5", "--from", "0.5", "--scenario",
                                "calm", "--seed", "7", "--report", path});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("engaged   swing  0.06 deg (without:  5.73)  load   10.0 mm"));
  EXPECT_THAT(run.out, HasSubstr("mru 2.5"));
  EXPECT_THAT(run.out, HasSubstr("3/3 up"));
  std::ifstream file{path};
  const Json json = Json::parse(file);
  std::remove(path.c_str());
  EXPECT_EQ(json["scenario"], "calm");
  EXPECT_EQ(json["seed"], 7);
  EXPECT_EQ(json["source"], "truth");
  EXPECT_EQ(json["platform"], "tracked");
  EXPECT_EQ(json["duration_s"], 2.5);
  EXPECT_NEAR(json["swing_rms_deg"], 0.0573, 1e-4);
  EXPECT_NEAR(json["reduction"]["swing_rms"], 0.99, 1e-9);
  EXPECT_EQ(json["age_at_actuation_us"]["p50"], 2500);
  EXPECT_EQ(json["freshness"].size(), 3u);
}

TEST_F(CommandLine, ScoresByTheEstimateWhereThereIsNoTruth) {
  FakeGateway gateway{ModeState::engaged};
  gateway.has_estimate = true;
  gateway.start();
  const Answer run = motionlab({"score", "--timeout", "60", "--seconds", "4", "--from", "0", "--json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const Json json = Json::parse(run.out);
  EXPECT_EQ(json["source"], "estimate");
  EXPECT_TRUE(json["baseline"].is_null());
  EXPECT_NEAR(json["swing_rms_deg"], 0.1146, 1e-4);
  EXPECT_THAT(run.err, HasSubstr("swing  0.11 deg  load"));
}

TEST_F(CommandLine, EndsTheScoreWithTheReportSoFarWhenInterrupted) {
  FakeGateway gateway{ModeState::engaged};
  gateway.has_truth = true;
  gateway.start();
  std::optional<Answer> run;
  std::thread scoring{[&] { run = motionlab({"score", "--timeout", "60", "--from", "0", "--json"}); }};
  std::this_thread::sleep_for(2s);
  interrupted_ = true;
  scoring.join();
  EXPECT_EQ(run->exit_code, 0) << run->err;
  EXPECT_GT(Json::parse(run->out)["samples"], 0);
}

TEST_F(CommandLine, SaysWhenTheRunEndedBeforeTheWindow) {
  FakeGateway gateway{ModeState::engaged};
  gateway.has_truth = true;
  gateway.start();
  const Answer run = motionlab({"score", "--timeout", "60", "--seconds", "0.5"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("the window begins at 20.0 s (--from), the run was seen until 0.5 s"));
}

TEST_F(CommandLine, RefusesAReportThatCannotBeWrittenBeforeItBegins) {
  const Answer run = motionlab({"score", "--report", "/nowhere/at/all.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("/nowhere/at/all.json"));
}

}  // namespace
}  // namespace motionlab::monitor
