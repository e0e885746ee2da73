// The driver against a scripted server: every step of the conversation, every reason to refuse.
#include "drivers/qualisys/qualisys_driver.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "drivers/core/random.hpp"

namespace motionlab::qualisys {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

using State = QualisysDriver::State;

constexpr Endpoint kQtm{0xC0A85A10, 49152};
constexpr Endpoint kStranger{0xC0A85A63, 49152};

/// A connection that remembers what was done to it.
class ScriptedStream final : public StreamOut {
 public:
  void open() override { ++opened; }
  Status send(Bytes bytes) override {
    if (broken) return Fault{Reason::transport, "connection is not open"};
    sent.push_back(
        bytes.size() < kPacketHeaderSize ? "?" : std::string{packet_text(bytes.subspan(kPacketHeaderSize))});
    return Done{};
  }
  void close() override { ++closed; }

  /// The commands since the last call.
  std::vector<std::string> commands() { return std::exchange(sent, {}); }

  int opened = 0;
  int closed = 0;
  bool broken = false;
  std::vector<std::string> sent;
};

class QualisysDriverTest : public testing::Test {
 protected:
  static DriverConfig config() {
    DriverConfig c;
    c.bodies = {"load", "platform"};
    c.server_address = kQtm.address;
    c.udp_port = 50199;
    c.latency_s = 0.0;
    return c;
  }

  void say(PacketType type, std::string_view text) { dut.on_bytes(encode_text(type, text), now); }
  void say(Event event) { dut.on_bytes(encode_event(event), now); }
  void answer(std::string_view text) { say(PacketType::command, text); }
  void list(std::vector<BodyDefinition> bodies) {
    say(PacketType::xml, write_parameters_xml({.bodies = true, .body_list = bodies}));
  }
  void step(Nanoseconds by) {
    for (const LabTime end = now + by; now < end;) {
      now += 1ms;
      dut.step(now);
    }
  }

  /// Gets as far as the question for the bodies.
  void greet(Event event = Event::capture_started) {
    dut.step(now);
    dut.on_open(now);
    answer("QTM RT Interface connected");
    answer("Version set to 1.25");
    answer("QTM Version is 2.17 (build 3700)");
    say(event);
  }
  void stream() {
    greet();
    list(both);
    control.commands();
    ASSERT_EQ(dut.state(), State::streaming);
  }

  ByteBuffer frame(std::uint64_t t_us, std::uint32_t number, std::size_t bodies = 2,
                   std::optional<Timecode> timecode = {}) {
    DataFrame f;
    f.timestamp_us = t_us;
    f.frame_number = number;
    f.bodies.size = bodies;
    f.timecode = timecode;
    f.drop_rate = 0.004;
    for (std::size_t i = 0; i < bodies; ++i)
      f.bodies.all[i] = {true, {1.0 + double(i), 2, 3}, {1, 0, 0, 0}, 0.001};
    std::array<std::uint8_t, 8192> buffer{};
    const auto bytes = encode_data(f, {Component::bodies_res, Component::timecode}, buffer);
    return {bytes->begin(), bytes->end()};
  }
  void receive(Bytes datagram, Endpoint from = kQtm) { dut.on_datagram(datagram, from, now); }

