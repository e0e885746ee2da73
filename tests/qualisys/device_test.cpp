// The simulated server as its clients see it: texts and packets as the vendor's clients need them.
#include "simulators/qualisys/qualisys_device.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "drivers/core/random.hpp"

namespace motionlab::qualisys {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr Endpoint kPeer{0x7f000001, 50001};

class RecordingServer final : public ServerOut {
 public:
  Status send(SessionId session, Bytes bytes) override {
    if (full) return Fault{Reason::transport, "the peer does not take what was sent"};
    sends[session].emplace_back(bytes.begin(), bytes.end());
    return Done{};
  }
  void close(SessionId session) override { closed.push_back(session); }

  /// What one session got since the last call: "type:text", or "type" alone.
  std::vector<std::string> heard(SessionId session) {
    std::vector<std::string> all;
    for (const ByteBuffer& bytes : std::exchange(sends[session], {})) {
      const auto packet = decode_datagram(bytes);
      if (!packet) {
        all.push_back("broken");
        continue;
      }
      std::string text = std::to_string(static_cast<unsigned>(packet->type));
      if (packet->type == PacketType::event) text.append(":").append(std::to_string(packet->payload[0]));
      if (static_cast<unsigned>(packet->type) <= 2) {
        EXPECT_EQ(packet->payload.back(), 0) << "every text ends with NUL";
        text.append(":").append(packet_text(packet->payload));
      }
      all.push_back(text);
    }
    return all;
  }

  std::map<SessionId, std::vector<ByteBuffer>> sends;
  std::vector<SessionId> closed;
  bool full = false;
};

class RecordingDatagrams final : public DatagramOut {
 public:
  Status send(Endpoint to, Bytes datagram) override {
    sent.emplace_back(to, ByteBuffer{datagram.begin(), datagram.end()});
    return Done{};
  }
  std::vector<std::pair<Endpoint, ByteBuffer>> sent;
};

class QualisysDeviceTest : public testing::Test {
 protected:
  QualisysDeviceTest() {
    dut.on_accepted(1, kPeer, now);
    greeting = server.heard(1);
    ask("Version 1.25");
  }
  std::vector<std::string> ask(std::string_view command, SessionId session = 1) {
    dut.on_bytes(session, encode_text(PacketType::command, command), now);
    return server.heard(session);
  }
  void expose(std::uint32_t frames = 1) {
    for (std::uint32_t i = 0; i < frames; ++i) {
      now += 5ms;
      dut.capture({.bodies = {{"load", true, {1, 2, 3}, {1, 0, 0, 0}, 0.001}}}, now);
      dut.step(now + 7ms);
    }
  }

