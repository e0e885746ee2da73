// What is said to a robot computer so that its arm comes to rest; judged by an arm that does what it is told.
#include "gateway/deadman/brake_sequence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "drivers/comau/comau_driver.hpp"

namespace motionlab::deadman {
namespace {

using comau::Command;
using comau::Joints;
using End = BrakeSequence::End;

constexpr double kDeceleration = 1.0;
constexpr Nanoseconds kPeriod = 5ms;

BrakeSequence::Config config() {
  comau::DriverConfig driver;
  driver.stop_deceleration_radps2.fill(kDeceleration);
  return {.shaper = comau::shaper_config(driver)};
}

Command following(const std::array<float, 6>& qd) {
  Command command;
  command.mode = 1;
  command.qd_radps = qd;
  return command;
}

/// A robot computer and an arm that follows it with a lag, each step of 1 ms.
class Arm {
 public:
  explicit Arm(const Joints& moving = {}) : qd_(moving), told_(following({})) {
    for (std::size_t i = 0; i < 6; ++i) told_.qd_radps[i] = static_cast<float>(moving[i]);
  }

  /// Runs the sequence to its end. @returns that
  End run(BrakeSequence& brake, bool answers = true) {
    for (;; now_ += 1ms) {
      while (const auto command = brake.due(now_)) {
        said.push_back(*command);
        told_ = *command;
        if (answers) brake.heard({.frame_counter = 1, .q_rad = {}, .qd_radps = qd_}, now_);
      }
      for (std::size_t i = 0; i < 6; ++i) {
        const double wanted = told_.mode == 1 ? static_cast<double>(told_.qd_radps[i]) : 0.0;
        qd_[i] += stuck ? 0.0 : (wanted - qd_[i]) * 0.025;
      }
      if (const End end = brake.end(now_); end != End::not_yet) return end;
      if (now_ - LabTime{} > 60s) return End::not_yet;
    }
  }

  std::vector<Command> said;
  bool stuck = false;
  [[nodiscard]] LabTime now() const { return now_; }