  const std::vector<BodyDefinition> both = {{"Platform", true}, {"Load", true}};
  LabTime now = from_ns(1'000'000'000);
  ScriptedStream control;
  std::vector<topic::Bodies> samples;
  QualisysDriver dut{config(), control, [this](const topic::Bodies& s) { samples.push_back(s); }};
};

TEST_F(QualisysDriverTest, IsSilentAndDownBeforeTheFirstStep) {
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().phase(), LinkPhase::down);
  EXPECT_EQ(control.opened, 0);
}

TEST_F(QualisysDriverTest, AsksForTheStreamOfTheMainForm) {
  dut.step(now);
  EXPECT_EQ(control.opened, 1);
  EXPECT_EQ(dut.health().phase(), LinkPhase::connecting);
  dut.on_open(now);
  EXPECT_THAT(control.commands(), IsEmpty()) << "waits for the greeting";
  answer("QTM RT Interface connected.");
  EXPECT_THAT(control.commands(), ElementsAre("Version 1.25"))
      << "a full stop behind the greeting is no fault";
  answer("Version set to 1.25");
  EXPECT_THAT(control.commands(), ElementsAre("QTMVersion"));
  answer("QTM Version is 2.17 (build 3700)");
  EXPECT_THAT(control.commands(), ElementsAre("GetState"));
  EXPECT_EQ(dut.qtm_version(), "QTM Version is 2.17 (build 3700)");
  say(Event::connected);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
  EXPECT_EQ(dut.health().phase(), LinkPhase::connecting);
  list(both);
  EXPECT_THAT(control.commands(), ElementsAre("StreamFrames AllFrames UDP:50199 6DRes Timecode"));
  EXPECT_EQ(dut.state(), State::streaming);
  EXPECT_EQ(dut.health().phase(), LinkPhase::up);
  EXPECT_EQ(dut.health().advice(), "");
  EXPECT_EQ(dut.health().rejected_total(), 0u);
  EXPECT_EQ(dut.health().reconnects(), 0u);
  EXPECT_THAT(samples, IsEmpty()) << "nothing is told before the first frame";
}

TEST_F(QualisysDriverTest, TellsTheWantedBodiesByTheirNames) {
  stream();
  receive(frame(1000, 17));
  ASSERT_EQ(samples.size(), 2u);
  const topic::Bodies& load = samples[0];
  EXPECT_EQ(load.device.view(), "qualisys");
  EXPECT_EQ(load.body.view(), "load");
  EXPECT_TRUE(load.tracked);
  EXPECT_DOUBLE_EQ(load.p_camera_body_m[0], 2.0) << "second in the list";
  EXPECT_DOUBLE_EQ(load.residual_m, 0.001);
  EXPECT_DOUBLE_EQ(load.drop_rate, 0.004);
  EXPECT_EQ(load.frame_number, 17u);
  EXPECT_EQ(load.sequence_number, 1u);
  EXPECT_EQ(load.t_received_ns, to_ns(now));
  EXPECT_EQ(load.t_measured_ns, to_ns(now));
  EXPECT_EQ(samples[1].body.view(), "platform");
  EXPECT_DOUBLE_EQ(samples[1].p_camera_body_m[0], 1.0);
  EXPECT_EQ(dut.health().received(), 1u);
}

TEST_F(QualisysDriverTest, SaysWhichWantedBodyQtmDoesNotKnowOrHasDisabled) {
  greet();
  list({{"Platform", true}});
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("'load'"));
  receive(frame(1000, 1, 1));
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_FALSE(samples[0].tracked) << "told all the same, as lost";
  EXPECT_TRUE(samples[1].tracked);
  say(Event::camera_settings_changed);
  list({{"Platform", false}, {"Load", true}});
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("'platform' is disabled"));
}

