// A recorded run is run again, and comes out the same or is said where it does not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "gateway/record/mcap_reader.hpp"
#include "gateway/record/mcap_writer.hpp"
#include "gateway/record/run_recorder.hpp"
#include "gateway/service/replay.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using testing::HasSubstr;

class Replay : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              ("motionlab-replay-" + std::to_string(getpid()) + "-" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// A configuration that is recorded; what is set after reading would not stand in the recording.
  lockstep::Config recorded(const std::string& name, std::uint32_t outputs_every = 1) const {
    lockstep::Config config = configure("sea", 3);
    config.gateway.record.inputs = (folder_ / name).string();
    config.gateway.record.outputs_every = outputs_every;
    return config;
  }

  /// Records 1.5 s, with a request and a reference that asks for nothing possible.
  std::filesystem::path record_briefly(std::uint32_t outputs_every = 1) const {
    lockstep::Lockstep line(recorded("brief.mcap", outputs_every));
    auto references = line.bus().advertise<topic::Reference>();
    while (line.now() < LabTime{} + 1500ms) {
      if (line.now() == LabTime{} + 500ms) line.request(topic::ModeAction::engage);
      if (line.now() == LabTime{} + 700ms) {
        topic::Reference reference;
        reference.p_world_load_m[0] = std::numeric_limits<double>::quiet_NaN();
        references.publish(reference);
      }
      line.step();
    }
    line.finish_recording();
    return folder_ / "brief.mcap";
  }

  /// What a copy does with a message: changes it, or drops it when false.
  using Change = std::function<bool(std::string_view topic, std::uint64_t nth, ByteBuffer& data)>;

  /// Copies a recording with changes.
  std::filesystem::path changed(const std::filesystem::path& from, const Change& change) const {
    std::ifstream in(from, std::ios::binary);
    std::ofstream out(folder_ / "changed.mcap", std::ios::binary);
    record::McapReader reader(in);
    record::McapWriter writer(out);
    std::map<std::string, record::ChannelId> channels;
    std::map<std::string, std::uint64_t> counts;
    for (;;) {
      const auto item = reader.next();
      EXPECT_TRUE(item);
      if (!item || !item->has_value()) break;
      if (const auto* message = std::get_if<record::McapMessage>(&**item)) {
        const std::string& topic = message->channel->topic;
        if (!channels.contains(topic)) channels[topic] = writer.add_channel(topic, "cdr", 0);
        ByteBuffer data(message->data.begin(), message->data.end());
        if (!change(topic, counts[topic]++, data)) continue;
        const LabTime t = from_ns(static_cast<std::int64_t>(message->logged_ns));
        writer.message(channels[topic], message->sequence, t, t, data);
      } else if (const auto* attachment = std::get_if<record::McapAttachment>(&**item)) {
        writer.attachment(attachment->name, attachment->media_type, LabTime{}, attachment->data);
      } else {
        writer.metadata(std::get<record::McapMetadata>(**item).name,
                        std::get<record::McapMetadata>(**item).values);
      }
    }
    writer.finish();
    return folder_ / "changed.mcap";
  }

  static std::string refusal(const std::filesystem::path& file) {
    try {
      return "not refused: " + service::describe(service::replay(file));
    } catch (const StartupError& error) {
      return error.what();
    }
  }

  std::filesystem::path folder_;
};