 private:
  Joints qd_;
  Command told_;
  LabTime now_{};
};

/// The steps from each command to the next are those of braking, and mode 0 is never left.
void expect_ramp(const std::vector<Command>& said, std::size_t from = 0) {
  for (std::size_t i = from + 1; i < said.size(); ++i) {
    ASSERT_FALSE(said[i - 1].mode == 0 && said[i].mode != 0) << i;
    for (std::size_t joint = 0; joint < 6; ++joint) {
      const double before = static_cast<double>(said[i - 1].qd_radps[joint]);
      const double after = static_cast<double>(said[i].qd_radps[joint]);
      ASSERT_LE(std::abs(after), std::abs(before));
      ASSERT_LE(std::abs(before - after), kDeceleration * seconds(kPeriod) + 1e-7);
    }
  }
}

TEST(BrakeSequence, GoesDownFromWhatWasSaidLastAndHolds) {
  const Command last = following({0.5F, -0.3F, 0.1F, 0.02F, 0.0F, -0.04F});
  BrakeSequence brake(config(), LabTime{}, Said{last, 1ms});
  Arm arm({0.5, -0.3, 0.1, 0.02, 0.0, -0.04});
  EXPECT_EQ(arm.run(brake), End::at_rest);
  EXPECT_FLOAT_EQ(arm.said.front().qd_radps[0], 0.495F);
  EXPECT_EQ(arm.said.front().mode, 1);
  expect_ramp(arm.said);
  EXPECT_EQ(arm.said.back(), Command{});
  EXPECT_GE(std::ranges::count(arm.said, Command{}), 20);
}

TEST(BrakeSequence, SaysTheFirstAtOnceAndTheOthersOnTheCommandPeriod) {
  BrakeSequence brake(config(), LabTime{} + 1s, Said{following({0.5F}), 1ms});
  EXPECT_TRUE(brake.due(LabTime{} + 1s));
  EXPECT_FALSE(brake.due(LabTime{} + 1s + 4ms));
  EXPECT_TRUE(brake.due(LabTime{} + 1s + 5ms));
  EXPECT_TRUE(brake.due(LabTime{} + 1s + 23ms));
  EXPECT_FALSE(brake.due(LabTime{} + 1s + 24ms));
  EXPECT_TRUE(brake.due(LabTime{} + 1s + 25ms));
}

TEST(BrakeSequence, OfAnArmThatWasHeldOnlyHolds) {
  BrakeSequence brake(config(), LabTime{}, Said{Command{}, 1ms});
  Arm arm;
  EXPECT_EQ(arm.run(brake), End::at_rest);
  for (const Command& command : arm.said) ASSERT_EQ(command, Command{});
}

TEST(BrakeSequence, GoesOnFromWhereARobotComputerWithAWatchdogHasCome) {
  BrakeSequence::Config watched = config();
  watched.robot_brakes_after_s = 0.020;
  BrakeSequence brake(watched, LabTime{}, Said{following({0.5F, -0.1F}), 220ms});
  Arm arm({0.3, 0.0});
  EXPECT_EQ(arm.run(brake), End::at_rest);
  EXPECT_NEAR(arm.said.front().qd_radps[0], 0.3 - 0.005, 1e-6);
  EXPECT_EQ(arm.said.front().qd_radps[1], 0.0F);
  expect_ramp(arm.said);
}

TEST(BrakeSequence, DoesNotSetAnArmInMotionThatItsWatchdogHasStopped) {
  BrakeSequence::Config watched = config();
  watched.robot_brakes_after_s = 0.020;
  BrakeSequence brake(watched, LabTime{}, Said{following({0.5F}), 10s});
  Arm arm;
  EXPECT_EQ(arm.run(brake), End::at_rest);
  for (const Command& command : arm.said) ASSERT_EQ(command.qd_radps, Command{}.qd_radps);
}

TEST(BrakeSequence, WithNothingKnownAsksAndGoesOnFromTheMeasuredSpeed) {
  BrakeSequence brake(config(), LabTime{}, std::nullopt);
  Arm arm({0.4, -0.2, 0, 0, 0, 0});
  EXPECT_EQ(arm.run(brake), End::at_rest);
  EXPECT_EQ(arm.said[0], following({}));
  EXPECT_EQ(arm.said[1], following({0.4F, -0.2F}));
  expect_ramp(arm.said, 1);
}

TEST(BrakeSequence, WithNothingKnownAndTheArmAtRestMovesNothing) {
  BrakeSequence brake(config(), LabTime{}, std::nullopt);
  Arm arm({0.001, -0.002, 0, 0, 0, 0});
  EXPECT_EQ(arm.run(brake), End::at_rest);
  for (const Command& command : arm.said) ASSERT_EQ(command.qd_radps, Command{}.qd_radps);
}

TEST(BrakeSequence, NeverAsksForMoreThanTheDriversSpeeds) {
  BrakeSequence brake(config(), LabTime{}, std::nullopt);
  (void)brake.due(LabTime{});
  brake.heard({.frame_counter = 1, .q_rad = {}, .qd_radps = {9, -9, 9, -9, 9, -9}}, LabTime{});
  const auto command = brake.due(LabTime{});
  ASSERT_TRUE(command);
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_LE(std::abs(static_cast<double>(command->qd_radps[i])), config().shaper.qd_max_radps[i] + 1e-6);
  }
}

TEST(BrakeSequence, TellsAnArmThatGoesOnMoving) {
  BrakeSequence brake(config(), LabTime{}, Said{following({0.2F}), 1ms});
  Arm arm({0.2, 0, 0, 0, 0, 0});
  arm.stuck = true;
  EXPECT_EQ(arm.run(brake), End::moving);
  EXPECT_GT(arm.now() - LabTime{}, 5s);
}

TEST(BrakeSequence, BrakesARobotComputerThatDoesNotAnswerAndSaysSo) {
  BrakeSequence brake(config(), LabTime{}, Said{following({0.2F}), 1ms});
  Arm arm({0.2, 0, 0, 0, 0, 0});
  EXPECT_EQ(arm.run(brake, false), End::silent);
  expect_ramp(arm.said);
  EXPECT_EQ(arm.said.back(), Command{});
}

TEST(BrakeSequence, WithNothingKnownAndNoAnswerNeverAsksForMotion) {
  BrakeSequence brake(config(), LabTime{}, std::nullopt);
  Arm arm;
  EXPECT_EQ(arm.run(brake, false), End::silent);
  for (const Command& command : arm.said) ASSERT_EQ(command, following({}));
}

}  // namespace
}  // namespace motionlab::deadman