TEST_F(QualisysDriverTest, RefusesEveryKindOfBadDatagramAndLivesOn) {
  stream();
  const ByteBuffer good = frame(1000, 1);
  receive(good, kStranger);
  EXPECT_EQ(dut.health().rejected(Reason::foreign), 1u);
  receive(Bytes{good}.first(good.size() - 1));
  EXPECT_EQ(dut.health().rejected(Reason::too_short), 1u);
  ByteBuffer longer = good;
  longer.push_back(0);
  receive(longer);
  EXPECT_EQ(dut.health().rejected(Reason::too_long), 1u);
  receive(encode_text(PacketType::command, "not a frame"));
  EXPECT_EQ(dut.health().rejected(Reason::bad_header), 1u);
  ByteBuffer bad_matrix = good;
  store<std::endian::little>(MutableBytes{bad_matrix}.subspan(0x34), 9.0f);
  receive(bad_matrix);
  EXPECT_EQ(dut.health().rejected(Reason::bad_value), 1u);
  std::array<std::uint8_t, 64> buffer{};
  receive(*encode_data(DataFrame{}, {}, buffer));
  EXPECT_EQ(dut.health().rejected(Reason::unexpected), 1u);
  EXPECT_THAT(samples, IsEmpty());
  receive(good);
  EXPECT_EQ(samples.size(), 2u);
  receive(good);
  EXPECT_EQ(dut.health().rejected(Reason::duplicate), 1u);
  receive(frame(900, 0));
  EXPECT_EQ(dut.health().rejected(Reason::out_of_order), 1u);
  EXPECT_EQ(samples.size(), 2u);
  EXPECT_EQ(dut.health().received(), 1u);
  EXPECT_EQ(control.closed, 0);
}

TEST_F(QualisysDriverTest, RefusesFramesThatComeBeforeTheyWereAskedFor) {
  greet();
  receive(frame(1000, 1));
  EXPECT_EQ(dut.health().rejected(Reason::unexpected), 1u);
  EXPECT_THAT(samples, IsEmpty());
}

TEST_F(QualisysDriverTest, CountsGapsOfTheFrameNumberAndToleratesOneThatStandsStill) {
  stream();
  receive(frame(1000, 10));
  receive(frame(2000, 14));
  EXPECT_EQ(dut.health().lost(), 3u);
  receive(frame(3000, 1));
  receive(frame(4000, 1));
  EXPECT_EQ(dut.health().lost(), 3u);
  EXPECT_EQ(dut.health().received(), 4u);
}

