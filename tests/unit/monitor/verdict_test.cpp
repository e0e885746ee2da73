#include "gateway/monitor/verdict.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace motionlab::monitor {
namespace {

using testing::HasSubstr;
using topic::ModeAction;
using topic::ModeState;

topic::Mode mode(ModeState state, std::uint64_t number, const char* code = "", const char* reason = "") {
  topic::Mode mode;
  mode.state = state;
  mode.sequence_number = number;
  mode.fault_code = code;
  mode.reason = reason;
  return mode;
}

Outcome engage(const topic::Mode& before, const topic::Mode& now) {
  return judge(ModeAction::engage, before, now, "alice@lab").outcome;
}

TEST(Engage, IsGrantedWhenTheGatewayIsOurs) {
  topic::Mode engaged = mode(ModeState::engaged, 6);
  engaged.owner = "alice@lab";
  EXPECT_EQ(engage(mode(ModeState::ready, 5), engaged), Outcome::granted);
}

TEST(Engage, IsRefusedWhenSomebodyElseHasIt) {
  topic::Mode engaged = mode(ModeState::engaged, 5);
  engaged.owner = "bob@lab";
  const Verdict verdict = judge(ModeAction::engage, engaged, engaged, "alice@lab");
  EXPECT_EQ(verdict.outcome, Outcome::refused);
  EXPECT_THAT(verdict.sentence, HasSubstr("bob@lab"));
}

TEST(Engage, IsRefusedWithTheReasonThatTheGatewayGives) {
  const Verdict verdict = judge(ModeAction::engage, mode(ModeState::settled, 5),
                                mode(ModeState::settled, 6, "mru1_stale", "mru1 is silent"), "alice@lab");
  EXPECT_EQ(verdict.outcome, Outcome::refused);
  EXPECT_EQ(verdict.sentence, "refused (mru1_stale): mru1 is silent");
}

TEST(Engage, WaitsForAnAnswerThatIsNewerThanTheRequest) {
  const topic::Mode old_refusal = mode(ModeState::settled, 5, "mru1_stale", "mru1 is silent");
  EXPECT_EQ(engage(old_refusal, old_refusal), Outcome::pending);
  EXPECT_EQ(engage(mode(ModeState::ready, 5), mode(ModeState::ready, 5)), Outcome::pending);
  EXPECT_EQ(engage(mode(ModeState::settled, 5), mode(ModeState::ready, 6)), Outcome::pending);
  EXPECT_EQ(engage(mode(ModeState::off, 0), mode(ModeState::off, 0)), Outcome::pending);
}

TEST(Engage, IsRefusedByALatchedFault) {
  const topic::Mode fault = mode(ModeState::fault, 5, "arm_stale", "the arm is silent");
  const Verdict verdict = judge(ModeAction::engage, fault, fault, "alice@lab");
  EXPECT_EQ(verdict.outcome, Outcome::refused);
  EXPECT_THAT(verdict.sentence, HasSubstr("the arm is silent; when its cause is gone: motionlab reset"));
}

TEST(Settle, IsGrantedOnlyWhenNothingCanBeCommanded) {
  const auto settle = [](ModeState state) {
    return judge(ModeAction::settle, std::nullopt, mode(state, 5), "alice@lab").outcome;
  };
  EXPECT_EQ(settle(ModeState::off), Outcome::granted);
  EXPECT_EQ(settle(ModeState::settled), Outcome::granted);
  EXPECT_EQ(settle(ModeState::ready), Outcome::granted);
  EXPECT_EQ(settle(ModeState::engaged), Outcome::pending);
  EXPECT_EQ(settle(ModeState::stopping), Outcome::pending);
  EXPECT_EQ(settle(ModeState::fault), Outcome::refused);
}

TEST(Reset, IsGrantedWhenNoFaultIsLatchedAnyMore) {
  const topic::Mode fault = mode(ModeState::fault, 5, "arm_stale");
  EXPECT_EQ(judge(ModeAction::reset, fault, mode(ModeState::settled, 6), "").sentence, "the fault is reset");
  EXPECT_EQ(judge(ModeAction::reset, mode(ModeState::ready, 5), mode(ModeState::ready, 5), "").sentence,
            "no fault is latched");
}

TEST(Reset, IsRefusedWhenTheGatewayLatchesItAgain) {
  const topic::Mode before = mode(ModeState::fault, 5, "arm_stale", "the arm is silent");
  const topic::Mode after = mode(ModeState::fault, 6, "arm_stale", "the arm is silent");
  EXPECT_EQ(judge(ModeAction::reset, before, before, "").outcome, Outcome::pending);
  EXPECT_EQ(judge(ModeAction::reset, before, after, "").outcome, Outcome::refused);
}

TEST(Authority, IsGrantedWhenTheModeShowsIt) {
  topic::Mode now = mode(ModeState::ready, 6);
  now.authority = topic::Authority::limited;
  EXPECT_EQ(judge_authority(topic::Authority::limited, mode(ModeState::ready, 5), now).outcome,
            Outcome::granted);
  EXPECT_EQ(judge_authority(topic::Authority::full, mode(ModeState::ready, 5), now).outcome,
            Outcome::pending);
}

TEST(Authority, IsRefusedOnlyByAnAnswerThatIsNewerThanTheRequest) {
  const topic::Mode refusal = mode(ModeState::engaged, 6, "authority_refused", "settle first");
  EXPECT_EQ(judge_authority(topic::Authority::full, refusal, refusal).outcome, Outcome::pending);
  const Verdict verdict = judge_authority(topic::Authority::full, mode(ModeState::engaged, 5), refusal);
  EXPECT_EQ(verdict.outcome, Outcome::refused);
  EXPECT_EQ(verdict.sentence, "refused (authority_refused): settle first");
}

}  // namespace
}  // namespace motionlab::monitor
