// motionlab record, verify, export, replay: what people type, on a bus of their own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "gateway/bus/dds_bus.hpp"
#include "gateway/monitor/command_line.hpp"
#include "gateway/record/recording.hpp"
#include "tests/support/own_domain.hpp"
#include "tests/unit/record/heard.hpp"

namespace motionlab::monitor {
namespace {

namespace fs = std::filesystem;
using record::Heard;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
using Json = nlohmann::ordered_json;

constexpr std::int64_t kBegan = 1'800'000'000'000'000'000;

int own_domain() {
  return test::own_domain();
}

bus::DdsConfig loopback(const char* participant) {
  bus::DdsConfig config;
  config.domain = own_domain();
  config.interface_whitelist = {"127.0.0.1"};
  config.participant = participant;
  config.join_truth = true;
  return config;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

/// Two devices and an event now and then, until the end of its life.
class Speaker {
 public:
  Speaker() : dds_(loopback("speaker"), local_) {
    dds_.out<topic::Mru>();
    dds_.out<topic::Event>();
    dds_.out<topic::TruthWorld>();
    dds_.start();
    thread_ = std::thread(
        [this, mrus = local_.advertise<topic::Mru>(), events = local_.advertise<topic::Event>()]() mutable {
          for (std::uint64_t n = 1; !stopping_; ++n) {
            for (const char* const device : {"mru1", "mru2"}) {
              topic::Mru mru;
              mru.device = device;
              mru.sequence_number = n;
              mrus.publish(mru);
            }
            if (n % 20 == 0) events.publish({});
            std::this_thread::sleep_for(5ms);
          }
        });
  }
  ~Speaker() {
    stopping_ = true;
    thread_.join();
  }

 private:
  bus::LocalBus local_;
  bus::DdsBus dds_;
  std::atomic<bool> stopping_{false};
  std::thread thread_;
};

/// Hears mrus, references and requests while it lives.
class Listener {
 public:
  Listener()
      : dds_(loopback("listener"), local_),
        mrus_(local_.subscribe<topic::Mru>()),
        references_(local_.subscribe<topic::Reference>()) {
    dds_.in<topic::Mru>();
    dds_.in<topic::Reference>();
    dds_.start();
  }
  ~Listener() { dds_.stop(); }

  std::vector<topic::Mru> mrus() { return all(mrus_); }
  std::vector<topic::Reference> references() { return all(references_); }

 private:
  template <class T>
  static std::vector<T> all(bus::Subscription<T>& from) {
    std::vector<T> samples;
    while (const auto sample = from.next()) samples.push_back(*sample);
    return samples;
  }

  bus::LocalBus local_;
  bus::DdsBus dds_;
  bus::Subscription<topic::Mru> mrus_;
  bus::Subscription<topic::Reference> references_;
};

struct Answer {
  int exit_code;
  std::string out, err;
};

class RecordingCommands : public testing::Test {
 protected:
  RecordingCommands()
      : folder_(fs::path(testing::TempDir()) / ("motionlab-recordings-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~RecordingCommands() override { fs::remove_all(folder_); }

  Answer motionlab(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(),
                     {"motionlab", "--domain", std::to_string(own_domain()), "--interface", "127.0.0.1"});
    std::vector<const char*> argv;
    for (const std::string& argument : arguments) argv.push_back(argument.c_str());
    std::ostringstream out, err;
    const int code =
        run_command_line(static_cast<int>(argv.size()), argv.data(), {out, err, false, interrupted_});
    return {code, out.str(), err.str()};
  }

  [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }

  /// A hundred samples of one unit, a fifth of a second in all, and a reference.
  void make_recording(const std::string& name) const {
    record::Recording recording({.file = at(name)}, from_ns(kBegan));
    record::SampleQueue queue(1 << 20);
    topic::Reference reference;
    reference.requester = "a \"stranger\", recorded";
    reference.p_world_load_m = {1, 2, 3};
    (void)queue.push(Heard(reference, 1, kBegan).sample());
    for (std::uint64_t n = 1; n <= 100; ++n) {
      topic::Mru mru;
      mru.device = "mru1";
      mru.sequence_number = n;
      mru.euler_heading_mru_rad = {0.1, 0.2 / static_cast<double>(n), -1e-9};
      (void)queue.push(Heard(mru, n, kBegan + static_cast<std::int64_t>(n) * 2'000'000).sample());
    }
    while (queue.pop([&](const record::SampleToRecord& sample, Bytes cdr) { recording.take(sample, cdr); }))
      continue;
    recording.finish(queue.ledger().all());
  }

  std::map<std::string, int> messages_in(const std::string& file) {
    std::map<std::string, int> messages;
    const Answer answer = motionlab({"verify", at(file), "--json"});
    EXPECT_EQ(answer.exit_code, kExitGood) << answer.err;
    const Json seen = Json::parse(answer.out);
    for (const Json& topic : seen.at("topics"))
      messages[topic.at("topic").get<std::string>()] = topic.at("messages").get<int>();
    return messages;
  }

  fs::path folder_;
  std::atomic<bool> interrupted_{false};
};

TEST_F(RecordingCommands, RecordsWhatIsSaidAndVerifiesIt) {
  const Speaker speaker;
  std::ofstream(folder_ / "lab.toml") << "[control]\nperiod_s = 0.001  # measured\n";
  std::ofstream(folder_ / "slow.toml") << "[control]\nperiod_s = 0.002\n";
  const Answer answer = motionlab({"record", "-o", at("run.mcap"), "--seconds", "3", "--config",
                                   at("lab.toml"), "--overlay", at("slow.toml"), "--json"});
  ASSERT_EQ(answer.exit_code, kExitGood) << answer.err;
  const Json json = Json::parse(answer.out);
  EXPECT_EQ(json.at("files"), Json::array({at("run.mcap")}));
  EXPECT_GT(json.at("messages").get<int>(), 100);
  const auto messages = messages_in("run.mcap");
  EXPECT_GT(messages.at("motionlab/mru"), 100);
  EXPECT_GT(messages.at("motionlab/event"), 3);
  EXPECT_EQ(messages.size(), 2U);
  const Answer seen = motionlab({"verify", at("run.mcap")});
  EXPECT_THAT(seen.out, StartsWith("whole, written by motionlab "));
  EXPECT_THAT(seen.out, HasSubstr("on DDS, 0 in the queue, 0 refused"));
  EXPECT_THAT(seen.out, HasSubstr("attached: gateway.toml, "));
  EXPECT_THAT(seen.out, HasSubstr("attached: lab.toml, 39 bytes"));
  EXPECT_THAT(seen.out, HasSubstr("attached: slow.toml, 27 bytes"));
  const std::string whole = text_of(at("run.mcap"));
  EXPECT_THAT(whole, HasSubstr("[control]\nperiod_s = 0.002")) << "what is in effect, as one text";
}

TEST_F(RecordingCommands, RecordsOnlyTheTopicsThatWereNamedIntoAFolder) {
  const Speaker speaker;
  const Answer answer =
      motionlab({"record", "-o", folder_.string(), "--topics", "event,estimate", "--seconds", "2"});
  ASSERT_EQ(answer.exit_code, kExitGood) << answer.err;
  const fs::path file = fs::directory_iterator(folder_)->path();
  EXPECT_THAT(file.filename().string(), StartsWith("motionlab-2"));
  EXPECT_THAT(answer.out, HasSubstr(file.string()));
  const auto messages = messages_in(file.filename());
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_GT(messages.at("motionlab/event"), 0);
}

TEST_F(RecordingCommands, KeepsWhatSurroundsAnEventAndNothingElse) {
  const Speaker speaker;  // of events that are worth no more than "info"
  const Answer quiet =
      motionlab({"record", "-o", at("fault.mcap"), "--on-event", "fault", "--seconds", "2", "--json"});
  EXPECT_EQ(quiet.exit_code, kExitGood) << quiet.err;
  EXPECT_EQ(Json::parse(quiet.out).at("files"), Json::array());
  const Answer answer = motionlab({"record", "-o", at("info.mcap"), "--on-event", "info", "--topics", "mru",
                                   "--before", "0.2", "--after", "0.2", "--seconds", "2", "--json"});
  ASSERT_EQ(answer.exit_code, kExitGood) << answer.err;
  const auto messages = messages_in("info.mcap");
  EXPECT_GT(messages.at("motionlab/mru"), 20);
  EXPECT_GT(messages.at("motionlab/event"), 3) << "they open the windows, named or not";
  EXPECT_THAT(motionlab({"verify", at("info.mcap")}).out, HasSubstr("motionlab/occasion after_s 0.200"));
}

TEST_F(RecordingCommands, EndsWholeWhenItIsInterrupted) {
  const Speaker speaker;
  std::thread user([this] {
    std::this_thread::sleep_for(2s);
    interrupted_ = true;
  });
  const Answer answer = motionlab({"record", "-o", at("run.mcap")});
  user.join();
  interrupted_ = false;
  EXPECT_EQ(answer.exit_code, kExitGood) << answer.err;
  EXPECT_GT(messages_in("run.mcap").at("motionlab/mru"), 10);
}

TEST_F(RecordingCommands, SaysWhenNobodyWasHeard) {
  const Answer answer = motionlab({"record", "-o", at("run.mcap"), "--seconds", "0.2"});
  EXPECT_EQ(answer.exit_code, kExitNobody);
  EXPECT_THAT(answer.err, HasSubstr("nobody answers on DDS domain"));
  EXPECT_TRUE(messages_in("run.mcap").empty());
}

TEST_F(RecordingCommands, RefusesWhatMakesNoSense) {
  EXPECT_THAT(motionlab({"record", "-o", at("x.mcap"), "--topics", "motionlab/mrru"}).err,
              HasSubstr("there is no topic motionlab/mrru; do you mean motionlab/mru?"));
  EXPECT_THAT(motionlab({"record", "-o", at("x.mcap"), "--config", at("none.toml")}).err,
              HasSubstr("none.toml"));
  EXPECT_THAT(motionlab({"record", "-o", at("x.mcap"), "--attach", at("none.bin")}).err,
              HasSubstr("a file to attach must be there"));
  EXPECT_EQ(motionlab({"record", "-o", at("x.mcap"), "--before", "3"}).exit_code, kExitUsage)
      << "before what?";
  EXPECT_THAT(motionlab({"record", "-o", at("none/x.mcap")}).err, HasSubstr("choose a folder that exists"));
  EXPECT_THAT(motionlab({"verify", at("none.mcap")}).err, HasSubstr("No such file"));
  EXPECT_THAT(motionlab({"export", at("none.mcap")}).err, HasSubstr("--csv"));
  EXPECT_EQ(motionlab({"verify", folder_.string()}).exit_code, kExitUsage);
  EXPECT_TRUE(fs::is_empty(folder_)) << "nothing is left behind";
}

TEST_F(RecordingCommands, VerifiesAndRepairsAFileThatWasCutOff) {
  make_recording("run.mcap");
  fs::copy_file(at("run.mcap"), at("cut.mcap"));
  fs::resize_file(at("cut.mcap"), fs::file_size(at("cut.mcap")) - 100);
  const Answer cut = motionlab({"verify", at("cut.mcap")});
  EXPECT_EQ(cut.exit_code, kExitWrong);
  EXPECT_THAT(cut.out, StartsWith("not whole"));
  EXPECT_THAT(cut.out, HasSubstr("missing: its end."));
  const Answer repaired = motionlab({"verify", at("cut.mcap"), "--repair", at("whole.mcap")});
  EXPECT_EQ(repaired.exit_code, kExitGood) << repaired.err;
  EXPECT_EQ(messages_in("whole.mcap"),
            (std::map<std::string, int>{{"motionlab/mru", 100}, {"motionlab/reference", 1}}));
  EXPECT_THAT(motionlab({"verify", at("cut.mcap"), "--repair", at("run.mcap")}).err,
              HasSubstr("exists already and is not written over"));
}

TEST_F(RecordingCommands, SavesNothingFromWhatIsNoRecording) {
  std::ofstream(folder_ / "notes.txt") << "not a recording";
  const Answer answer = motionlab({"verify", at("notes.txt"), "--repair", at("whole.mcap")});
  EXPECT_EQ(answer.exit_code, kExitWrong);
  EXPECT_THAT(answer.out, HasSubstr("this is not an MCAP file"));
  EXPECT_FALSE(fs::exists(folder_ / "whole.mcap"));
}

TEST_F(RecordingCommands, TextsOfAFileCannotTouchTheTerminal) {
  std::ofstream out(folder_ / "evil.mcap", std::ios::binary);
  record::McapWriter writer(out, {.profile = {}, .library = "\x1b[2J"});
  writer.metadata("\x1b]0;name", {{"\x07", "\x1b[31m"}});
  writer.message(writer.add_channel("\x1b[1m", "cdr", 0), 0, {}, {}, {});
  writer.attachment("\x9b", "", {}, {});
  writer.finish();
  out.close();
  for (const Answer& answer :
       {motionlab({"verify", at("evil.mcap")}), motionlab({"verify", at("evil.mcap"), "--json"}),
        motionlab({"export", at("evil.mcap"), "--csv"})}) {
    EXPECT_THAT(answer.out + answer.err, Not(HasSubstr("\x1b")));
    EXPECT_THAT(answer.out + answer.err, Not(HasSubstr("\x07")));
  }
}

TEST_F(RecordingCommands, ExportsATableForEachTopic) {
  make_recording("run.mcap");
  const Answer answer = motionlab({"export", at("run.mcap"), "--csv"});
  ASSERT_EQ(answer.exit_code, kExitGood) << answer.err;
  EXPECT_THAT(answer.out, HasSubstr(at("run/motionlab_mru.csv") + ": 100 samples"));
  std::istringstream mru(text_of(folder_ / "run" / "motionlab_mru.csv"));
  std::string header, first, second;
  std::getline(mru, header);
  std::getline(mru, first);
  std::getline(mru, second);
  EXPECT_THAT(header, StartsWith("t_heard_ns,t_written_ns,device,sequence_number,t_measured_ns,"));
  EXPECT_THAT(header, HasSubstr(",euler_heading_mru_rad[0],euler_heading_mru_rad[1],"));
  EXPECT_THAT(first, StartsWith("1800000000002000000,1800000000001999000,mru1,1,0,0,0,0,0.1,0.2,-1e-09,"));
  EXPECT_THAT(second, StartsWith("1800000000004000000,1800000000003999000,mru1,2,0,0,0,0,0.1,0.1,-1e-09,"));
  EXPECT_THAT(text_of(folder_ / "run" / "motionlab_reference.csv"),
              HasSubstr("\"a \"\"stranger\"\", recorded\""));
  EXPECT_THAT(motionlab({"export", at("run.mcap"), "--csv"}).err, HasSubstr("exists already"));
}

TEST_F(RecordingCommands, ExportsOnlyTheTopicThatWasAskedFor) {
  make_recording("run.mcap");
  const Answer answer =
      motionlab({"export", at("run.mcap"), "--csv", "--topic", "mru", "-o", at("tables/of/mine")});
  ASSERT_EQ(answer.exit_code, kExitGood) << answer.err;
  EXPECT_TRUE(fs::exists(at("tables/of/mine/motionlab_mru.csv")));
  EXPECT_FALSE(fs::exists(at("tables/of/mine/motionlab_reference.csv")));
  EXPECT_EQ(motionlab({"export", at("run.mcap"), "--csv", "--topic", "estimate", "-o", at("none")}).exit_code,
            kExitWrong);
}

TEST_F(RecordingCommands, SaysARecordingAgainButAsksNobodyForAnything) {
  make_recording("run.mcap");
  Listener listener;
  const Answer answer = motionlab({"replay", at("run.mcap")});
  ASSERT_EQ(answer.exit_code, kExitGood) << answer.err;
  EXPECT_EQ(answer.out, "100 samples said\n");
  EXPECT_EQ(answer.err, "left out: motionlab/reference\n");
  std::this_thread::sleep_for(500ms);
  const std::vector<topic::Mru> heard = listener.mrus();
  ASSERT_GT(heard.size(), 50U) << "best effort: some may be lost, not most";
  for (const topic::Mru& mru : heard) {
    EXPECT_EQ(mru.device, "mru1");
    EXPECT_EQ(mru.euler_heading_mru_rad[1], 0.2 / static_cast<double>(mru.sequence_number));
  }
  EXPECT_TRUE(listener.references().empty());
}

TEST_F(RecordingCommands, SaysAReferenceOnlyWhenItIsNamed) {
  make_recording("run.mcap");
  Listener listener;
  const Answer answer = motionlab({"replay", at("run.mcap"), "--topics", "reference", "--speed", "100"});
  ASSERT_EQ(answer.exit_code, kExitGood) << answer.err;
  EXPECT_EQ(answer.out, "1 samples said\n");
  std::this_thread::sleep_for(500ms);
  const std::vector<topic::Reference> heard = listener.references();
  ASSERT_EQ(heard.size(), 1U);
  EXPECT_EQ(heard[0].p_world_load_m, (std::array<double, 3>{1, 2, 3}));
  EXPECT_TRUE(listener.mrus().empty());
}

TEST_F(RecordingCommands, SaysNothingWhereAGatewayLives) {
  make_recording("run.mcap");
  bus::LocalBus local;
  bus::DdsBus gateway(loopback("motionlab-gateway"), local);
  gateway.out<topic::Mode>();
  gateway.start();
  Listener listener;
  const Answer answer = motionlab({"replay", at("run.mcap"), "--topics", "mru,reference"});
  EXPECT_EQ(answer.exit_code, kExitWrong);
  EXPECT_THAT(answer.err, HasSubstr("a gateway lives in domain " + std::to_string(own_domain()) +
                                    " (motionlab-gateway on "));
  EXPECT_THAT(answer.out, Not(HasSubstr("said")));
  EXPECT_TRUE(listener.mrus().empty());
  EXPECT_TRUE(listener.references().empty());
}

TEST_F(RecordingCommands, FallsSilentWhenAGatewayAppears) {
  make_recording("run.mcap");
  Answer answer{};
  std::thread replay([&] { answer = motionlab({"replay", at("run.mcap"), "--speed", "0.005"}); });  // 40 s
  Listener listener;
  bool speaks = false;
  for (int i = 0; i < 600 && !speaks; ++i) {
    std::this_thread::sleep_for(50ms);
    speaks = !listener.mrus().empty();
  }
  EXPECT_TRUE(speaks);
  bus::LocalBus local;
  bus::DdsBus gateway(loopback("motionlab-gateway"), local);
  gateway.out<topic::Mode>();
  gateway.start();
  replay.join();
  EXPECT_EQ(answer.exit_code, kExitWrong);
  EXPECT_THAT(answer.err, HasSubstr("a gateway lives in domain"));
  EXPECT_NE(answer.out, "100 samples said\n");
}

}  // namespace
}  // namespace motionlab::monitor
