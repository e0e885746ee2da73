// The simulated PLC's program alone: command bytes in, set point and status bytes out, on stepped time.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "simulators/winch/winch_device_plc.hpp"

namespace motionlab::winch {
namespace {

/// The program with an ideal drive and a client that writes every 10 ms.
class Plc {
 public:
  explicit Plc(const PlcConfig& config = {}) : dut(config) {}

  void write(PlcCommand c) {
    c.heartbeat = ++heartbeat_;
    LittleWriter writer{dut.memory().first(kCommandSize)};
    c.encode(writer);
  }

  void run(Nanoseconds duration) {
    for (const LabTime end = t + duration; t < end;) {
      t += 5ms;
      if (beating && to_ns(t) % 10'000'000 == 0) write(command);
      const double length = dut.brake_closed() ? length_m_ : dut.set_point_m();
      const double speed = (length - length_m_) / 0.005;
      length_m_ = length;
      dut.cycle(t, {length, speed, 0.1, 40.0});
      speed_max = std::max(speed_max, std::abs(speed - speed_));
      speed_ = speed;
    }
  }

  void engage(PlcMode mode = PlcMode::hold) {
    command.mode = mode;
    run(50ms);
    command.enable = true;
    run(200ms);
  }

  [[nodiscard]] PlcStatus status() {
    const auto decoded = PlcStatus::decode(dut.memory().subspan(PlcProgram::kStatusAt));
    EXPECT_TRUE(decoded.ok());
    return decoded.ok() ? *decoded : PlcStatus{};
  }

  PlcProgram dut;
  PlcCommand command{};
  bool beating = true;
  LabTime t{10s};
  double speed_max = 0;  ///< greatest change of speed from one cycle to the next