TEST_F(QualisysDriverTest, BelievesATimeStampThatStartsAgainWhenTwoFramesSaySo) {
  stream();
  receive(frame(100'000'000, 20000));
  now += 5ms;
  receive(frame(0, 1));
  EXPECT_EQ(samples.size(), 2u) << "may be a very late datagram";
  now += 5ms;
  receive(frame(5'000, 2));
  EXPECT_EQ(samples.size(), 4u);
  EXPECT_EQ(samples.back().t_measured_ns, to_ns(now)) << "the time was mapped afresh";
  EXPECT_EQ(dut.health().rejected(Reason::out_of_order), 1u);
  EXPECT_EQ(dut.health().lost(), 0u);
}

TEST_F(QualisysDriverTest, IsNotFooledByLateFramesAmongPresentOnes) {
  stream();
  for (std::uint32_t i = 0; i < 10; ++i) {
    now += 5ms;
    receive(frame(100'000'000 + 5000 * i, 20000 + i));
    receive(frame(5000 * i, 1 + i));
  }
  EXPECT_EQ(samples.size(), 20u);
  EXPECT_EQ(dut.health().rejected(Reason::out_of_order), 10u);
}

TEST_F(QualisysDriverTest, PrefersTheCameraTimeWhenItComes) {
  stream();
  const auto camera = [](std::int64_t ns) { return Timecode{CameraTime{Nanoseconds{ns}}}; };
  receive(frame(5'000, 1, 2, camera(70'000'000)));
  EXPECT_EQ(samples.back().t_measured_ns, to_ns(now));
  // 10 ms later by the clock of the camera, 5 ms by the time stamp; arrived 2 ms late.
  const LabTime first = now;
  now += 12ms;
  receive(frame(10'000, 2, 2, camera(80'000'000)));
  EXPECT_NEAR(static_cast<double>(samples.back().t_measured_ns), static_cast<double>(to_ns(first + 10ms)),
              1e4);
}

TEST_F(QualisysDriverTest, SubtractsTheConfiguredLatency) {
  DriverConfig c = config();
  c.latency_s = 0.007;
  std::vector<topic::Bodies> told;
  QualisysDriver driver{c, control, [&](const topic::Bodies& s) { told.push_back(s); }};
  driver.step(now);
  driver.on_open(now);
  for (const char* text :
       {"QTM RT Interface connected", "Version set to 1.25", "QTM Version is 2.17 (build 1)"})
    driver.on_bytes(encode_text(PacketType::command, text), now);
  driver.on_bytes(encode_event(Event::connected), now);
  driver.on_bytes(encode_text(PacketType::xml, write_parameters_xml({.bodies = true, .body_list = both})),
                  now);
  driver.on_datagram(frame(1, 1), kQtm, now);
  ASSERT_EQ(told.size(), 2u);
  EXPECT_EQ(told[0].t_measured_ns, to_ns(now - 7ms));
}

TEST_F(QualisysDriverTest, SaysOnceThatBodiesAreLostWhenFramesStop) {
  stream();
  receive(frame(1000, 5));
  const auto t_last = samples.back().t_measured_ns;
  step(25ms);
  EXPECT_EQ(samples.size(), 2u);
  step(1ms);
  ASSERT_EQ(samples.size(), 4u);
  EXPECT_FALSE(samples[2].tracked);
  EXPECT_EQ(samples[2].p_camera_body_m, (std::array<double, 3>{}));
  EXPECT_EQ(samples[2].t_measured_ns, t_last + 5'000'000)
      << "stamped with the first exposure that is missing";
  EXPECT_EQ(samples[2].sequence_number, 2u);
  step(500ms);
  EXPECT_EQ(samples.size(), 4u);
  receive(frame(6000, 6));
  EXPECT_TRUE(samples.back().tracked);
}

TEST_F(QualisysDriverTest, AsksForTheStateWhenFramesStopAndAgainForTheStream) {
  stream();
  receive(frame(1000, 5));
  step(1ms);
  EXPECT_THAT(control.commands(), ElementsAre("GetCurrentFrame 6D 6DEuler"));
  step(998ms);
  EXPECT_THAT(control.commands(), IsEmpty());
  step(1ms);
  EXPECT_THAT(control.commands(), ElementsAre("GetState"));
  say(Event::capture_started);
  EXPECT_THAT(control.commands(), ElementsAre("StreamFrames AllFrames UDP:50199 6DRes Timecode"));
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("firewall"));
  receive(frame(2000, 6));
  EXPECT_EQ(dut.health().advice(), "");
}

TEST_F(QualisysDriverTest, ConnectsAgainWhenTheStateIsNotAnswered) {
  stream();
  receive(frame(1000, 5));
  step(3000ms);
  EXPECT_EQ(dut.state(), State::streaming);
  step(1ms);
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(control.closed, 1);
  EXPECT_EQ(dut.health().rejected(Reason::transport), 1u);
  step(500ms);
  EXPECT_EQ(control.opened, 2);
  EXPECT_EQ(dut.health().reconnects(), 0u);
  dut.on_open(now);
  EXPECT_EQ(dut.health().reconnects(), 1u);
}

TEST_F(QualisysDriverTest, GivesUpAnyQuestionThatIsNotAnsweredWithinTwoSeconds) {
  const std::vector<std::string_view> answers = {"QTM RT Interface connected", "Version set to 1.25",
                                                 "QTM Version is 2.17 (build 3700)"};
  // -1: not even the connection; then one answer more each time; 4: the list of bodies is missing.
  for (int given = -1; given <= 4; ++given) {
    ScriptedStream stream_out;
    QualisysDriver driver{config(), stream_out, [](const topic::Bodies&) {}};
    LabTime t{};
    driver.step(t);
    if (given >= 0) driver.on_open(t);
    for (int i = 0; i < std::min(given, 3); ++i)
      driver.on_bytes(encode_text(PacketType::command, answers[static_cast<std::size_t>(i)]), t);
    if (given == 4) driver.on_bytes(encode_event(Event::connected), t);
    driver.step(t + 2s);
    EXPECT_NE(driver.state(), State::down) << given;
    driver.step(t + 2001ms);
    EXPECT_EQ(driver.state(), State::down) << given;
    EXPECT_NE(driver.health().advice(), "") << given;
    EXPECT_EQ(driver.health().rejected(Reason::transport), 1u);
  }
}

TEST_F(QualisysDriverTest, DoesNotWaitForTheRestOfAPacketForEver) {
  stream();
  dut.on_bytes(Bytes{encode_text(PacketType::xml, "a long one")}.first(10), now);
  for (std::uint32_t i = 1; i <= 2000; ++i) {  // frames go on all the while
    step(1ms);
    receive(frame(1000 * i, i));
  }
  EXPECT_EQ(dut.state(), State::streaming);
  step(1ms);
  EXPECT_EQ(dut.state(), State::down);
}

TEST_F(QualisysDriverTest, ConnectsAgainAfterAPacketSizeThatCannotBe) {
  stream();
  const ByteBuffer nonsense = {1, 0, 0, 0, 0, 0, 0, 0};
  dut.on_bytes(nonsense, now);
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().rejected(Reason::bad_header), 1u);
}

TEST_F(QualisysDriverTest, WaitsLongerAfterEveryFailedAttempt) {
  dut.step(now);
  std::vector<double> pauses_s;
  for (int attempt = 0; attempt < 6; ++attempt) {
    dut.on_closed("connection refused", now);
    const LabTime closed_at = now;
    for (const int before = control.opened; control.opened == before;) step(1ms);
    pauses_s.push_back(seconds(now - closed_at));
  }
  EXPECT_THAT(pauses_s, ElementsAre(0.5, 1.0, 2.0, 4.0, 5.0, 5.0));
  dut.on_open(now);
  answer("QTM RT Interface connected");
  answer("Version set to 1.25");
  answer("QTM Version is 2.17 (build 3700)");
  say(Event::connected);
  list(both);
  dut.on_closed("closed by the peer", now);
  const int before = control.opened;
  step(500ms);
  EXPECT_EQ(control.opened, before + 1) << "success makes it patient again";
}

TEST_F(QualisysDriverTest, SaysThatQtmHasTooManyClients) {
  dut.step(now);
  dut.on_open(now);
  say(PacketType::error, "Connection refused. Max number of clients reached.");
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().rejected(Reason::refused), 1u);
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("too many clients"));
}

TEST_F(QualisysDriverTest, RefusesAGreetingThatIsNotQtms) {
  dut.step(now);
  dut.on_open(now);
  answer("SSH-2.0-OpenSSH");
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().rejected(Reason::bad_header), 1u);
}

TEST_F(QualisysDriverTest, GoesDownTheVersionsUntilOneIsSpoken) {
  dut.step(now);
  dut.on_open(now);
  answer("QTM RT Interface connected");
  for (int minor = 25; minor > 21; --minor) {
    EXPECT_THAT(control.commands(), ElementsAre("Version 1." + std::to_string(minor)));
    // The documentation does not say by which kind of packet a version is refused.
    say(minor % 2 == 0 ? PacketType::command : PacketType::error, "Version NOT supported");
  }
  EXPECT_THAT(control.commands(), ElementsAre("Version 1.21"));
  answer("Version set to 1.21");
  EXPECT_EQ(dut.state(), State::qtm_version);
  EXPECT_EQ(dut.version_minor(), 21);
  EXPECT_EQ(dut.health().rejected_total(), 0u) << "to negotiate is no fault";
}

TEST_F(QualisysDriverTest, FailsClearlyWhenNoVersionIsSpokenAndBeginsAtTheTopAgain) {
  dut.step(now);
  dut.on_open(now);
  answer("QTM RT Interface connected");
  for (int refusal = 0; refusal < 5; ++refusal) say(PacketType::error, "Version NOT supported");
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().rejected(Reason::refused), 1u);
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("1.25 to 1.21"));
  step(500ms);
  dut.on_open(now);
  control.commands();
  answer("QTM RT Interface connected");
  EXPECT_THAT(control.commands(), ElementsAre("Version 1.25"));
}