  LabTime now{};
  RecordingServer server;
  RecordingDatagrams datagrams;
  QualisysDevice dut{{}, server, datagrams};
  std::vector<std::string> greeting;
};

TEST_F(QualisysDeviceTest, GreetsAtOnceWithoutAFullStop) {
  EXPECT_THAT(greeting, ElementsAre("1:QTM RT Interface connected"));
}

TEST_F(QualisysDeviceTest, SpeaksTheVersionsWithOneBinaryLayout) {
  EXPECT_THAT(ask("Version"), ElementsAre("1:Version is 1.25"));
  EXPECT_THAT(ask("Version 1.28"), ElementsAre("1:Version set to 1.28"));
  EXPECT_THAT(ask("Version 1.8"), ElementsAre("1:Version set to 1.8"));
  for (const char* bad : {"Version 1.7", "Version 1.29", "Version 2.0", "Version 1.", "Version 1.2x",
                          "Version x", "Version 1.20 1.21"})
    EXPECT_THAT(ask(bad), ElementsAre("0:Version NOT supported")) << bad;
  EXPECT_THAT(ask("Version"), ElementsAre("1:Version is 1.8")) << "a refused version changes nothing";
}

TEST_F(QualisysDeviceTest, StartsAClientAt11WhichItCannotServe) {
  dut.on_accepted(2, kPeer, now);
  server.heard(2);
  EXPECT_THAT(ask("Version", 2), ElementsAre("1:Version is 1.1"));
  for (const char* command : {"GetParameters 6D", "StreamFrames AllFrames 6D", "GetCurrentFrame 6D"})
    EXPECT_THAT(ask(command, 2), ElementsAre("0:Version NOT supported"));
}

TEST_F(QualisysDeviceTest, AnswersTheSmallQuestions) {
  EXPECT_THAT(ask("QTMVersion"), ElementsAre("1:QTM Version is 2.17 (build 3700)"));
  EXPECT_THAT(ask("ByteOrder"), ElementsAre("1:Byte order is little endian"));
  EXPECT_THAT(ask("GetState"), ElementsAre("6:3"));
  EXPECT_THAT(ask("Nonsense"), ElementsAre("0:Parse error"));
  EXPECT_THAT(ask(""), ElementsAre("0:Parse error"));
}

TEST_F(QualisysDeviceTest, ToleratesMissingNulCaseAndBlanks) {
  const ByteBuffer without_nul = {16, 0, 0, 0, 1, 0, 0, 0, 'g', 'e', 't', 's', 't', 'a', 't', 'e'};
  dut.on_bytes(1, without_nul, now);
  EXPECT_THAT(server.heard(1), ElementsAre("6:3"));
  EXPECT_THAT(ask("  version   1.25 "), ElementsAre("1:Version set to 1.25"));
  EXPECT_THAT(ask("takecontrol "), ElementsAre("1:You are now master"));
}

TEST_F(QualisysDeviceTest, TakesCommandsInPiecesAndSeveralAtOnce) {
  ByteBuffer bytes = encode_text(PacketType::command, "ByteOrder");
  const ByteBuffer second = encode_text(PacketType::command, "GetState");
  bytes.insert(bytes.end(), second.begin(), second.end());
  for (const std::uint8_t byte : bytes) dut.on_bytes(1, {&byte, 1}, now);
  EXPECT_THAT(server.heard(1), ElementsAre("1:Byte order is little endian", "6:3"));
  dut.on_bytes(1, bytes, now);
  EXPECT_EQ(server.heard(1).size(), 2u);
}

TEST_F(QualisysDeviceTest, ClosesASessionWhosePacketsCannotBe) {
  const ByteBuffer bad = {1, 0, 0, 0};
  dut.on_bytes(1, bad, now);
  EXPECT_THAT(server.closed, ElementsAre(1u));
  EXPECT_EQ(dut.clients(), 0u);
  EXPECT_THAT(ask("GetState"), IsEmpty());
}

TEST_F(QualisysDeviceTest, RefusesThePacketThatIsNeitherCommandNorSettings) {
  dut.on_bytes(1, encode_event(Event::trigger), now);
  EXPECT_THAT(server.heard(1), ElementsAre("0:Parse error"));
}

TEST_F(QualisysDeviceTest, TakesTheListOfBodiesFromTheSettingsOfAMaster) {
  const auto set = [&](std::string_view xml) {
    dut.on_bytes(1, encode_text(PacketType::xml, xml), now);
    return server.heard(1);
  };
  EXPECT_THAT(set("<QTM_Settings/>"), ElementsAre("0:You must be master to issue this command"));
  ask("TakeControl");
  EXPECT_THAT(set("<QTM_Settings/>"), ElementsAre("1:Setting parameters succeeded"))
      << "nothing that changes";
  EXPECT_THAT(set("<QTM_Settings"), ElementsAre("0:Setting parameters failed"));
  EXPECT_THAT(set("<QTM_Settings><The_6D><Body><Name>crate</Name></Body></The_6D></QTM_Settings>"),
              ElementsAre("1:Setting parameters succeeded", "6:11"));
  EXPECT_EQ(*parse_bodies_xml(ask("GetParameters 6D")[0].substr(2)),
            (std::vector<BodyDefinition>{{"crate", true}}));
}

TEST_F(QualisysDeviceTest, KeepsAnswersForAClientThatDoesNotReadAndDropsItsFrames) {
  ask("StreamFrames AllFrames 6D");
  server.full = true;
  EXPECT_THAT(ask("ByteOrder"), IsEmpty());
  expose(3);
  EXPECT_EQ(dut.send_failures(), 3u);
  server.full = false;
  dut.step(now);
  EXPECT_THAT(server.heard(1), ElementsAre("1:Byte order is little endian"));
  expose();
  EXPECT_THAT(server.heard(1), ElementsAre("3"));
}

TEST_F(QualisysDeviceTest, DropsAClientThatTakesNoAnswersAtAll) {
  server.full = true;
  for (int i = 0; i < 300; ++i) ask("ByteOrder");
  dut.step(now);
  EXPECT_THAT(server.closed, ElementsAre(1u));
  EXPECT_EQ(dut.clients(), 0u);
}

TEST_F(QualisysDeviceTest, IsTakenThroughAMeasurementByItsMaster) {
  EXPECT_THAT(ask("Stop"), ElementsAre("0:You must be master to issue this command"));
  ask("TakeControl");
  EXPECT_THAT(ask("Stop"), ElementsAre("1:Stopping measurement", "6:4"));
  EXPECT_THAT(ask("Stop"), ElementsAre("0:No measurement is running"));
  EXPECT_THAT(ask("New"), ElementsAre("0:The previous measurement has not been saved or closed"));
  EXPECT_THAT(ask("Close"), ElementsAre("1:Closing connection", "6:2"));
  EXPECT_THAT(ask("Close"), ElementsAre("1:No connection to close"));
  EXPECT_THAT(ask("Start"), ElementsAre("0:Not connected. Create connection with new"));
  EXPECT_THAT(ask("Start RTFromFile"), ElementsAre("0:No file open"));
  EXPECT_THAT(ask("New"), ElementsAre("1:Creating new connection", "6:1"));
  EXPECT_THAT(ask("New"), ElementsAre("1:Already connected"));
  EXPECT_TRUE(dut.measuring()) << "a preview streams too";
  EXPECT_THAT(ask("SetQTMEvent lift"), ElementsAre("0:QTM is not capturing"));
  EXPECT_THAT(ask("Start"), ElementsAre("1:Starting measurement", "6:3"));
  EXPECT_THAT(ask("Start"), ElementsAre("0:Measurement is already running"));
  EXPECT_THAT(ask("SetQTMEvent lift"), ElementsAre("1:Event set"));
  EXPECT_THAT(ask("SetQTMEvent " + std::string(99, 'x')), ElementsAre("0:Event label too long"));
  EXPECT_THAT(ask("Trig"), ElementsAre("0:QTM not waiting for trig"));
}

TEST_F(QualisysDeviceTest, WaitsForATriggerPlaysFilesAndGuardsControlWhenToldTo) {
  QualisysDevice device{
      {.measures_at_start = false, .password = "sesame", .file_is_open = true, .waits_for_trigger = true},
      server,
      datagrams};
  device.on_accepted(7, kPeer, now);
  server.heard(7);
  const auto say = [&](std::string_view text) {
    device.on_bytes(7, encode_text(PacketType::command, text), now);
    return server.heard(7);
  };
  EXPECT_THAT(say("TakeControl"), ElementsAre("0:Wrong or missing password"));
  EXPECT_THAT(say("TakeControl sesame"), ElementsAre("1:You are now master"));
  EXPECT_THAT(say("Start RTFromFile"), ElementsAre("1:Starting RT from file", "6:8"));
  EXPECT_THAT(say("Start RTFromFile"), ElementsAre("0:RT from file already running"));
  EXPECT_THAT(say("Stop"), ElementsAre("1:Stopping measurement", "6:9"));
  EXPECT_THAT(say("Close"), ElementsAre("1:Closing connection", "6:2"));
  say("New");
  EXPECT_THAT(say("Start"), ElementsAre("1:Starting measurement", "6:10"));
  EXPECT_THAT(say("Trig"), ElementsAre("1:Trig ok", "6:16", "6:3"));
}

TEST_F(QualisysDeviceTest, TellsTimeInEveryKindOfTimecode) {
  // 2026-11-24 17:05:09.55 UTC, day 328 of the year; half of SMPTE's 30 frames and a sub-frame of 40 / 80
  // later.
  const LabTime t{1'795'539'909'550'000'000ns};
  EXPECT_EQ(timecode_of(TimecodeSource::irig, t, 0.0), (Timecode{IrigTime{26, 328, 17, 5, 9, 5}}));
  EXPECT_EQ(timecode_of(TimecodeSource::smpte, t, 0.0), (Timecode{SmpteTime{17, 5, 9, 16, 40}}));
  EXPECT_EQ(timecode_of(TimecodeSource::camera, t, 2.0),
            (Timecode{CameraTime{Nanoseconds{1'795'539'911'550'000'000}}}));
  EXPECT_FALSE(timecode_of(TimecodeSource::none, t, 0.0));
}

TEST_F(QualisysDeviceTest, AnswersWithTheGroupsAskedForUnderOneRoot) {
  const auto bodies = ask("GetParameters 6D");
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_THAT(bodies[0], testing::StartsWith("2:<QTM_Parameters_Ver_1.25>"));
  EXPECT_EQ(parse_bodies_xml(bodies[0].substr(2))->size(), 1u);
  EXPECT_THAT(bodies[0], testing::Not(HasSubstr("<General>")));
  EXPECT_THAT(ask("getparameters general")[0], HasSubstr("<Frequency>200</Frequency>"));
  const auto all = ask("GetParameters All")[0];
  EXPECT_THAT(all, HasSubstr("<General>"));
  EXPECT_THAT(all, HasSubstr("<The_6D>"));
  EXPECT_THAT(ask("GetParameters Force"), ElementsAre("2:<QTM_Parameters_Ver_1.25/>\n"))
      << "a group without data leaves an empty root, not an error";
  EXPECT_THAT(ask("GetParameters"), ElementsAre("0:Parse error"));
  EXPECT_THAT(ask("GetParameters Weather"), ElementsAre("0:Parse error"));
}

TEST_F(QualisysDeviceTest, StreamsToTheClientsOwnAddressWithoutAnyReply) {
  EXPECT_THAT(ask("StreamFrames AllFrames UDP:50199 6DRes Timecode"), IsEmpty());
  expose(3);
  ASSERT_EQ(datagrams.sent.size(), 3u);
  EXPECT_EQ(datagrams.sent[0].first, (Endpoint{kPeer.address, 50199}));
  const auto frame = decode_data(decode_datagram(datagrams.sent[2].second)->payload);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->frame_number, 3u);
  EXPECT_EQ(frame->timestamp_us, 10'000u) << "exposure time since the first frame, not sending time";
  EXPECT_TRUE(frame->bodies.all[0].tracked);
  EXPECT_FALSE(frame->timecode) << "not switched on in this system";
  EXPECT_THAT(server.heard(1), IsEmpty());
  EXPECT_THAT(ask("StreamFrames Stop"), IsEmpty());
  expose(3);
  EXPECT_EQ(datagrams.sent.size(), 3u);
}

TEST_F(QualisysDeviceTest, StreamsOverTheConnectionOrToAnotherAddress) {
  ask("streamframes allframes 6d ");
  expose();
  EXPECT_THAT(server.heard(1), ElementsAre("3"));
  ask("StreamFrames AllFrames UDP:10.0.0.7:6734 6D");
  expose();
  EXPECT_EQ(datagrams.sent.at(0).first, Endpoint::parse("10.0.0.7:6734"));
  EXPECT_THAT(server.heard(1), IsEmpty()) << "the new stream replaced the old one";
}

TEST_F(QualisysDeviceTest, StreamsAtTheFrequencyAskedFor) {
  ask("StreamFrames FrequencyDivisor:4 UDP:50199 6D");
  expose(40);
  EXPECT_EQ(datagrams.sent.size(), 10u);
  datagrams.sent.clear();
  ask("StreamFrames Frequency:60 UDP:50199 6D");
  expose(200);
  EXPECT_NEAR(static_cast<double>(datagrams.sent.size()), 60.0, 1.0);
  datagrams.sent.clear();
  ask("StreamFrames Frequency:1000 UDP:50199 6D");
  expose(40);
  EXPECT_EQ(datagrams.sent.size(), 40u) << "never above the real-time rate";
}

TEST_F(QualisysDeviceTest, RefusesAStreamThatCannotBe) {
  for (const char* bad : {"StreamFrames", "StreamFrames AllFrames", "StreamFrames Sometimes 6D",
                          "StreamFrames AllFrames UDP:50199", "StreamFrames AllFrames UDP:80 6D",
                          "StreamFrames AllFrames UDP:99999 6D", "StreamFrames AllFrames UDP: 6D",
                          "StreamFrames AllFrames UDP:not.an.address:50199 6D", "StreamFrames AllFrames 7D",
                          "StreamFrames Frequency:0 6D", "StreamFrames Frequency:nan 6D",
                          "StreamFrames FrequencyDivisor:x 6D", "GetCurrentFrame", "GetCurrentFrame 7D"})
    EXPECT_THAT(ask(bad), ElementsAre("0:Parse error")) << bad;
  EXPECT_THAT(ask("StreamFrames AllFrames UDP:50199 6D 3DNoLabelsRes Analog:1"), IsEmpty())
      << "components without data may be asked for";
}

TEST_F(QualisysDeviceTest, AnswersGetCurrentFrameWithTheNextFrame) {
  EXPECT_THAT(ask("GetCurrentFrame 6DRes"), IsEmpty());
  expose(2);
  EXPECT_THAT(server.heard(1), ElementsAre("3"));
}

TEST_F(QualisysDeviceTest, SaysNoMoreDataWhileNothingIsMeasured) {
  ask("StreamFrames AllFrames 6D");
  ASSERT_TRUE(dut.set_fault("stop_measurement", true));
  EXPECT_THAT(server.heard(1), ElementsAre("6:4", "4"));
  expose();
  EXPECT_THAT(server.heard(1), IsEmpty());
  EXPECT_THAT(ask("GetState"), ElementsAre("6:4"));
  EXPECT_THAT(ask("GetCurrentFrame 6D"), ElementsAre("4"));
  EXPECT_THAT(ask("StreamFrames AllFrames 6D"), ElementsAre("4"));
  ASSERT_TRUE(dut.set_fault("stop_measurement", false));
  EXPECT_THAT(server.heard(1), ElementsAre("6:3"));
  expose();
  const auto packet = decode_datagram(server.sends[1].at(0));
  EXPECT_EQ(decode_data(packet->payload)->frame_number, 1u)
      << "the subscription lives on, counting starts again";
}

TEST_F(QualisysDeviceTest, SendsTheCameraTimeWhenThatIsSwitchedOn) {
  QualisysDevice device{
      {.timecode = TimecodeSource::camera, .camera_time_offset_s = 100.0}, server, datagrams};
  device.on_accepted(7, kPeer, now);
  for (const char* command : {"Version 1.25", "StreamFrames AllFrames UDP:50199 6DRes Timecode"})
    device.on_bytes(7, encode_text(PacketType::command, command), now);
  device.capture({}, LabTime{2s});
  device.step(LabTime{3s});
  const auto frame = decode_data(decode_datagram(datagrams.sent.at(0).second)->payload);
  EXPECT_EQ(frame->timecode, (Timecode{CameraTime{102s}}));
  EXPECT_FALSE(frame->bodies.all[0].tracked) << "a body that no camera saw is lost";
}

TEST_F(QualisysDeviceTest, SendsWhenTheLatencyHasPassedAndInOrder) {
  QualisysDevice device{{.jitter_s = 0.02}, server, datagrams};
  device.on_accepted(7, kPeer, now);
  for (const char* command : {"Version 1.25", "StreamFrames AllFrames UDP:50199 6D"})
    device.on_bytes(7, encode_text(PacketType::command, command), now);
  std::uint32_t number = 0;
  for (LabTime t{}; t < LabTime{1s}; t += 1ms) {
    if (t.time_since_epoch() % 5ms == 0ns) device.capture({}, t);
    device.step(t);
    for (const auto& [to, bytes] : std::exchange(datagrams.sent, {})) {
      const auto frame = decode_data(decode_datagram(bytes)->payload);
      EXPECT_EQ(frame->frame_number, ++number);
      const double age_s = seconds(t.time_since_epoch()) - 1e-6 * static_cast<double>(frame->timestamp_us);
      EXPECT_GE(age_s, 0.007);
      EXPECT_LE(age_s, 0.0281);
    }
  }
  EXPECT_GT(number, 190u);
}

TEST_F(QualisysDeviceTest, ServesTenClientsAndTellsTheOthersWhy) {
  for (SessionId id = 2; id <= 12; ++id) dut.on_accepted(id, kPeer, now);
  EXPECT_EQ(dut.clients(), 10u);
  for (const SessionId id : {11u, 12u})
    EXPECT_THAT(server.heard(id), ElementsAre("0:Connection refused. Max number of clients reached."));
  EXPECT_THAT(ask("GetState", 12), IsEmpty());
  dut.step(now);
  EXPECT_THAT(server.closed, IsEmpty()) << "the text shall arrive first";
  dut.step(now + 200ms);
  EXPECT_THAT(server.closed, ElementsAre(11u, 12u));
  dut.on_closed(3, now);
  dut.on_accepted(13, kPeer, now);
  EXPECT_THAT(server.heard(13), ElementsAre("1:QTM RT Interface connected"));
}

TEST_F(QualisysDeviceTest, HasOneMasterAtATime) {
  dut.on_accepted(2, {0x7f000001, 50002}, now);
  server.heard(2);
  EXPECT_THAT(ask("ReleaseControl"), ElementsAre("1:You are already a regular client"));
  EXPECT_THAT(ask("TakeControl secret"), ElementsAre("1:You are now master"));
  EXPECT_THAT(ask("TakeControl"), ElementsAre("1:You are already master"));
  EXPECT_THAT(ask("TakeControl", 2), ElementsAre("0:127.0.0.1 (50001) is already master"));
  EXPECT_THAT(ask("ReleaseControl"), ElementsAre("1:You are now a regular client"));
  EXPECT_THAT(ask("TakeControl", 2), ElementsAre("1:You are now master"));
  dut.on_closed(2, now);
  EXPECT_THAT(ask("TakeControl"), ElementsAre("1:You are now master")) << "control ends with the connection";
}

TEST_F(QualisysDeviceTest, RefusesAFaultItDoesNotKnowAndNamesThoseItDoes) {
  const Status status = dut.set_fault("explode", true);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.fault().reason, Reason::refused);
  for (const char* name : {"off",
                           "stuck",
                           "garbage",
                           "wrong",
                           "slow",
                           "delayed",
                           "intermittent",
                           "silent",
                           "occlude",
                           "residual",
                           "drop_rate",
                           "out_of_sync",
                           "skip_frames",
                           "stop_measurement",
                           "calibrate",
                           "restart",
                           "restart_timestamp",
                           "stuck_frame_number",
                           "close_mid_frame",
                           "half_open",
                           "no_state",
                           "split_header",
                           "split_frame",
                           "oversize",
                           "old_version",
                           "body_list_change",
                           "matrix_by_rows",
                           "other_angles"}) {
    EXPECT_THAT(std::string{status.fault().text}, HasSubstr(name));
    EXPECT_TRUE(dut.set_fault(name, false)) << name;
  }
  EXPECT_FALSE(dut.set_fault("occlude:nobody", true));
  EXPECT_FALSE(dut.set_fault("occlude:", true));
}

TEST_F(QualisysDeviceTest, SurvivesRandomCommands) {
  Random random{29};
  const std::vector<std::string> words = {
      "Version", "1.25",       "StreamFrames",  "AllFrames",  "UDP:5000",        "6DRes",
      "UDP:",    "Stop",       "GetParameters", "All",        "GetCurrentFrame", "\xff\x01",
      ":::::",   "Frequency:", "1e999",         "TakeControl"};
  for (int i = 0; i < 20'000; ++i) {
    std::string text;
    for (std::uint32_t n = random.below(5); n > 0; --n)
      text += words[random.below(static_cast<std::uint32_t>(words.size()))] + (random.chance(0.9) ? " " : "");
    ask(text);
  }
  EXPECT_EQ(dut.clients(), 1u);
}

}  // namespace
}  // namespace motionlab::qualisys
