#include "simulators/lab/fault_matrix/report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "drivers/core/error.hpp"
#include "simulators/lab/fault_matrix/table.hpp"

namespace motionlab::matrix {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Matrix one() {
  Outcome o;
  o.in_state = true;
  o.ending = Ending::rests;
  o.code = "mru1_stale";
  o.detected_after_s = 0.02;
  o.detected_by = "mode mru1_stale";
  o.at_rest_after_s = 0.4;
  o.swing_max_deg = 2;
  o.swing_rms_deg = 1;
  o.twin_swing_max_deg = 3;
  o.overshoot.joint_speed = 0.5;
  o.advised = true;
  Matrix matrix;
  matrix.emplace_back();
  matrix.back().cell.fault = {"mru1", "off", Program::hardened};
  matrix.back().cell.state = State::sea;
  matrix.back().outcome = o;
  return matrix;
}

TEST(FaultMatrix, ComesBackFromItsFile) {
  Matrix matrix = one();
  matrix.push_back({{{"arm", "cut", Program::faithful}, State::settled}, {}});
  const Matrix back = from_json(to_json(matrix));
  ASSERT_EQ(back.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(back[i].cell, matrix[i].cell);
    EXPECT_EQ(back[i].outcome, matrix[i].outcome);
  }
}

TEST(FaultMatrix, RefusesAFileThatIsNone) {
  EXPECT_THROW((void)from_json("[{"), StartupError);
  EXPECT_THROW((void)from_json("[{\"device\": \"mru1\"}]"), StartupError);
}

TEST(FaultMatrix, IsNotWorseThanItselfNorThanWorse) {
  EXPECT_THAT(worse(one(), one()), IsEmpty());
  Matrix later = one();
  later[0].outcome.at_rest_after_s = 2;
  EXPECT_THAT(worse(one(), later), IsEmpty());
}

TEST(FaultMatrix, SaysWhatGotWorse) {
  const auto offence = [](auto change) {
    Matrix now = one();
    change(now[0].outcome);
    return worse(now, one());
  };
  EXPECT_THAT(offence([](Outcome& o) { o.ending = Ending::rides_through; }),
              ElementsAre(HasSubstr("mru1:off, engaged in sea: it rides through")));
  EXPECT_THAT(offence([](Outcome& o) { o.detected_after_s = 0.08; }), ElementsAre(HasSubstr("detected")));
  EXPECT_THAT(offence([](Outcome& o) { o.detected_after_s = 0.07; }), IsEmpty());
  EXPECT_THAT(offence([](Outcome& o) { o.detected_after_s.reset(); }), ElementsAre(HasSubstr("never")));
  EXPECT_THAT(offence([](Outcome& o) { o.at_rest_after_s = 0.7; }), ElementsAre(HasSubstr("at rest")));
  EXPECT_THAT(offence([](Outcome& o) { o.swing_max_deg = 3.1; }), ElementsAre(HasSubstr("swing")));
}

TEST(FaultMatrix, HasTheCellsThatWereRecordedAndNoOther) {
  EXPECT_THAT(worse(one(), {}), ElementsAre(HasSubstr("nothing is recorded")));
  EXPECT_THAT(worse({}, one()), ElementsAre(HasSubstr("no such cell")));
}

TEST(FaultMatrix, NeverPassesWhatIsUnsafe) {
  EXPECT_THAT(offences(one()), IsEmpty());
  Matrix bad = one();
  bad[0].outcome.moved_by_itself = true;
  bad[0].outcome.overshoot.joint_speed = 1.001;
  EXPECT_THAT(offences(bad), ElementsAre(HasSubstr("joint speed"), HasSubstr("by itself")));
  bad = one();
  bad[0].outcome.ending = Ending::not_stoppable;
  EXPECT_THAT(offences(bad), ElementsAre(HasSubstr("did not stop")));
  bad[0].cell.fault = {"arm", "cut", Program::faithful};
  EXPECT_THAT(offences(bad), IsEmpty()) << "nobody on this side can";
  bad[0].outcome = one()[0].outcome;
  bad[0].outcome.overshoot.plant_joint_speed_of_servo = 1.01;
  EXPECT_THAT(offences(bad), ElementsAre(HasSubstr("joint speed"))) << "in a cut wire are no bytes of others";
  bad[0].cell.fault.name = "foreign";
  EXPECT_THAT(offences(bad), IsEmpty()) << "nobody on this side can";
  bad[0].cell.fault.program = Program::hardened;
  EXPECT_THAT(offences(bad), ElementsAre(HasSubstr("joint speed")));
  bad = one();
  bad[0].outcome.in_state = false;
  EXPECT_THAT(offences(bad), ElementsAre(HasSubstr("not in this state")));
}

TEST(FaultMatrix, TellsPeopleWhatEachCellEndedWith) {
  Matrix matrix = one();
  EXPECT_THAT(to_markdown(matrix), HasSubstr("| `off` | **rests** 400 ms; 20 ms mode mru1_stale; 2.0° |\n"));
  matrix[0].cell.fault = {"arm", "cut", Program::faithful};
  matrix[0].outcome.ending = Ending::not_stoppable;
  EXPECT_THAT(to_markdown(matrix), HasSubstr("runs to the box edge: not stoppable by us"));
}

TEST(FaultMatrix, TellsPeopleInShortTheWorstOfEachState) {
  Matrix matrix = one();
  matrix.push_back(matrix[0]);
  matrix[1].cell.state = State::calm;
  matrix[1].outcome.detected_after_s = 0.03;
  matrix[1].outcome.at_rest_after_s = 0.3;
  EXPECT_THAT(to_markdown(matrix), HasSubstr("| `off` | 30 → 400 | – | – | – | – | – |\n"));
  matrix[0].outcome.detected_after_s.reset();
  EXPECT_THAT(to_markdown(matrix), HasSubstr("| `off` | unseen → 400 |"));
}

TEST(FaultMatrix, TellsPeopleWhatCannotBeAndWhy) {
  Matrix matrix = one();
  matrix[0].cell.state = State::settled;
  matrix[0].outcome = {};
  matrix[0].outcome.ending = Ending::cannot_be;
  matrix[0].outcome.code = "it has no power";
  EXPECT_THAT(offences(matrix), IsEmpty());
  EXPECT_THAT(to_markdown(matrix), HasSubstr("| `off` | cannot be |\n\n`off`: it has no power.\n"));
}

TEST(FaultMatrixCells, AreEveryWordForEveryDeviceAndWhatARefusalSays) {
  const auto config =
      lab::LabConfig::load(std::filesystem::path(MOTIONLAB_SOURCE_DIR) / "deploy" / "config" / "world.toml");
  const auto faults = every_fault(config);
  const auto refusal = [&](const DeviceFault& fault) {
    const auto known =
        std::find_if(faults.begin(), faults.end(), [&](const KnownFault& one) { return one.fault == fault; });
    return known == faults.end() ? "missing" : known->refusal;
  };
  for (const Program program : {Program::hardened, Program::faithful}) {
    for (const std::string device : {"mru1", "mru2", "qualisys", "winch", "arm"}) {
      if (program == Program::faithful && device != "arm") continue;
      for (const std::string name :
           {"off", "stuck", "garbage", "wrong", "slow", "delayed", "intermittent", "cut", "loss", "burst",
            "jitter", "reorder", "duplicate", "corrupt", "truncate", "foreign", "clock-jump"}) {
        EXPECT_NE(refusal({device, name, program}), "missing") << device << ":" << name;
      }
    }
  }
  EXPECT_EQ(refusal({"arm", "torn", Program::faithful}), "");
  EXPECT_THAT(refusal({"arm", "torn", Program::hardened}), HasSubstr("hands commands over whole"));
  EXPECT_THAT(refusal({"mru1", "reduced"}), HasSubstr("format"));
  EXPECT_EQ(refusal({"qualisys", "occlude:load"}), "");
  EXPECT_EQ(refusal({"winch", "jitter"}), "");
  EXPECT_THAT(refusal({"winch", "loss"}), HasSubstr("TCP"));
  EXPECT_THAT(refusal({"arm", "clock-jump"}), HasSubstr("no clock"));
}

}  // namespace
}  // namespace motionlab::matrix