TEST_F(QualisysDriverTest, RefusesAVersionThatItDidNotAskFor) {
  dut.step(now);
  dut.on_open(now);
  answer("QTM RT Interface connected");
  answer("Version set to 1.2");
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().rejected(Reason::refused), 1u);
}

TEST_F(QualisysDriverTest, DoesWithoutTheVersionOfQtm) {
  dut.step(now);
  dut.on_open(now);
  answer("QTM RT Interface connected");
  answer("Version set to 1.25");
  say(PacketType::error, "Parse error");
  EXPECT_EQ(dut.state(), State::get_state);
  EXPECT_EQ(dut.qtm_version(), "");
}

TEST_F(QualisysDriverTest, StaysConnectedWhenNothingIsMeasuredAndStartsWhenItIs) {
  greet(Event::connection_closed);
  list(both);
  EXPECT_EQ(dut.state(), State::idle);
  EXPECT_EQ(dut.health().phase(), LinkPhase::up);
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("does not measure"));
  control.commands();
  step(1000ms);
  EXPECT_THAT(control.commands(), ElementsAre("GetState")) << "a sign of life";
  say(Event::connection_closed);
  EXPECT_EQ(dut.state(), State::idle);
  say(Event::rt_from_file_started);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
  list(both);
  EXPECT_THAT(control.commands(), ElementsAre("StreamFrames AllFrames UDP:50199 6DRes Timecode"));
  EXPECT_EQ(dut.health().advice(), "");
}

