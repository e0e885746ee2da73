// What goes wrong in the gateway itself: its control stands still, or the process is gone that would brake
// the arm if the gateway died. Each latches, rests within the limits, and resumes nothing.
#include <gtest/gtest.h>

#include <vector>

#include "drivers/comau/comau_wire.hpp"
#include "tests/integration/taken_apart.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

/// What leaves for the arm: how often it was beyond what the driver allows, and whether it asks to move.
class ArmWire {
 public:
  ArmWire(MemoryNetwork& network, const comau::DriverConfig& driver) : driver_(driver) {
    network.on_sent([this](Endpoint, Endpoint to, Bytes datagram, LabTime t) {
      if (to != driver_.robot_computer) return;
      if (const auto command = comau::decode_command(datagram)) take(*command, t);
    });
  }

  [[nodiscard]] std::size_t beyond_limits() const { return beyond_; }
  [[nodiscard]] bool moves() const {
    return std::any_of(qd_radps_.begin(), qd_radps_.end(), [](double qd) { return qd != 0; });
  }
  [[nodiscard]] LabTime moved() const { return moved_; }  ///< when it last asked to move
  void watch_for_speeding_up() { sped_up_ = 0; }
  /// How often a joint was asked to go faster since then.
  [[nodiscard]] std::size_t sped_up() const { return sped_up_; }

 private:
  void take(const comau::Command& command, LabTime t) {
    const bool follows = command.mode == static_cast<std::int32_t>(comau::Mode::follow);
    for (std::size_t i = 0; i < qd_radps_.size(); ++i) {
      const double qd = follows ? static_cast<double>(command.qd_radps[i]) : 0.0;
      const double change = driver_.qdd_max_radps2[i] * driver_.command_period_s;
      if (std::abs(qd) > driver_.qd_max_radps[i] || std::abs(qd - qd_radps_[i]) > change + kRounding)
        ++beyond_;
      if (std::abs(qd) > std::abs(qd_radps_[i])) ++sped_up_;
      qd_radps_[i] = qd;
    }
    if (moves()) moved_ = t;
  }

  static constexpr double kRounding = 1e-7;  // of the wire's floats
  comau::DriverConfig driver_;
  std::array<double, 6> qd_radps_{};
  std::size_t beyond_ = 0, sped_up_ = 0;
  LabTime moved_{};
};

class GatewayFaults : public testing::Test {
 protected:
  void engage() {
    line_.run_to(10);
    line_.ask(ModeAction::engage);
    line_.run_to(22.3);
    ASSERT_EQ(line_.mode().state, ModeState::engaged) << line_.mode().reason.view();
    ASSERT_TRUE(wire_.moves());
  }
  void run_for(Nanoseconds time) { line_.run_to(line_.now_s() + seconds(time)); }
  [[nodiscard]] LabTime now() const { return LabTime{} + from_seconds(line_.now_s()); }
  [[nodiscard]] double fastest_joint() {
    double fastest = 0;
    for (const double qd : line_.lab().world().qd_radps()) fastest = std::max(fastest, std::abs(qd));
    return fastest;
  }
  /// At the stop deceleration, from the fastest that the limits allow.
  [[nodiscard]] Nanoseconds longest_stop() const {
    const auto& driver = config_.gateway.comau.driver;
    return from_seconds(driver.qd_max_radps[0] / driver.stop_deceleration_radps2[0]);
  }

  void expect_latched(std::string_view code, std::string_view word) {
    EXPECT_EQ(line_.mode().state, ModeState::fault);
    EXPECT_TRUE(line_.mode().fault_latched);
    EXPECT_EQ(line_.mode().fault_code.view(), code);
    EXPECT_NE(line_.mode().reason.view().find(word), std::string_view::npos) << line_.mode().reason.view();
  }
  /// For as long as an engagement takes to come to life; engaging is asked for in vain.
  void expect_no_motion() {
    const std::size_t from = line_.steps().size();
    line_.ask(ModeAction::engage);
    for (int i = 0; i < 5000; ++i) {
      run_for(1ms);
      ASSERT_FALSE(wire_.moves());
      ASSERT_LT(fastest_joint(), 1e-3);
    }
    EXPECT_EQ(line_.mode().state, ModeState::fault);
    for (std::size_t k = from; k < line_.steps().size(); ++k) ASSERT_TRUE(line_.steps()[k].at_rest());
  }

