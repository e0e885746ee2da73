#include "gateway/controller/mode_machine.hpp"

#include <gtest/gtest.h>

#include "drivers/core/random.hpp"

namespace motionlab::controller {
namespace {

using State = ModeMachine::State;
using topic::Authority;
using topic::ModeAction;

constexpr LabTime at_ms(std::int64_t ms) {
  return LabTime{Nanoseconds{ms * 1'000'000}};
}

topic::ModeRequest ask(ModeAction action, std::string_view who = "anna",
                       Authority authority = Authority::observe) {
  topic::ModeRequest request;
  request.requester = who;
  request.action = action;
  request.authority = authority;
  return request;
}

const Obstacle kCold{"mru1_missing", "mru1 was never heard; switch it on"};
const Obstacle kStale{"mru1_stale", "mru1 fell silent; look at its cable"};

struct Bench {
  ModeMachine dut{Authority::limited};
  ModeFacts facts;
  std::int64_t ms = 0;
  bool commanding = true;  ///< the owner's controller goes on giving wishes

  Bench() { facts.links_up = true; }

  State step() {
    facts.t = at_ms(++ms);
    if (commanding) facts.commanded = facts.t;
    dut.step(facts);
    return dut.state();
  }
  void ask(ModeAction action, std::string_view who = "anna", Authority authority = Authority::observe) {
    dut.request(controller::ask(action, who, authority), at_ms(ms));
  }
  /// Brings the machine to a state by the shortest way.
  void go(State state) {
    while (dut.state() != State::ready) ASSERT_LT(static_cast<int>(step()), 3);
    if (state == State::ready) return;
    ask(ModeAction::engage);
    ASSERT_EQ(step(), State::engaged);
    if (state == State::engaged) return;
    facts.at_rest = false;
    if (state == State::stopping) {
      ask(ModeAction::settle);
      ASSERT_EQ(step(), State::stopping);
    } else {
      facts.unsafe = kStale;
      ASSERT_EQ(step(), State::fault);
    }
  }
};

// ---------------------------------------------------------------- every row of the table

TEST(ModeMachine, IsOffWithItsAuthorityUntilTheLinksAreUp) {
  Bench b;
  b.facts.links_up = false;
  EXPECT_EQ(b.dut.topic().authority, Authority::limited);
  EXPECT_EQ(b.step(), State::off);
  b.ask(ModeAction::engage);
  EXPECT_EQ(b.step(), State::off);
  EXPECT_EQ(b.dut.topic().sequence_number, 0u);
  b.facts.links_up = true;
  EXPECT_EQ(b.step(), State::settled);
  EXPECT_EQ(b.dut.topic().sequence_number, 1u);
  EXPECT_EQ(b.dut.topic().t_changed_ns, to_ns(b.facts.t));
  EXPECT_EQ(b.dut.topic().reason.view(), "all required devices have been heard");
}

TEST(ModeMachine, SettledBecomesReadyWhenNothingHinders) {
  Bench b;
  b.facts.not_ready = kCold;
  EXPECT_EQ(b.step(), State::settled);
  EXPECT_EQ(b.step(), State::settled);
  b.facts.not_ready.reset();
  EXPECT_EQ(b.step(), State::ready);
}

TEST(ModeMachine, EngagingWhileHinderedIsRefusedWithTheReason) {
  Bench b;
  b.facts.not_ready = kCold;
  b.step();
  const auto before = b.dut.topic().sequence_number;
  b.ask(ModeAction::engage);
  EXPECT_EQ(b.step(), State::settled);
  EXPECT_EQ(b.dut.topic().fault_code, kCold.code);
  EXPECT_EQ(b.dut.topic().reason, kCold.text);
  EXPECT_FALSE(b.dut.topic().fault_latched);
  EXPECT_EQ(b.dut.topic().sequence_number, before + 1);
  b.facts.not_ready.reset();
  EXPECT_EQ(b.step(), State::ready) << "the refused request is forgotten";
  EXPECT_EQ(b.step(), State::ready);
}

TEST(ModeMachine, ReadyFallsBackWhenSomethingHinders) {
  Bench b;
  b.go(State::ready);
  b.facts.not_ready = kCold;
  b.ask(ModeAction::engage);
  EXPECT_EQ(b.step(), State::settled) << "also when engaging is asked in the same cycle";
  EXPECT_EQ(b.dut.topic().fault_code, kCold.code);
  EXPECT_EQ(b.dut.topic().reason, kCold.text);
}

TEST(ModeMachine, WhatWouldStopAnEngagedGatewayAlsoKeepsItFromEngaging) {
  Bench b;
  b.go(State::ready);
  b.facts.unsafe = kStale;
  b.ask(ModeAction::engage);
  EXPECT_EQ(b.step(), State::settled);
  EXPECT_EQ(b.dut.topic().fault_code, kStale.code);
  b.ask(ModeAction::engage);
  EXPECT_EQ(b.step(), State::settled);
}

TEST(ModeMachine, ReadyEngagesOnRequestAndNamesTheOwner) {
  Bench b;
  b.go(State::ready);
  EXPECT_FALSE(b.dut.may_move());
  b.ask(ModeAction::engage, "anna");
  EXPECT_EQ(b.step(), State::engaged);
  EXPECT_EQ(b.dut.topic().owner.view(), "anna");
  EXPECT_TRUE(b.dut.may_move());
  EXPECT_EQ(b.dut.topic().reason.view(), "engaged on request");
  b.ask(ModeAction::engage, "bert");
  EXPECT_EQ(b.step(), State::engaged);
  EXPECT_EQ(b.dut.topic().owner.view(), "anna") << "nobody takes over";
}

TEST(ModeMachine, EngagedFaultsWhenUnsafe) {
  Bench b;
  b.go(State::engaged);
  b.facts.unsafe = kStale;
  b.ask(ModeAction::settle);
  EXPECT_EQ(b.step(), State::fault) << "the fault is latched even if somebody settles in the same cycle";
  EXPECT_TRUE(b.dut.topic().fault_latched);
  EXPECT_EQ(b.dut.topic().fault_code, kStale.code);
  EXPECT_EQ(b.dut.topic().reason, kStale.text);
  EXPECT_TRUE(b.dut.topic().owner.empty());
  EXPECT_FALSE(b.dut.may_move());
}

TEST(ModeMachine, EngagedIsNotStoppedByWhatOnlyHindersEngaging) {
  Bench b;
  b.go(State::engaged);
  b.facts.not_ready = kCold;
  EXPECT_EQ(b.step(), State::engaged);
}

TEST(ModeMachine, SettleStopsAndThenSettlesAtRest) {
  Bench b;
  b.go(State::engaged);
  b.facts.at_rest = false;
  b.ask(ModeAction::settle, "a stranger");
  EXPECT_EQ(b.step(), State::stopping) << "obeyed from anyone";
  EXPECT_FALSE(b.dut.may_move());
  EXPECT_EQ(b.dut.topic().owner.view(), "anna") << "still the owner's motion that comes to rest";
  b.ask(ModeAction::engage);
  EXPECT_EQ(b.step(), State::stopping);
  b.facts.at_rest = true;
  EXPECT_EQ(b.step(), State::settled);
  EXPECT_TRUE(b.dut.topic().owner.empty());
  EXPECT_EQ(b.step(), State::ready);
  EXPECT_EQ(b.step(), State::ready) << "what was asked while stopping is forgotten";
}

TEST(ModeMachine, StoppingFaultsWhenUnsafe) {
  Bench b;
  b.go(State::stopping);
  b.facts.unsafe = kStale;
  b.facts.at_rest = true;
  EXPECT_EQ(b.step(), State::fault);
}

TEST(ModeMachine, AFaultStaysUntilItIsReset) {
  Bench b;
  b.go(State::fault);
  b.facts.unsafe.reset();
  b.facts.at_rest = true;
  b.ask(ModeAction::engage);
  b.ask(ModeAction::settle);
  for (int i = 0; i < 1000; ++i) ASSERT_EQ(b.step(), State::fault);
  EXPECT_EQ(b.dut.topic().fault_code, kStale.code);
  b.ask(ModeAction::reset);
  EXPECT_EQ(b.step(), State::settled);
  EXPECT_FALSE(b.dut.topic().fault_latched);
  EXPECT_TRUE(b.dut.topic().fault_code.empty());
}

TEST(ModeMachine, ResetWhileTheCausePersistsIsRefusedWithTheReason) {
  Bench b;
  b.go(State::fault);
  b.facts.at_rest = true;
  b.facts.unsafe = Obstacle{"winch_stale", "the winch fell silent too"};
  const auto before = b.dut.topic().sequence_number;
  b.ask(ModeAction::reset);
  EXPECT_EQ(b.step(), State::fault);
  EXPECT_EQ(b.dut.topic().fault_code.view(), "winch_stale");
  EXPECT_EQ(b.dut.topic().reason.view(), "the winch fell silent too");
  EXPECT_EQ(b.dut.topic().sequence_number, before + 1);
  b.facts.unsafe.reset();
  EXPECT_EQ(b.step(), State::fault) << "the refused request is forgotten";
}

TEST(ModeMachine, ResetBeforeRestIsRefusedWithTheReasonAndKeepsTheCode) {
  Bench b;
  b.go(State::fault);
  b.facts.unsafe.reset();
  b.ask(ModeAction::reset);
  EXPECT_EQ(b.step(), State::fault);
  EXPECT_EQ(b.dut.topic().fault_code, kStale.code);
  EXPECT_EQ(b.dut.topic().reason.view(), "a fault is reset only at rest; ask again");
  b.facts.at_rest = true;
  EXPECT_EQ(b.step(), State::fault);
}

// ---------------------------------------------------------------- the lease

TEST(ModeMachine, AnOwnerWhoFallsSilentLosesTheLeaseAndAFaultIsLatched) {
  Bench b;
  b.go(State::engaged);
  for (int i = 0; i < 500; ++i) ASSERT_EQ(b.step(), State::engaged);
  EXPECT_TRUE(b.dut.lease()->valid(b.facts.t));
  EXPECT_EQ(b.dut.topic().t_lease_expires_ns, to_ns(b.facts.t + kLeaseDuration));
  b.commanding = false;
  int steps = 1;
  while (b.step() == State::engaged) ++steps;
  EXPECT_EQ(steps, 100);
  EXPECT_EQ(b.dut.state(), State::fault);
  EXPECT_EQ(b.dut.topic().fault_code.view(), "lease_lost");
  EXPECT_FALSE(b.dut.lease());
  b.commanding = true;
  for (int i = 0; i < 500; ++i) ASSERT_EQ(b.step(), State::fault) << "it does not come back";
}

TEST(ModeMachine, TellsWhetherTheOwnerCommandsHimself) {
  Bench b;
  b.go(State::ready);
  topic::ModeRequest request = ask(ModeAction::engage, "pilot");
  request.external_controller = true;
  b.dut.request(request, at_ms(b.ms));
  ASSERT_TRUE(b.dut.applicant());
  EXPECT_TRUE(b.dut.applicant()->external);
  EXPECT_EQ(b.step(), State::engaged);
  EXPECT_FALSE(b.dut.applicant());
  EXPECT_TRUE(b.dut.lease()->external());
  EXPECT_TRUE(b.dut.topic().external_controller);
  EXPECT_EQ(b.dut.topic().owner.view(), "pilot");
  b.ask(ModeAction::settle);
  for (int i = 0; i < 3; ++i) b.step();
  EXPECT_FALSE(b.dut.topic().external_controller);
  EXPECT_EQ(b.dut.topic().t_lease_expires_ns, 0);
}

TEST(Lease, IsOneAtATimeAndComesBackWithItsHolder) {
  LeaseDesk desk;
  EXPECT_FALSE(desk.grant("", false, at_ms(0)));
  auto first = desk.grant("anna", false, at_ms(0));
  ASSERT_TRUE(first);
  EXPECT_FALSE(desk.grant("bert", false, at_ms(1000))) << "also when it has expired";
  std::optional<Lease> moved = std::move(first);
  first.reset();
  EXPECT_FALSE(desk.grant("bert", false, at_ms(1000))) << "it was handed over";
  moved.reset();
  EXPECT_TRUE(desk.grant("bert", true, at_ms(1000)));
}

TEST(Lease, IsRenewedByNewCommandsAloneAndNeverRevived) {
  LeaseDesk desk;
  auto lease = desk.grant("anna", false, at_ms(0));
  EXPECT_TRUE(lease->valid(at_ms(99)));
  EXPECT_FALSE(lease->valid(at_ms(100)));
  lease->renew(at_ms(50));
  lease->renew(at_ms(20));
  EXPECT_EQ(lease->expires(), at_ms(150));
  lease->renew(at_ms(151));
  EXPECT_FALSE(lease->valid(at_ms(151)));
}

// ---------------------------------------------------------------- requests

TEST(ModeMachine, SettleWinsOverEngageInTheSameCycleInEitherOrder) {
  for (const bool settle_first : {true, false}) {
    Bench b;
    b.go(State::ready);
    if (settle_first) b.ask(ModeAction::settle);
    b.ask(ModeAction::engage);
    if (!settle_first) b.ask(ModeAction::settle);
    EXPECT_EQ(b.step(), State::ready);
    EXPECT_EQ(b.step(), State::ready);
  }
}

TEST(ModeMachine, SomebodyWithoutANameCannotEngage) {
  Bench b;
  b.go(State::ready);
  b.ask(ModeAction::engage, "");
  EXPECT_EQ(b.step(), State::ready);
}

TEST(ModeMachine, TheOwnersNameIsBounded) {
  Bench b;
  b.go(State::ready);
  b.ask(ModeAction::engage, std::string(500, 'x'));
  EXPECT_EQ(b.step(), State::engaged);
  EXPECT_EQ(b.dut.topic().owner.view(), std::string(32, 'x'));
}

TEST(ModeMachine, MoreAuthorityIsRefusedWhileEngagedAndWhileStopping) {
  for (const State state : {State::engaged, State::stopping}) {
    Bench b;
    b.go(state);
    const auto before = b.dut.topic().sequence_number;
    b.ask(ModeAction::authority, "anna", Authority::full);
    EXPECT_EQ(b.dut.authority(), Authority::limited);
    EXPECT_EQ(b.dut.topic().fault_code.view(), "authority_refused");
    EXPECT_EQ(b.dut.topic().sequence_number, before + 1);
    EXPECT_EQ(b.dut.state(), state);
  }
}

TEST(ModeMachine, LessAuthorityIsGrantedWhileEngagedAndStopsMotion) {
  Bench b;
  b.go(State::engaged);
  b.ask(ModeAction::authority, "anna", Authority::shadow);
  EXPECT_EQ(b.dut.authority(), Authority::shadow);
  EXPECT_EQ(b.dut.topic().authority, Authority::shadow);
  EXPECT_FALSE(b.dut.may_move());
  EXPECT_EQ(b.dut.topic().owner.view(), "anna");
}

TEST(ModeMachine, AuthorityIsALadder) {
  Bench b;
  b.go(State::ready);
  const auto may_move_with = [&](Authority authority) {
    b.ask(ModeAction::authority, "anna", authority);
    b.ask(ModeAction::engage);
    b.step();
    const bool may = b.dut.may_move();
    b.ask(ModeAction::settle);
    for (int i = 0; i < 3; ++i) b.step();
    EXPECT_EQ(b.dut.state(), State::ready);
    return may;
  };
  EXPECT_FALSE(may_move_with(Authority::observe));
  EXPECT_FALSE(may_move_with(Authority::shadow));
  EXPECT_TRUE(may_move_with(Authority::limited));
  EXPECT_EQ(b.dut.share_of_limits(), 0.1);
  EXPECT_TRUE(may_move_with(Authority::full));
  EXPECT_EQ(b.dut.share_of_limits(), 1.0);
}

TEST(ModeMachine, AnAuthorityOrAnActionThatDoesNotExistIsIgnored) {
  Bench b;
  b.go(State::ready);
  const auto before = b.dut.topic();
  b.ask(ModeAction::authority, "anna", static_cast<Authority>(4));
  b.ask(static_cast<ModeAction>(77));
  b.step();
  EXPECT_EQ(b.dut.authority(), Authority::limited);
  EXPECT_EQ(b.dut.topic().sequence_number, before.sequence_number);
  EXPECT_EQ(b.dut.state(), State::ready);
}

TEST(ModeMachine, AChangeOfAuthorityDoesNotHideTheCauseOfAFault) {
  Bench b;
  b.go(State::fault);
  b.ask(ModeAction::authority, "anna", Authority::observe);
  EXPECT_TRUE(b.dut.topic().fault_latched);
  EXPECT_EQ(b.dut.topic().fault_code, kStale.code);
  EXPECT_EQ(b.dut.topic().reason, kStale.text);
  EXPECT_EQ(b.dut.topic().authority, Authority::observe);
}

// ---------------------------------------------------------------- any sequence

TEST(ModeMachine, NothingResumesByItself) {
  Random random(7);
  for (int run = 0; run < 200; ++run) {
    Bench b;
    int engaged_times = 0;
    for (int i = 0; i < 500; ++i) {
      const auto sometimes = [&](double probability, const Obstacle& obstacle) {
        return random.chance(probability) ? std::optional{obstacle} : std::nullopt;
      };
      b.facts.links_up = random.chance(0.9);
      b.facts.not_ready = sometimes(0.1, kCold);
      b.facts.unsafe = sometimes(0.05, kStale);
      b.facts.at_rest = random.chance(0.7);
      const State before = b.dut.state();
      const topic::Mode said = b.dut.topic();
      bool engage = false, settle = false, reset = false;
      const int requests = static_cast<int>(random.below(3));
      for (int k = 0; k < requests; ++k) {
        const auto action = static_cast<ModeAction>(random.below(4));
        engage = engage || action == ModeAction::engage;
        settle = settle || action == ModeAction::settle;
        reset = reset || action == ModeAction::reset;
        b.ask(action, "anna", static_cast<Authority>(random.below(4)));
      }
      const State after = b.step();
      const topic::Mode& says = b.dut.topic();
      engaged_times += after == State::engaged && before != State::engaged;
      if (after == State::engaged && before != State::engaged) {
        ASSERT_EQ(before, State::ready);
        ASSERT_TRUE(engage && !settle && !b.facts.unsafe && !b.facts.not_ready);
      }
      if (before == State::engaged && (settle || b.facts.unsafe)) {
        ASSERT_NE(after, State::engaged);
      }
      if (before == State::fault && after != State::fault) {
        ASSERT_TRUE(reset && b.facts.at_rest && !b.facts.unsafe);
        ASSERT_EQ(after, State::settled);
      }
      ASSERT_EQ(says.state, after);
      ASSERT_EQ(says.authority, b.dut.authority());
      ASSERT_EQ(says.fault_latched, after == State::fault);
      ASSERT_EQ(says.owner.empty(), after != State::engaged && after != State::stopping);
      ASSERT_FALSE(b.dut.may_move() && after != State::engaged);
      if (after != before) {
        ASSERT_EQ(says.t_changed_ns, to_ns(b.facts.t));
      }
      const bool same = said.state == says.state && said.authority == says.authority &&
                        said.owner == says.owner && said.fault_code == says.fault_code &&
                        said.reason == says.reason && said.t_changed_ns == says.t_changed_ns;
      if (!same) {
        ASSERT_GT(says.sequence_number, said.sequence_number);
      }
      if (after != State::off) {
        ASSERT_FALSE(says.reason.empty());
      }
    }
    ASSERT_GT(engaged_times, 0);
  }
}

}  // namespace
}  // namespace motionlab::controller