TEST_F(QualisysDriverTest, LosesAllBodiesWhenTheMeasurementEnds) {
  stream();
  for (const Event end : {Event::capture_stopped, Event::connection_closed, Event::rt_from_file_stopped,
                          Event::calibration_started, Event::calibration_stopped}) {
    samples.clear();
    receive(frame(1000, 1));
    say(end);
    ASSERT_EQ(samples.size(), 4u);
    EXPECT_FALSE(samples[2].tracked);
    EXPECT_FALSE(samples[3].tracked);
    EXPECT_EQ(dut.state(), State::idle);
    EXPECT_THAT(control.commands(), IsEmpty());
    say(Event::capture_started);
    list(both);
    control.commands();
  }
  EXPECT_EQ(control.closed, 0);
}

TEST_F(QualisysDriverTest, TakesNoMoreDataForTheEndOverEitherTransport) {
  stream();
  receive(frame(1000, 1));
  receive(encode_no_more_data());
  EXPECT_EQ(dut.state(), State::idle);
  EXPECT_EQ(samples.size(), 4u);
  say(Event::capture_started);
  list(both);
  EXPECT_EQ(dut.state(), State::streaming);
  dut.on_bytes(encode_no_more_data(), now);
  EXPECT_EQ(dut.state(), State::idle);
}

TEST_F(QualisysDriverTest, ReadsAllAgainWhenANewMeasurementBegins) {
  stream();
  receive(frame(900'000'000, 1000));
  say(Event::capture_started);
  EXPECT_FALSE(samples.back().tracked);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
  list({{"Load", true}, {"Platform", true}});
  EXPECT_THAT(control.commands(), ElementsAre("StreamFrames AllFrames UDP:50199 6DRes Timecode"));
  samples.clear();
  receive(frame(0, 1));
  ASSERT_EQ(samples.size(), 2u) << "a new measurement's stamps are believed at once";
  EXPECT_DOUBLE_EQ(samples[0].p_camera_body_m[0], 1.0) << "the order of the new list counts";
  EXPECT_EQ(dut.health().lost(), 0u);
}

