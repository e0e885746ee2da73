#include "drivers/comau/comau_driver.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "drivers/core/random.hpp"
#include "tests/comau/comau_frames.hpp"

namespace motionlab::comau {
namespace {

constexpr Endpoint kRobot{0xC0A85A20, 50032};
const LabTime kStart = from_ns(1'000'000'000);
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct Sent {
  LabTime t;
  Command command;
};

class ComauDriverTest : public ::testing::Test, public DatagramOut {
 protected:
  ComauDriverTest()
      : dut_(
            config(), *this, [this](const topic::ArmState& s) { states_.push_back(s); },
            [this](const topic::ArmCommand& c) { said_.push_back(c); }) {}

  static DriverConfig config() {
    DriverConfig c;
    c.robot_computer = kRobot;
    return c;
  }

  Status send(Endpoint to, Bytes datagram) override {
    EXPECT_EQ(to, kRobot);
    if (broken_) return Fault{Reason::transport, "no route"};
    sent_.push_back({now_, decode_command(datagram).value()});
    EXPECT_TRUE(check(sent_.back().command).ok());
    return Done{};
  }

  /// Steps every millisecond; the robot computer answers each command in the next millisecond if
  /// `answering_`.
  void run(Nanoseconds duration) {
    for (const LabTime end = now_ + duration; now_ < end; now_ += 1ms) {
      if (refresh_) want(*refresh_);
      const auto before = sent_.size();
      dut_.step(now_);
      if (answering_ && sent_.size() > before) receive(frame_at(now_), now_ + 100us);
    }
  }

  static std::uint32_t frame_at(LabTime t) {
    return static_cast<std::uint32_t>((t - kStart) / 400us) + 1000u;
  }

  void want(const Joints& qd, bool follow = true) {
    topic::ArmCommand command;
    command.t_created_ns = to_ns(now_);
    command.follow = follow;
    command.qd_wanted_radps = qd;
    dut_.set_command(command);
  }

  /// An answer; the arm moves as `measured_qd_` says.
  void receive(std::uint32_t frame_counter, LabTime t, Endpoint from = kRobot) {
    for (std::size_t i = 0; i < kJointCount; ++i) q_[i] += measured_qd_[i] * seconds(t - t_moved_);
    t_moved_ = t;
    dut_.on_datagram(encode(Answer{frame_counter, q_, measured_qd_, limits_}), from, t);
  }

  /// Engages and runs until the arm is asked to follow at this speed.
  void follow(const Joints& qd) {
    answering_ = true;
    run(10ms);
    measured_qd_ = qd;
    refresh_ = qd;
    run(140ms);
    ASSERT_EQ(sent_.back().command.mode, 1);
  }

  bool advice_has(std::string_view text) const {
    return dut_.health().advice().find(text) != std::string_view::npos;
  }

  LabTime now_ = kStart;
  std::vector<Sent> sent_;
  std::vector<topic::ArmState> states_;
  std::vector<topic::ArmCommand> said_;
  std::optional<Joints> refresh_;
  Joints q_{0.0, 0.0, -1.5, 0, 0, 0};
  Joints measured_qd_{};
  LabTime t_moved_ = kStart;
  std::optional<ReportedLimits> limits_;
  bool answering_ = false;
  bool broken_ = false;
  ComauDriver dut_;
};

TEST_F(ComauDriverTest, SendsHoldAtOnceAndGoesOnSendingIt) {
  EXPECT_LE(dut_.next_send(), kStart);
  EXPECT_FALSE(dut_.last_sent());
  run(1s);
  ASSERT_EQ(sent_.size(), 200u);
  EXPECT_EQ(sent_[0].t, kStart);
  for (const Sent& s : sent_) EXPECT_EQ(s.command, Command{});
}

TEST_F(ComauDriverTest, KeepsAnAbsoluteScheduleAndSkipsMissedSlots) {
  dut_.step(now_);
  EXPECT_EQ(dut_.next_send(), kStart + 5ms);
  now_ = kStart + 5ms + 700us;
  dut_.step(now_);
  EXPECT_EQ(dut_.next_send(), kStart + 10ms) << "a late step does not shift the schedule";
  now_ = kStart + 33ms;
  dut_.step(now_);
  dut_.step(now_);
  EXPECT_EQ(sent_.size(), 3u) << "no burst after a stall";
  EXPECT_EQ(dut_.missed_slots(), 4u);
  EXPECT_EQ(dut_.next_send(), kStart + 35ms);
}

TEST_F(ComauDriverTest, NeverSendsOnReceiptOrOnCommand) {
  run(1ms);
  want({0.1, 0, 0, 0, 0, 0});
  receive(10, now_);
  EXPECT_EQ(sent_.size(), 1u);
}

TEST_F(ComauDriverTest, SendsTheNewestVelocitiesAsTheyAre) {
  follow({0.1, -0.2, 0.3, 0.01, -0.02, 0.03});
  EXPECT_EQ(sent_.back().command.qd_radps, (std::array{0.1F, -0.2F, 0.3F, 0.01F, -0.02F, 0.03F}));
  EXPECT_EQ(*dut_.last_sent(), sent_.back().command);
  EXPECT_EQ(*dut_.t_last_sent(), sent_.back().t);
  ASSERT_EQ(said_.size(), sent_.size());
  EXPECT_TRUE(said_.back().follow);
  EXPECT_FALSE(said_.size() < 2 || said_.back().sequence_number != said_.size());
  EXPECT_EQ(said_.back().t_created_ns, to_ns(sent_.back().t));
  EXPECT_EQ(said_.back().qd_wanted_radps[1], static_cast<double>(-0.2F));
  EXPECT_TRUE(states_.back().following);
}

TEST_F(ComauDriverTest, NeverExceedsTheSpeedLimitEvenByRounding) {
  refresh_ = Joints{9, -9, 9, 9, -9, 9};
  answering_ = true;
  run(200ms);
  const DriverConfig c = config();
  for (std::size_t i = 0; i < kJointCount; ++i) {
    const double speed = std::abs(static_cast<double>(sent_.back().command.qd_radps[i]));
    EXPECT_LE(speed, c.qd_max_radps[i]);
    EXPECT_GT(speed, c.qd_max_radps[i] - 1e-7);
  }
}

/// Checks every change of speed since `first` against an acceleration of each joint, and that mode 0 comes
/// only from rest.
void expect_gentle(const std::vector<Sent>& sent, std::size_t first,
                   const Joints& most_radps2 = DriverConfig{}.stop_deceleration_radps2) {
  for (std::size_t k = first; k < sent.size(); ++k) {
    for (std::size_t i = 0; i < kJointCount; ++i) {
      const double before = static_cast<double>(sent[k - 1].command.qd_radps[i]);
      const double after = static_cast<double>(sent[k].command.qd_radps[i]);
      EXPECT_LE(std::abs(after - before), most_radps2[i] * 0.005 + 1e-12);
    }
    if (sent[k].command.mode == 0 && sent[k - 1].command.mode == 1) {
      EXPECT_EQ(sent[k - 1].command.qd_radps, Command{}.qd_radps);
    }
  }
}

TEST_F(ComauDriverTest, RampsToRestWhenTheCommandIsStale) {
  follow({0.4, -0.2, 0.1, 0.05, 0, 0});
  const auto first = sent_.size();
  const LabTime t_last_wanted = now_ - 1ms;
  refresh_.reset();
  run(1s);
  expect_gentle(sent_, first);
  for (std::size_t k = first; k < sent_.size(); ++k) {
    const bool fresh = sent_[k].t - t_last_wanted <= 25ms;
    EXPECT_EQ(sent_[k].command.qd_radps[0] == 0.4F, fresh);
  }
  EXPECT_EQ(sent_.back().command, Command{});
  EXPECT_EQ(dut_.stale_commands(), 1u);
  EXPECT_TRUE(advice_has("too old"));
  // 0.4 rad/s at 1 rad/s2 takes 0.4 s, then 0.1 s of rest in mode 1.
  const auto holds = std::count_if(sent_.begin() + static_cast<std::ptrdiff_t>(first), sent_.end(),
                                   [](const Sent& s) { return s.command.mode == 0; });
  EXPECT_NEAR(static_cast<double>(holds), (1.0 - 0.025 - 0.4 - 0.1) / 0.005, 3.0);
}

TEST_F(ComauDriverTest, RejoinsTheWantedVelocityWithoutAStep) {
  follow({0.4, 0, 0, 0, 0, 0});
  refresh_.reset();
  run(150ms);
  const auto first = sent_.size();
  refresh_ = Joints{0.4, 0, 0, 0, 0, 0};
  run(500ms);
  expect_gentle(sent_, first, config().qdd_max_radps2);
  EXPECT_EQ(sent_.back().command.qd_radps[0], 0.4F);
  EXPECT_TRUE(dut_.health().advice().empty()) << dut_.health().advice();
}

TEST_F(ComauDriverTest, RejoinsWithoutAStepEvenFromHold) {
  follow({0.4, 0, 0, 0, 0, 0});
  refresh_.reset();
  run(1s);
  ASSERT_EQ(sent_.back().command.mode, 0);
  const auto first = sent_.size();
  refresh_ = Joints{0.4, 0, 0, 0, 0, 0};
  run(500ms);
  expect_gentle(sent_, first, config().qdd_max_radps2);
}

TEST_F(ComauDriverTest, BeginsAndEndsModeOneAtZeroSpeed) {
  follow({0.3, 0, 0, 0, 0, 0});
  const auto begin =
      std::find_if(sent_.begin(), sent_.end(), [](const Sent& s) { return s.command.mode == 1; });
  for (int k = 0; k < 4; ++k) EXPECT_EQ((begin + k)->command.qd_radps[0], 0.0F) << k;
  EXPECT_GT((begin + 4)->command.qd_radps[0], 0.0F);
  expect_gentle(sent_, static_cast<std::size_t>(begin - sent_.begin()), config().qdd_max_radps2);
  refresh_.reset();
  measured_qd_ = {};
  want({}, false);
  run(600ms);
  const auto end =
      std::find_if(sent_.rbegin(), sent_.rend(), [](const Sent& s) { return s.command.mode == 1; });
  for (int k = 0; k < 20; ++k) EXPECT_EQ((end + k)->command.qd_radps[0], 0.0F) << k;
}

TEST_F(ComauDriverTest, LimitsTheAccelerationOfWhatIsWanted) {
  follow({0.3, 0, 0, 0.04, 0, 0});
  const auto first = sent_.size();
  for (const double direction : {-1.0, 1.0, -1.0}) {
    refresh_ = Joints{0.3 * direction, 0, 0, 0.04 * direction, 0, 0};
    run(25ms);
  }
  Joints most = config().qdd_max_radps2;
  for (std::size_t i = 0; i < kJointCount; ++i)
    most[i] = std::max(most[i], config().stop_deceleration_radps2[i]);
  expect_gentle(sent_, first, most);
}

TEST_F(ComauDriverTest, BrakesBeforeTheEdgeOfItsOwnBox) {
  q_[0] = 0.55;  // the edge lies at 0.785
  answering_ = true;
  refresh_ = Joints{0.5, 0, 0, 0, 0, 0};
  for (int k = 0; k < 1000; ++k) {
    run(5ms);
    measured_qd_[0] = static_cast<double>(sent_.back().command.qd_radps[0]);
  }
  EXPECT_LE(q_[0], config().q_max_rad[0]);
  EXPECT_GT(q_[0], config().q_max_rad[0] - 0.002);
  EXPECT_EQ(sent_.back().command.mode, 1);
}

TEST_F(ComauDriverTest, DoesNotMoveBeforeItKnowsWhereTheArmIs) {
  refresh_ = Joints{0.2, 0, 0, 0, 0, 0};
  run(500ms);
  EXPECT_EQ(sent_.back().command, Command{});
  EXPECT_TRUE(advice_has("fresh enough"));
}

TEST_F(ComauDriverTest, KeepsModeOneUntilAtRestWhenToldToHold) {
  follow({0.1, 0, -0.3, 0, 0, 0});
  const auto first = sent_.size();
  refresh_.reset();
  want({}, false);
  run(1s);
  expect_gentle(sent_, first);
  EXPECT_EQ(sent_.back().command, Command{});
  EXPECT_EQ(dut_.stale_commands(), 0u);
  EXPECT_TRUE(dut_.health().advice().empty());
}

TEST_F(ComauDriverTest, NeverSendsANumberThatIsNotFinite) {
  for (const double bad : {kNaN, std::numeric_limits<double>::infinity()}) {
    follow({0.1, 0, 0, 0, 0, 0});
    const auto first = sent_.size();
    const auto counted = dut_.health().rejected(Reason::bad_value);
    refresh_ = Joints{0.1, bad, 0, 0, 0, 0};
    measured_qd_ = {};
    run(300ms);
    expect_gentle(sent_, first);
    EXPECT_EQ(sent_.back().command, Command{});
    EXPECT_EQ(dut_.health().rejected(Reason::bad_value), counted + 300);
    EXPECT_TRUE(advice_has("no number"));
    refresh_ = Joints{};
    run(50ms);
    refresh_.reset();
    want({}, false);
    run(200ms);
  }
}

TEST_F(ComauDriverTest, DoesNotTrustACommandFromTheFuture) {
  follow({0.1, 0, 0, 0, 0, 0});
  refresh_.reset();
  topic::ArmCommand command;
  command.t_created_ns = to_ns(now_ + 3600s);
  command.follow = true;
  command.qd_wanted_radps = {0.1, 0, 0, 0, 0, 0};
  dut_.set_command(command);
  run(500ms);
  EXPECT_EQ(sent_.back().command.mode, 0);
}

TEST_F(ComauDriverTest, RefusesAnOlderFollowButTakesEveryHold) {
  follow({0.1, 0, 0, 0, 0, 0});
  refresh_.reset();
  topic::ArmCommand old;
  old.t_created_ns = to_ns(now_ - 20ms);
  old.follow = true;
  old.qd_wanted_radps = {0.2, 0, 0, 0, 0, 0};
  dut_.set_command(old);
  EXPECT_EQ(dut_.health().rejected(Reason::out_of_order), 1u);
  run(6ms);
  EXPECT_EQ(sent_.back().command.qd_radps[0], 0.1F);
  old.follow = false;
  dut_.set_command(old);
  run(500ms);
  EXPECT_EQ(sent_.back().command.mode, 0);
}

TEST_F(ComauDriverTest, StopsInOrderAndThenSaysNothingMore) {
  follow({0.3, 0, 0, 0, 0, 0});
  const auto first = sent_.size();
  dut_.orderly_stop();
  run(2s);
  EXPECT_TRUE(dut_.stopped());
  expect_gentle(sent_, first);
  const auto holds = std::count_if(sent_.begin() + static_cast<std::ptrdiff_t>(first), sent_.end(),
                                   [](const Sent& s) { return s.command == Command{}; });
  EXPECT_EQ(holds, 20);
  EXPECT_EQ(sent_.back().command, Command{});
  EXPECT_EQ(dut_.next_send(), LabTime::max());
}

TEST_F(ComauDriverTest, StopsInOrderEvenWhenTheSocketIsDead) {
  follow({0.3, 0, 0, 0, 0, 0});
  const Command last = *dut_.last_sent();
  broken_ = true;
  dut_.orderly_stop();
  run(2s);
  EXPECT_TRUE(dut_.stopped());
  EXPECT_EQ(*dut_.last_sent(), last) << "what did not leave was not sent";
  EXPECT_GT(dut_.health().rejected(Reason::transport), 20u);
}

TEST_F(ComauDriverTest, GoesOnFromWhatReallyLeftWhenTheSocketFails) {
  follow({0.3, 0, 0, 0, 0, 0});
  const auto first = sent_.size();
  broken_ = true;
  refresh_ = Joints{-0.3, 0, 0, 0, 0, 0};
  run(200ms);
  EXPECT_EQ(sent_.size(), first);
  broken_ = false;
  run(300ms);
  ASSERT_GT(sent_.size(), first);
  expect_gentle(sent_, first, config().qdd_max_radps2);
}

TEST_F(ComauDriverTest, TellsTheConstructedAnswer) {
  run(1ms);
  dut_.on_datagram(kAnswerBytes, kRobot, now_);
  ASSERT_EQ(states_.size(), 1u);
  EXPECT_EQ(states_[0].device.view(), "arm");
  EXPECT_EQ(states_[0].sequence_number, 1u);
  EXPECT_EQ(states_[0].frame_counter, 0x01020304u);
  EXPECT_EQ(states_[0].q_rad, (Joints{0, 0.5, -1.5, 0.25, -0.125, 2}));
  EXPECT_EQ(states_[0].qd_radps, (Joints{0.0625, -0.5, 1, -1, 0, 0.25}));
  EXPECT_EQ(states_[0].t_measured_ns, to_ns(now_));
  EXPECT_EQ(states_[0].t_received_ns, to_ns(now_));
  EXPECT_FALSE(states_[0].following);
  EXPECT_FALSE(states_[0].limits_known);
}

TEST_F(ComauDriverTest, TellsTheConstructedLongAnswerWithItsLimits) {
  run(1ms);
  dut_.on_datagram(long_answer_bytes(), kRobot, now_);
  ASSERT_EQ(states_.size(), 1u);
  EXPECT_EQ(states_[0].q_rad, (Joints{0, 0.5, -1.5, 0.25, -0.125, 2}));
  EXPECT_TRUE(states_[0].limits_known);
  EXPECT_EQ(states_[0].q_min_rad, (Joints{-0.75, -0.5, -2.5, -0.125, -0.125, -0.25}));
  EXPECT_EQ(states_[0].q_max_rad, (Joints{0.75, 0.5, -0.75, 0.125, 0.125, 0.25}));
  EXPECT_EQ(states_[0].qd_max_radps, (Joints{0.5, 0.5, 0.5, 0.0625, 0.0625, 4}));
}

TEST_F(ComauDriverTest, SaysWhenTheRobotComputersLimitsAreNarrowerThanItsOwn) {
  answering_ = true;
  const DriverConfig c = config();
  limits_ = ReportedLimits{c.q_min_rad, c.q_max_rad, c.qd_max_radps};
  run(50ms);
  EXPECT_TRUE(dut_.health().advice().empty()) << "rounded to the wire's floats, and yet the same";
  limits_->q_max_rad[2] -= 0.01;
  run(10ms);
  EXPECT_TRUE(advice_has("narrower"));
  limits_ = ReportedLimits{};
  run(10ms);
  EXPECT_FALSE(states_.back().limits_known) << "zeros are no box";
  EXPECT_TRUE(dut_.health().advice().empty());
}

TEST_F(ComauDriverTest, RefusesWhatTheArmCannotHaveDone) {
  answering_ = true;
  run(50ms);
  const auto states = states_.size();
  q_[1] += 0.1;  // 20 rad/s
  run(20ms);
  EXPECT_EQ(states_.size(), states);
  EXPECT_EQ(dut_.health().rejected(Reason::bad_value), 4u);
  q_[1] -= 0.1;
  run(20ms);
  EXPECT_EQ(states_.size(), states + 4);
  q_[1] = 2.0;  // beyond the stroke of 95 degrees
  run(100ms);
  EXPECT_EQ(states_.size(), states + 4);
}

TEST_F(ComauDriverTest, BelievesAnotherFrameCounterOnlyWhenTheNextAnswerGoesOnFromIt) {
  answering_ = true;
  run(50ms);
  const auto states = states_.size();
  for (const std::uint32_t garbage : {0xDEADBEEFu, 0x12345678u, 0x9ABCDEF0u, 0x5A5A5A5Au, 0x40000000u}) {
    receive(garbage, now_);
  }
  EXPECT_EQ(states_.size(), states);
  EXPECT_EQ(dut_.health().rejected(Reason::unexpected), 5u);
  run(20ms);
  EXPECT_EQ(states_.size(), states + 4) << "the true counter was never let go of";
}

TEST_F(ComauDriverTest, CountsEveryReasonForRefusal) {
  run(1ms);
  receive(1000, now_);
  receive(1013, now_ + 5ms, Endpoint{kRobot.address + 1, kRobot.port});
  receive(1013, now_ + 5ms, Endpoint{kRobot.address, 50033});
  receive(1000, now_ + 5ms);
  receive(990, now_ + 5ms);
  dut_.on_datagram(Bytes{kAnswerBytes}.first(51), kRobot, now_ + 5ms);
  dut_.on_datagram(ByteBuffer(125, 0), kRobot, now_ + 5ms);
  measured_qd_[3] = kNaN;
  receive(1013, now_ + 5ms);
  EXPECT_EQ(dut_.health().rejected(Reason::foreign), 2u);
  for (const Reason reason :
       {Reason::duplicate, Reason::out_of_order, Reason::too_short, Reason::too_long, Reason::bad_value}) {
    EXPECT_EQ(dut_.health().rejected(reason), 1u) << to_string(reason);
  }
  EXPECT_EQ(states_.size(), 1u);
}

TEST_F(ComauDriverTest, StampsMeasurementsByTheFrameCounter) {
  answering_ = true;
  run(1s);
  ASSERT_EQ(states_.size(), 200u);
  for (std::size_t k = 100; k < states_.size(); ++k) {
    const double expected = 400e3 * (states_[k].frame_counter - states_[k - 1].frame_counter);
    EXPECT_NEAR(static_cast<double>(states_[k].t_measured_ns - states_[k - 1].t_measured_ns), expected, 2e3);
  }
  EXPECT_EQ(dut_.health().lost(), 0u);
  EXPECT_EQ(dut_.health().phase(), LinkPhase::up);
  EXPECT_TRUE(dut_.feedback_fresh(now_));
}

TEST_F(ComauDriverTest, CountsUnansweredCommandsButNotItsOwnMissedSlots) {
  answering_ = true;
  run(50ms);
  answering_ = false;
  run(25ms);
  answering_ = true;
  run(25ms);
  EXPECT_EQ(dut_.health().lost(), 5u);
  now_ += 100ms;
  run(25ms);
  EXPECT_EQ(dut_.health().lost(), 5u);
}

TEST_F(ComauDriverTest, RunsThroughTheWrapOfTheFrameCounter) {
  for (const std::uint32_t edge : {0x80000000u, 0u}) {
    ComauDriver driver{config(), *this, [this](const topic::ArmState& s) { states_.push_back(s); }};
    states_.clear();
    for (std::uint32_t k = 0; k < 20; ++k) {
      now_ = kStart + k * 5ms;
      driver.step(now_);
      driver.on_datagram(encode(Answer{edge - 125 + 25 * k / 2, {0, 0, -1.5, 0, 0, 0}, {}}), kRobot,
                         now_ + 100us);
    }
    EXPECT_EQ(states_.size(), 20u);
    EXPECT_EQ(driver.health().lost(), 0u);
    EXPECT_EQ(driver.health().reconnects(), 0u);
  }
}

TEST_F(ComauDriverTest, KeepsItsPhaseToTheRobotsCycleWhenTheClocksDrift) {
  constexpr double kDrift = 150e-6;
  const auto robot_s = [](LabTime t) { return (1.0 + kDrift) * seconds(t - kStart); };
  std::optional<double> first_phase;
  double wandered = 0;
  while (now_ < kStart + 120s) {
    now_ = std::max(now_ + 100us, dut_.next_send());
    dut_.step(now_);
    receive(static_cast<std::uint32_t>(robot_s(now_) / 400e-6) + 1000u, now_ + 100us);
    if (now_ < kStart + 60s) continue;  // the drift is learnt
    // How many whole periods of the robot's time it is away from the first send.
    const double since = robot_s(now_);
    if (!first_phase) first_phase = since;
    wandered = std::max(wandered, std::abs(std::remainder(since - *first_phase, 5e-3)));
  }
  EXPECT_LT(wandered, 0.5e-3) << "without that it would be 2.5 ms, all there is";
}

TEST_F(ComauDriverTest, StartsTheClockAfreshWhenTheProgramRestarts) {
  run(1ms);
  receive(5'000'000, now_);
  receive(12, now_ + 4s);
  EXPECT_EQ(states_.size(), 1u);
  receive(25, now_ + 4005ms);
  EXPECT_EQ(dut_.health().reconnects(), 1u);
  ASSERT_EQ(states_.size(), 2u);
  EXPECT_EQ(states_[1].t_measured_ns, to_ns(now_ + 4005ms));
}

TEST_F(ComauDriverTest, BrakesWhenTheFrameCounterStandsStill) {
  follow({0.2, 0, 0, 0, 0, 0});
  answering_ = false;
  const auto states = states_.size();
  const auto first = sent_.size();
  const auto frozen = states_.back().frame_counter;
  for (int k = 0; k < 40; ++k) {
    run(5ms);
    receive(frozen, now_);
    if (k == 2) {
      EXPECT_TRUE(dut_.feedback_fresh(now_));
      EXPECT_EQ(sent_.back().command.qd_radps[0], 0.2F);
    }
  }
  EXPECT_EQ(states_.size(), states) << "an old measurement is not told again";
  EXPECT_FALSE(dut_.feedback_fresh(now_));
  EXPECT_TRUE(advice_has("stands still"));
  expect_gentle(sent_, first);
  run(200ms);
  EXPECT_EQ(sent_.back().command, Command{});
  receive(frozen + 600, now_);
  run(1ms);
  EXPECT_TRUE(dut_.feedback_fresh(now_));
}

TEST_F(ComauDriverTest, BrakesWhenTheRobotComputerFallsSilent) {
  follow({0.2, 0, 0, 0, 0, 0});
  answering_ = false;
  const auto first = sent_.size();
  run(20ms);
  EXPECT_EQ(sent_.back().command.qd_radps[0], 0.2F);
  run(500ms);
  EXPECT_TRUE(advice_has("fresh enough"));
  EXPECT_EQ(dut_.health().phase(), LinkPhase::up);
  run(500ms);
  EXPECT_EQ(dut_.health().phase(), LinkPhase::down);
  EXPECT_TRUE(advice_has("fallen silent"));
  expect_gentle(sent_, first);
  EXPECT_EQ(sent_.back().command, Command{});
}

TEST_F(ComauDriverTest, SaysWhenNobodyHasAnsweredYet) {
  run(900ms);
  EXPECT_TRUE(dut_.health().advice().empty());
  run(200ms);
  EXPECT_EQ(dut_.health().phase(), LinkPhase::connecting);
  EXPECT_TRUE(advice_has("does not answer"));
}

TEST_F(ComauDriverTest, SaysWhenTheArmIsToldToMoveAndDoesNot) {
  follow({0.2, 0, 0, 0, 0, 0});
  EXPECT_TRUE(dut_.health().advice().empty());
  measured_qd_ = {};
  run(190ms);
  EXPECT_FALSE(advice_has("told to move"));
  const auto first = sent_.size();
  run(30ms);
  EXPECT_TRUE(advice_has("told to move"));
  run(500ms);
  expect_gentle(sent_, first);
  EXPECT_EQ(sent_.back().command, Command{}) << "it is not told any more";
  EXPECT_TRUE(advice_has("told to move")) << "whoever presses START now moves nothing";
  refresh_.reset();
  want({}, false);
  run(10ms);
  EXPECT_TRUE(dut_.health().advice().empty());
  measured_qd_ = {0.2, 0, 0, 0, 0, 0};
  refresh_ = measured_qd_;
  run(300ms);
  EXPECT_EQ(sent_.back().command.qd_radps[0], 0.2F);
}

TEST_F(ComauDriverTest, SaysNothingOfHowTheArmMovesAcrossGapsBetweenAnswers) {
  follow({0.2, 0, 0, 0, 0, 0});
  measured_qd_ = {};
  for (int i = 0; i < 10; ++i) {
    run(50ms);
    answering_ = false;
    run(24ms);
    answering_ = true;
    EXPECT_FALSE(advice_has("told to move")) << i;
  }
}

TEST_F(ComauDriverTest, SaysWhenTheArmMovesMoreSlowlyThanItIsTold) {
  follow({0.2, 0, 0, 0, 0, 0});
  run(300ms);
  EXPECT_TRUE(dut_.health().advice().empty()) << dut_.health().advice();
  measured_qd_ = {0.1, 0, 0, 0, 0, 0};
  run(1500ms);
  EXPECT_TRUE(advice_has("override"));
  EXPECT_EQ(sent_.back().command.qd_radps[0], 0.2F);
  measured_qd_ = {0.2, 0, 0, 0, 0, 0};
  run(1500ms);
  EXPECT_FALSE(advice_has("override")) << dut_.health().advice();
}

TEST_F(ComauDriverTest, SurvivesRandomAnswersWithoutChangingACommand) {
  follow({0.2, 0, 0, 0, 0, 0});
  Random random{5};
  for (int i = 0; i < 50000; ++i) {
    ByteBuffer bytes(random.chance(0.7) ? 52 : random.below(200));
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random.bits());
    dut_.on_datagram(bytes, random.chance(0.1) ? Endpoint{} : kRobot, now_);
  }
  run(5ms);
  EXPECT_EQ(sent_.back().command.qd_radps[0], 0.2F);
}

}  // namespace
}  // namespace motionlab::comau