TEST_F(Replay, AWholeRunWithEngagingFaultAndRecoveryComesOutTheSame) {
  lockstep::Config config = recorded("run.mcap", 20);
  config.faults.push_back(lab::PlannedFault::parse("qualisys:loss=0.3@6..8"));
  config.faults.push_back(lab::PlannedFault::parse("mru1:silent@10..11"));
  lockstep::Lockstep line(config);
  const auto mode = line.bus().reader<topic::Mode>();
  const auto run_to = [&](LabTime end) {
    while (line.now() < end) line.step();
  };
  run_to(LabTime{} + 5s);
  line.request(topic::ModeAction::engage);
  run_to(LabTime{} + 9s);
  ASSERT_EQ(mode.newest()->state, topic::ModeState::engaged) << mode.newest()->reason.view();
  run_to(LabTime{} + 12s);
  ASSERT_EQ(mode.newest()->state, topic::ModeState::fault);
  line.request(topic::ModeAction::reset);
  run_to(LabTime{} + 15s);
  line.finish_recording();

  const auto outcome = service::replay(folder_ / "run.mcap");
  EXPECT_FALSE(outcome.difference) << service::describe(outcome);
  EXPECT_FALSE(outcome.cut_off);
  EXPECT_EQ(outcome.steps, 15'000U);
  EXPECT_GE(outcome.outputs_compared, 4 * 15'000U / 20);
}

TEST_F(Replay, TheSameRunIsTheSameFile) {
  const auto bytes = [](const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string first = bytes(record_briefly());
  const std::string second = bytes(record_briefly());
  EXPECT_GT(first.size(), 10'000U);
  EXPECT_TRUE(first == second);
}

TEST_F(Replay, EachTopicIsComparedAndTheFirstDifferenceNamed) {
  const auto file = record_briefly();
  EXPECT_FALSE(service::replay(file).difference);
  // The last bit of a sample's last number, in the recording of step 1001.
  const std::pair<const char*, const char*> last_fields[] = {
      {"motionlab/estimate", "p_world_second_sd_m[2]"},
      {"motionlab/winch_command", "wire_acceleration_wanted_mps2"},
      {"motionlab/arm_command", "qd_wanted_radps[5]"}};
  for (const auto& [topic, field] : last_fields) {
    const auto outcome = service::replay(changed(file, [&](auto of, auto nth, auto& data) {
      if (of == topic && nth == 1000) data[data.size() - 8] ^= 1;
      return true;
    }));
    ASSERT_TRUE(outcome.difference) << topic;
    EXPECT_EQ(outcome.difference->step, 1001U);
    EXPECT_EQ(outcome.difference->t, LabTime{} + 1001ms);
    EXPECT_EQ(outcome.difference->topic, topic);
    EXPECT_EQ(outcome.difference->field, field);
    EXPECT_NE(outcome.difference->recorded, outcome.difference->replayed);
    EXPECT_THAT(service::describe(outcome), HasSubstr(field));
  }
}

TEST_F(Replay, AnInputThatIsOneBitOffIsNoticed) {
  const auto file = record_briefly();
  const auto outcome = service::replay(changed(file, [](auto of, auto nth, auto& data) {
    topic::Snapshot inputs;
    if (of != "motionlab/snapshot" || nth < 1000 || nth > 1010 || !record::read_cdr(data, inputs))
      return true;
    if (inputs.mru.empty()) return true;
    topic::Mru mru = inputs.mru.back();
    // Each of them: rounding may swallow the last bit of one.
    for (double& v : mru.omega_mru_radps) v = std::nextafter(v, 1.0);
    for (double& v : mru.euler_heading_mru_rad) v = std::nextafter(v, 1.0);
    for (double& v : mru.a_heading_origin_mps2) v = std::nextafter(v, 1.0);
    inputs.mru.clear();
    inputs.mru.push(mru);
    data.resize(record::RunTape::kLargestStep);
    data.resize(record::write_cdr(inputs, data));
    return true;
  }));
  ASSERT_TRUE(outcome.difference);
  EXPECT_EQ(outcome.difference->topic, "motionlab/estimate");
  EXPECT_GE(outcome.difference->step, 1001U);
  EXPECT_LE(outcome.difference->step, 1011U);
}

TEST_F(Replay, WhereFewOutputsAreKeptTheChecksumTellsTheStepAndTheNextSampleTheField) {
  const auto file = record_briefly(100);
  EXPECT_FALSE(service::replay(file).difference);
  const auto outcome = service::replay(changed(file, [](auto of, auto nth, auto& data) {
    topic::Snapshot inputs;
    if (of != "motionlab/snapshot" || nth < 1050 || nth >= 1060 || !record::read_cdr(data, inputs))
      return true;
    if (inputs.arm.empty()) return true;
    topic::ArmState arm = inputs.arm.back();
    arm.q_rad[0] += 1e-3;
    inputs.arm.clear();
    inputs.arm.push(arm);
    data.resize(record::RunTape::kLargestStep);
    data.resize(record::write_cdr(inputs, data));
    return true;
  }));
  ASSERT_TRUE(outcome.difference);
  EXPECT_GE(outcome.difference->since_step, 1051U);
  EXPECT_LE(outcome.difference->since_step, 1060U);
  EXPECT_EQ(outcome.difference->step, 1101U);
  EXPECT_EQ(outcome.difference->topic, "motionlab/estimate");
}

TEST_F(Replay, ASampleMoreOrLessIsADifference) {
  const auto file = record_briefly();
  const auto fewer = service::replay(changed(
      file, [](auto of, auto nth, auto&) { return !(of == "motionlab/winch_command" && nth == 700); }));
  ASSERT_TRUE(fewer.difference);
  EXPECT_EQ(fewer.difference->step, 701U);
  const auto none =
      service::replay(changed(file, [](auto of, auto, auto&) { return of != "motionlab/event"; }));
  ASSERT_TRUE(none.difference);
}

TEST_F(Replay, ARecordingThatWasCutOffIsReplayedUpToThere) {
  const auto file = record_briefly();
  std::filesystem::resize_file(file, std::filesystem::file_size(file) * 2 / 3);
  const auto outcome = service::replay(file);
  EXPECT_FALSE(outcome.difference) << service::describe(outcome);
  EXPECT_TRUE(outcome.cut_off);
  EXPECT_GT(outcome.steps, 400U);
  EXPECT_LT(outcome.steps, 1500U);
  EXPECT_THAT(service::describe(outcome), HasSubstr("cut off"));
}

TEST_F(Replay, ARecordingThatCannotBeRunAgainIsRefusedWithTheReason) {
  EXPECT_THAT(refusal(folder_ / "nowhere.mcap"), HasSubstr("cannot be read"));
  std::ofstream(folder_ / "text.mcap") << "no recording at all";
  EXPECT_THAT(refusal(folder_ / "text.mcap"), HasSubstr("not an MCAP file"));

  const auto file = record_briefly();
  EXPECT_THAT(refusal(changed(file, [](auto of, auto, auto&) { return of != "motionlab/snapshot"; })),
              HasSubstr("no control step"));
  EXPECT_THAT(
      refusal(changed(file, [](auto of, auto nth, auto&) { return of != "motionlab/snapshot" || nth != 9; })),
      HasSubstr("has step 11 where step 10 should be"));
  EXPECT_THAT(refusal(changed(file,
                              [](auto of, auto nth, auto& data) {
                                if (of == "motionlab/snapshot" && nth == 9) data.resize(data.size() / 2);
                                return true;
                              })),
              HasSubstr("damaged at step 10"));

  // Another file with an attachment and metadata, but of something else.
  {
    std::ofstream out(folder_ / "other.mcap", std::ios::binary);
    record::McapWriter writer(out);
    ByteBuffer data(record::RunTape::kLargestStep);
    topic::Snapshot inputs;
    inputs.sequence_number = 1;
    data.resize(record::write_cdr(inputs, data));
    writer.message(writer.add_channel("motionlab/snapshot", "cdr", 0), 0, LabTime{}, LabTime{}, data);
    writer.finish();
  }
  EXPECT_THAT(refusal(folder_ / "other.mcap"), HasSubstr("no configuration"));
}

TEST_F(Replay, ARecordingWithAGapIsRefused) {
  const service::GatewayConfig gateway = configure("calm").gateway;
  record::RunTape tape(1, 32 * 1024);
  record::RunRecorder recorder(folder_ / "gap.mcap", tape, gateway.effective);
  bus::LocalBus local;
  service::ArmSchedule schedule;
  service::ControlLoop loop(gateway, local, schedule, {}, {}, &tape);
  for (int i = 1; i <= 200; ++i) {
    loop.step(LabTime{} + 1ms * i);
    if (i < 10 || i > 100) (void)recorder.drain();  // the writer sleeps for 90 ms
  }
  recorder.finish();
  ASSERT_GT(tape.lost(), 0U);
  EXPECT_THAT(refusal(folder_ / "gap.mcap"),
              HasSubstr("has a gap: " + std::to_string(tape.lost()) + " control steps before step"));
}

}  // namespace
}  // namespace motionlab::integration