TEST_F(QualisysDriverTest, ReadsTheListAgainAfterAChangeOfSettings) {
  stream();
  receive(frame(1000, 1));
  say(Event::camera_settings_changed);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
  receive(frame(2000, 2));
  EXPECT_EQ(samples.size(), 2u) << "whose pose is it? not told";
  EXPECT_EQ(dut.health().rejected(Reason::unexpected), 1u);
  list(both);
  EXPECT_THAT(control.commands(), IsEmpty()) << "the stream goes on by itself";
  EXPECT_EQ(samples.size(), 2u) << "same list: nothing was lost";
  say(Event::camera_settings_changed);
  list({{"Load", true}, {"Platform", true}});
  EXPECT_EQ(samples.size(), 4u) << "another list: lost until the next frame";
  receive(frame(3000, 3));
  EXPECT_DOUBLE_EQ(samples[4].p_camera_body_m[0], 1.0);
}

TEST_F(QualisysDriverTest, AsksOnceMoreWhenTheListChangesWhileItIsBeingRead) {
  stream();
  say(Event::camera_settings_changed);
  say(Event::camera_settings_changed);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
  list(both);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
  list(both);
  EXPECT_EQ(dut.state(), State::streaming);
}

TEST_F(QualisysDriverTest, LosesAllBodiesAndReadsTheListWhenTheirNumberIsWrong) {
  stream();
  receive(frame(1000, 1));
  step(1s);
  control.commands();
  receive(frame(2000, 2, 3));
  EXPECT_EQ(dut.health().rejected(Reason::bad_value), 1u);
  EXPECT_EQ(samples.size(), 4u);
  EXPECT_FALSE(samples.back().tracked);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
  list(both);
  receive(frame(3000, 3, 3));
  EXPECT_THAT(control.commands(), IsEmpty()) << "not again within a second";
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("another number of bodies"));
  receive(frame(4000, 4, 2));
  EXPECT_EQ(dut.health().advice(), "");
}

TEST_F(QualisysDriverTest, TriesAgainWhenQtmHasNoListOfBodies) {
  greet();
  say(PacketType::error, "Parameters not available");
  EXPECT_EQ(dut.state(), State::idle);
  EXPECT_EQ(dut.health().rejected(Reason::refused), 1u);
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("no list"));
  control.commands();
  step(1s);
  EXPECT_THAT(control.commands(), ElementsAre("GetState"));
  say(Event::capture_started);
  EXPECT_THAT(control.commands(), ElementsAre("GetParameters 6D"));
}

TEST_F(QualisysDriverTest, ConnectsAgainAfterAListThatIsNotXml) {
  greet();
  say(PacketType::xml, "<broken");
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().rejected(Reason::bad_header), 1u);
}

TEST_F(QualisysDriverTest, CountsAnswersNobodyAskedFor) {
  stream();
  answer("Event set");
  list(both);
  dut.on_bytes(frame(1000, 1), now);  // the stream was asked for by datagram
  EXPECT_EQ(dut.health().rejected(Reason::unexpected), 3u);
  say(PacketType::error, "Parse error");
  EXPECT_EQ(dut.health().rejected(Reason::refused), 1u);
  const ByteBuffer bad_event = {10, 0, 0, 0, 6, 0, 0, 0, 1, 1};
  dut.on_bytes(bad_event, now);
  EXPECT_EQ(dut.health().rejected(Reason::too_long), 1u);
  say(Event::trigger);
  say(Event::capture_saved);
  EXPECT_EQ(dut.state(), State::streaming) << "these say nothing about the measurement";
  EXPECT_THAT(samples, IsEmpty());
}

TEST_F(QualisysDriverTest, DistrustsDatagramsOnceTheConnectionIsLost) {
  stream();
  receive(frame(1000, 1));
  dut.on_closed("closed by the peer", now);
  EXPECT_EQ(dut.health().phase(), LinkPhase::down);
  EXPECT_EQ(samples.size(), 4u);
  EXPECT_FALSE(samples.back().tracked);
  receive(frame(2000, 2));
  EXPECT_EQ(samples.size(), 4u);
  EXPECT_EQ(dut.health().rejected(Reason::unexpected), 1u);
}