  lockstep::Config config_ = configure("thesis-wave");
  TakenApart line_{config_};
  ArmWire wire_{line_.network(), config_.gateway.comau.driver};
  Nanoseconds stale_ = from_seconds(config_.gateway.comau.driver.command_stale_after_s);
  Nanoseconds winch_stale_ = from_seconds(config_.gateway.winch.driver.command_stale_after_s);
};

TEST_F(GatewayFaults, ControlThatStandsStillIsBrakedByTheDriverAndLatchesWhenItComesBack) {
  engage();
  const LabTime stopped = now();
  line_.control_hangs = true;
  run_for(stale_ + longest_stop() + 100ms);
  EXPECT_FALSE(wire_.moves()) << "nobody waits for control";
  EXPECT_LE(wire_.moved() - stopped, stale_ + longest_stop());
  run_for(500ms);
  EXPECT_LT(fastest_joint(), 1e-3);

  line_.control_hangs = false;
  const LabTime moved = wire_.moved();
  run_for(1ms);
  expect_latched("control_late", "reset");
  run_for(2s);
  EXPECT_EQ(wire_.moved(), moved) << "what rests is not taken up again to be braked";
  EXPECT_LT(fastest_joint(), 1e-3);
  expect_no_motion();
  EXPECT_EQ(wire_.beyond_limits(), 0U);

  line_.ask(ModeAction::reset);
  run_for(2s);
  EXPECT_EQ(line_.mode().state, ModeState::ready) << line_.mode().reason.view();
  EXPECT_FALSE(wire_.moves()) << "a reset engages nothing";
  line_.ask(ModeAction::engage);
  run_for(100ms);
  EXPECT_EQ(line_.mode().state, ModeState::engaged) << line_.mode().reason.view();
}

TEST_F(GatewayFaults, ControlThatComesBackInTheMiddleOfTheBrakingDoesNotTakeTheArmUpAgain) {
  engage();
  line_.control_hangs = true;
  run_for(winch_stale_ + 10ms);
  ASSERT_TRUE(wire_.moves()) << "the driver still brakes";
  wire_.watch_for_speeding_up();
  line_.control_hangs = false;
  const LabTime back = now();
  run_for(2s);
  expect_latched("control_late", "reset");
  EXPECT_LE(wire_.moved() - back, longest_stop() + 10ms);
  EXPECT_EQ(wire_.sped_up(), 0U);
  EXPECT_EQ(wire_.beyond_limits(), 0U);
  expect_no_motion();
}

TEST_F(GatewayFaults, ControlThatIsLateByLessThanTheArmWaitsGoesOn) {
  engage();
  line_.control_hangs = true;
  run_for(stale_ - 5ms);
  line_.control_hangs = false;
  run_for(2s);
  EXPECT_EQ(line_.mode().state, ModeState::engaged) << line_.mode().reason.view();
  EXPECT_EQ(wire_.beyond_limits(), 0U);
}

TEST_F(GatewayFaults, WithoutADeadmanItRestsAndOnlyANewGatewayMovesAgain) {
  engage();
  const LabTime lost = now();
  line_.lose_deadman();
  run_for(2s);
  expect_latched("deadman_lost", "restart");
  const auto stop = last_stop(line_.steps(), config_.gateway.limits, config_.gateway.control_period_s);
  ASSERT_TRUE(stop);
  EXPECT_LE(stop->t_ramp - lost, 2ms);
  EXPECT_LE(wire_.moved() - lost, longest_stop() + 10ms);
  EXPECT_EQ(steps_beyond_limits(line_.steps(), config_.gateway.limits, config_.gateway.control_period_s), 0U);
  EXPECT_EQ(wire_.beyond_limits(), 0U);
  expect_no_motion();

  line_.ask(ModeAction::reset);
  run_for(100ms);
  expect_latched("deadman_lost", "restart");
  expect_no_motion();
}

TEST_F(GatewayFaults, WithoutADeadmanNothingIsEngaged) {
  line_.run_to(10);
  ASSERT_EQ(line_.mode().state, ModeState::ready);
  line_.lose_deadman();
  run_for(10ms);
  line_.ask(ModeAction::engage);
  run_for(2s);
  EXPECT_EQ(line_.mode().state, ModeState::settled);
  EXPECT_EQ(line_.mode().fault_code.view(), "deadman_lost");
  EXPECT_FALSE(wire_.moves());
  EXPECT_LT(fastest_joint(), 1e-3);
}

}  // namespace
}  // namespace motionlab::integration