 private:
  std::uint32_t heartbeat_ = 0;
  double length_m_ = 2.0;
  double speed_ = 0;
};

TEST(WinchPlc, IsOffWithTheBrakeClosedBeforeAnyCommand) {
  Plc plc;
  plc.beating = false;
  plc.run(1s);
  const auto status = plc.status();
  EXPECT_EQ(status.state, PlcState::off);
  EXPECT_FALSE(status.enabled);
  EXPECT_FALSE(status.communication_ok);
  EXPECT_FALSE(status.warning) << "memory that nobody wrote is not a bad command";
  EXPECT_EQ(status.watchdog_trips, 0U);
  EXPECT_EQ(status.cycle_count, 200U);
  EXPECT_TRUE(plc.dut.brake_closed());
  EXPECT_NEAR(plc.dut.set_point_m(), 2.0, 1e-12);
}

TEST(WinchPlc, TakesATenthOfASecondToEnableAndOpensTheBrakeOnTheWay) {
  Plc plc;
  plc.command.mode = PlcMode::hold;
  plc.run(50ms);
  plc.command.enable = true;
  plc.run(50ms);
  EXPECT_EQ(plc.status().state, PlcState::enabling);
  EXPECT_FALSE(plc.status().enabled);
  EXPECT_TRUE(plc.dut.brake_closed());
  plc.run(70ms);
  EXPECT_EQ(plc.status().state, PlcState::hold);
  EXPECT_TRUE(plc.status().enabled);
  EXPECT_FALSE(plc.dut.brake_closed());
}

TEST(WinchPlc, DoesNotEnableWithoutHavingSeenEnableLow) {
  Plc plc;
  plc.command.mode = PlcMode::hold;
  plc.command.enable = true;
  plc.run(500ms);
  EXPECT_EQ(plc.status().state, PlcState::off);
  plc.command.enable = false;
  plc.run(50ms);
  plc.command.enable = true;
  plc.run(200ms);
  EXPECT_EQ(plc.status().state, PlcState::hold);
}

TEST(WinchPlc, LimitsTheAcceleration) {
  Plc plc;
  plc.engage(PlcMode::velocity);
  plc.command.velocity_mps = 0.5;
  plc.run(500ms);
  EXPECT_NEAR(plc.status().velocity_mps, 0.5, 1e-9);
  plc.command.velocity_mps = -0.5;
  plc.run(500ms);
  EXPECT_NEAR(plc.status().velocity_mps, -0.5, 1e-9);
  EXPECT_LE(plc.speed_max, 3.567 * 0.005 + 1e-9);
}

TEST(WinchPlc, RefusesBadCommandsAndKeepsTheLastGoodOne) {
  for (const int kind : {0, 1, 2, 3, 4}) {
    Plc plc;
    plc.engage(PlcMode::velocity);
    plc.command.velocity_mps = 0.1;
    plc.run(100ms);
    const auto echo = plc.status().heartbeat_echo;
    plc.beating = false;
    PlcCommand bad = plc.command;
    if (kind == 0) bad.velocity_mps = std::numeric_limits<double>::quiet_NaN();
    if (kind == 1) bad.velocity_mps = 2.5;
    if (kind == 2) bad.acceleration_mps2 = -3.6;
    if (kind == 3) bad.position_m = std::numeric_limits<double>::infinity();
    plc.write(bad);
    if (kind == 4) plc.dut.memory()[0] = 2;  // layout version
    plc.run(20ms);
    const auto status = plc.status();
    EXPECT_TRUE(status.warning) << kind;
    EXPECT_EQ(status.heartbeat_echo, echo) << kind;
    EXPECT_NEAR(status.velocity_mps, 0.1, 1e-9) << kind;
    EXPECT_EQ(plc.dut.refused(), 1U) << kind;
    plc.run(200ms);
    EXPECT_EQ(plc.status().state, PlcState::communication_lost) << "a refused heartbeat is none, " << kind;
  }
}

TEST(WinchPlc, StopsBeforeItsSoftLimitsFromFullSpeed) {
  Plc plc;
  plc.engage(PlcMode::velocity);
  for (const double velocity : {2.3, -2.3}) {
    plc.command.velocity_mps = velocity;
    plc.run(3s);
    const auto status = plc.status();
    EXPECT_GE(status.position_m, -1e-12);
    EXPECT_LE(status.position_m, 1.5 + 1e-12);
    EXPECT_NEAR(status.position_m, velocity > 0 ? 1.5 : 0.0, 2e-3);
    EXPECT_EQ(velocity > 0 ? status.at_max : status.at_min, true);
    EXPECT_TRUE(status.warning);
  }
  EXPECT_LE(plc.speed_max, 3.567 * 0.005 + 1e-9);
}

TEST(WinchPlc, ALostHeartbeatRampsHoldsLatchesAndPowersOffAfterFiveSeconds) {
  Plc plc;
  plc.engage(PlcMode::velocity);
  plc.command.velocity_mps = 0.2;
  plc.run(500ms);
  plc.beating = false;
  plc.run(95ms);
  EXPECT_EQ(plc.status().state, PlcState::velocity);
  plc.run(15ms);
  EXPECT_EQ(plc.status().state, PlcState::communication_lost);
  EXPECT_FALSE(plc.status().communication_ok);
  EXPECT_EQ(plc.status().watchdog_trips, 1U);
  plc.run(60ms);  // 0.2 m/s at 3.5 m/s^2 take 57 ms
  EXPECT_EQ(plc.status().velocity_mps, 0.0);
  EXPECT_TRUE(plc.status().enabled);
  const double held = plc.dut.set_point_m();
  plc.run(4700ms);
  EXPECT_TRUE(plc.status().enabled);
  EXPECT_FALSE(plc.dut.brake_closed());
  EXPECT_EQ(plc.dut.set_point_m(), held);
  plc.run(200ms);
  EXPECT_FALSE(plc.status().enabled);
  EXPECT_TRUE(plc.dut.brake_closed());
  EXPECT_EQ(plc.status().state, PlcState::communication_lost);
}

TEST(WinchPlc, LeavesTheLatchOnlyByHeartbeatEnableLowResetAndEnableInThatOrder) {
  Plc plc;
  plc.engage();
  plc.beating = false;
  plc.run(300ms);
  plc.beating = true;
  plc.run(300ms);
  EXPECT_EQ(plc.status().state, PlcState::communication_lost) << "the heartbeat alone";
  plc.command.reset = true;
  plc.run(50ms);
  EXPECT_EQ(plc.status().state, PlcState::communication_lost) << "a reset with enable high";
  plc.command.enable = false;
  plc.run(50ms);
  EXPECT_EQ(plc.status().state, PlcState::communication_lost) << "a reset held high is no edge";
  plc.command.enable = true;
  plc.run(50ms);
  EXPECT_EQ(plc.status().state, PlcState::communication_lost) << "an enable edge without a reset";
  plc.command.enable = false;
  plc.command.reset = false;
  plc.run(50ms);
  plc.command.reset = true;
  plc.run(50ms);
  EXPECT_EQ(plc.status().state, PlcState::off);
  EXPECT_FALSE(plc.status().enabled);
  plc.command.reset = false;
  plc.command.enable = true;
  plc.run(200ms);
  EXPECT_EQ(plc.status().state, PlcState::hold);
}

TEST(WinchPlc, ClampsTheWatchdogTime) {
  const auto trips_after = [](std::chrono::milliseconds wanted) {
    Plc plc;
    plc.command.timeout = wanted;
    plc.engage();
    plc.beating = false;
    const LabTime start = plc.t;
    while (plc.status().state != PlcState::communication_lost) plc.run(5ms);
    return std::chrono::duration_cast<std::chrono::milliseconds>(plc.t - start).count();
  };
  EXPECT_NEAR(static_cast<double>(trips_after(std::chrono::milliseconds{0})), 100, 10);
  EXPECT_NEAR(static_cast<double>(trips_after(std::chrono::milliseconds{1})), 20, 10);
  EXPECT_NEAR(static_cast<double>(trips_after(std::chrono::milliseconds{200})), 200, 10);
  EXPECT_NEAR(static_cast<double>(trips_after(std::chrono::milliseconds{9000})), 500, 10);
}

TEST(WinchPlc, ALostHeartbeatWhileOffOnlyClearsCommOk) {
  Plc plc;
  plc.run(100ms);
  EXPECT_TRUE(plc.status().communication_ok);
  plc.beating = false;
  plc.run(300ms);
  EXPECT_FALSE(plc.status().communication_ok);
  EXPECT_EQ(plc.status().state, PlcState::off);
  EXPECT_EQ(plc.status().watchdog_trips, 0U);
}

TEST(WinchPlc, QuickStopHoldsAndModeOffPowersOff) {
  Plc plc;
  plc.engage(PlcMode::velocity);
  plc.command.velocity_mps = 0.5;
  plc.run(400ms);
  plc.command.quick_stop = true;
  plc.run(50ms);
  EXPECT_EQ(plc.status().state, PlcState::stopping);
  plc.run(200ms);
  EXPECT_EQ(plc.status().state, PlcState::hold);
  EXPECT_TRUE(plc.status().enabled);
  plc.command.quick_stop = false;
  plc.run(300ms);
  EXPECT_EQ(plc.status().state, PlcState::velocity);
  plc.command.mode = PlcMode::off;
  plc.run(300ms);
  EXPECT_EQ(plc.status().state, PlcState::off);
  EXPECT_TRUE(plc.dut.brake_closed());
}

TEST(WinchPlc, RefusesToEnableInPositionModeAwayFromTheSetPoint) {
  Plc plc;
  plc.command.position_m = 0.81;  // the axis is at 0.8
  plc.engage(PlcMode::position);
  EXPECT_EQ(plc.status().state, PlcState::off);
  EXPECT_TRUE(plc.status().warning);
  plc.command.position_m = 0.804;
  plc.run(500ms);
  EXPECT_EQ(plc.status().state, PlcState::position);
  EXPECT_NEAR(plc.status().position_m, 0.804, 1e-9);
}

TEST(WinchPlc, FollowsAPositionSineWithoutLagOfItsOwn) {
  Plc plc;
  plc.command.position_m = 0.8;
  plc.engage(PlcMode::position);
  double worst = 0;
  const LabTime start = plc.t;
  for (int i = 0; i < 400; ++i) {
    const double x = 0.2 * std::sin(seconds(plc.t + 10ms - start));
    plc.command.position_m = 0.8 + x;
    plc.command.velocity_mps = 0.2 * std::cos(seconds(plc.t + 10ms - start));
    plc.run(10ms);
    if (i > 100) worst = std::max(worst, std::abs(plc.status().set_position_m - plc.command.position_m));
  }
  EXPECT_LT(worst, 1e-3);
}

TEST(WinchPlc, ADriveFaultLatchesUntilTheCauseIsGoneAndReset) {
  Plc plc;
  plc.engage();
  plc.dut.drive_fault(0xF123);
  plc.run(100ms);
  auto status = plc.status();
  EXPECT_EQ(status.state, PlcState::fault);
  EXPECT_TRUE(status.error);
  EXPECT_FALSE(status.ready);
  EXPECT_FALSE(status.enabled);
  EXPECT_EQ(status.drive_diagnosis, 0xF123U);
  EXPECT_NE(status.axis_error_id, 0U);
  EXPECT_NE(status.axis_state & 0x80000000U, 0U);
  EXPECT_TRUE(plc.dut.brake_closed());
  plc.dut.drive_fault(std::nullopt);
  plc.run(100ms);
  EXPECT_EQ(plc.status().state, PlcState::fault) << "the latch stays";
  plc.command.enable = false;
  plc.command.reset = true;
  plc.run(50ms);
  EXPECT_EQ(plc.status().state, PlcState::off);
  EXPECT_EQ(plc.status().drive_diagnosis, 0U);
}

TEST(WinchPlc, AStoppedPlcRampsToRestAndFreezesItsStatus) {
  Plc plc;
  plc.engage(PlcMode::velocity);
  plc.command.velocity_mps = 0.5;
  plc.run(400ms);
  const auto before = plc.status();
  plc.dut.run(false);
  plc.run(400ms);
  EXPECT_EQ(plc.status().cycle_count, before.cycle_count);
  EXPECT_TRUE(plc.dut.brake_closed());
  plc.dut.run(true);
  plc.run(300ms);
  EXPECT_EQ(plc.status().state, PlcState::off) << "enable held high must not resume";
}

}  // namespace
}  // namespace motionlab::winch