TEST_F(QualisysDriverTest, ConnectsAgainWhenQtmShutsDown) {
  stream();
  receive(frame(1000, 1));
  say(Event::shutting_down);
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_FALSE(samples.back().tracked);
  EXPECT_THAT(std::string{dut.health().advice()}, HasSubstr("start it again"));
}

TEST_F(QualisysDriverTest, ConnectsAgainWhenSendingFails) {
  dut.step(now);
  dut.on_open(now);
  control.broken = true;
  answer("QTM RT Interface connected");
  EXPECT_EQ(dut.state(), State::down);
  EXPECT_EQ(dut.health().rejected(Reason::transport), 1u);
}

TEST_F(QualisysDriverTest, TakesTheStreamOverTheConnectionWhenThereIsNoUdpPort) {
  DriverConfig c = config();
  c.udp_port = 0;
  std::vector<topic::Bodies> told;
  QualisysDriver driver{c, control, [&](const topic::Bodies& s) { told.push_back(s); }};
  driver.step(now);
  driver.on_open(now);
  for (const char* text :
       {"QTM RT Interface connected", "Version set to 1.25", "QTM Version is 2.17 (build 1)"})
    driver.on_bytes(encode_text(PacketType::command, text), now);
  driver.on_bytes(encode_event(Event::connected), now);
  driver.on_bytes(encode_text(PacketType::xml, write_parameters_xml({.bodies = true, .body_list = both})),
                  now);
  EXPECT_EQ(control.sent.back(), "StreamFrames AllFrames 6DRes Timecode");
  driver.on_bytes(frame(1000, 1), now);
  EXPECT_EQ(told.size(), 2u);
}

TEST_F(QualisysDriverTest, SurvivesARandomServer) {
  Random random{23};
  const std::vector<ByteBuffer> packets = {
      encode_text(PacketType::command, kWelcome),
      encode_text(PacketType::command, "Version set to 1.25"),
      encode_text(PacketType::command, "QTM Version is 2.17 (build 3700)"),
      encode_text(PacketType::error, "Parse error"),
      encode_event(Event::connected),
      encode_event(Event::capture_stopped),
      encode_event(Event::camera_settings_changed),
      encode_event(Event::shutting_down),
      encode_no_more_data(),
      encode_text(PacketType::xml, write_parameters_xml({.bodies = true, .body_list = both})),
      encode_text(PacketType::xml, "<QTM_Parameters_Ver_1.25/>"),
  };
  const auto count = static_cast<std::uint32_t>(packets.size());
  std::uint64_t t_us = 0;
  for (int i = 0; i < 100'000; ++i) {
    now += Nanoseconds{random.below(20'000'000)};
    switch (random.below(8)) {
      case 0:
        dut.on_open(now);
        break;
      case 1:
        if (random.chance(0.05)) dut.on_closed("connection reset", now);
        break;
      case 2: {
        ByteBuffer bytes = packets[random.below(count)];
        if (random.chance(0.02)) bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^= 0x40;
        dut.on_bytes(bytes, now);
        break;
      }
      case 3:
        receive(frame(t_us += random.below(10'000), static_cast<std::uint32_t>(i), random.below(4)));
        break;
      case 4: {
        // What this state waits for, so that the conversation gets far again and again.
        const auto state = static_cast<std::size_t>(dut.state());
        if (state >= 2 && state <= 4) dut.on_bytes(packets[state - 2], now);
        if (dut.state() == State::get_state) say(Event::connected);
        if (dut.state() == State::bodies) list(both);
        break;
      }
      default:
        dut.step(now);
    }
  }
  EXPECT_GT(dut.health().received(), 100u);
  EXPECT_GT(dut.health().reconnects(), 10u);
}

}  // namespace
}  // namespace motionlab::qualisys
