// Driver and simulated PLC on one wire, on stepped time.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/winch/winch_bench.hpp"

namespace motionlab::winch {
namespace {

using Mode = topic::WinchCommandMode;
using State = topic::WinchDriveState;

bool advises(const Bench& bench, std::string_view words) {
  return bench.driver_->health().advice().find(words) != std::string_view::npos;
}

TEST(WinchPair, ConnectsAndTellsTheStatusAtItsRate) {
  Bench bench;
  bench.run(1s);
  const auto& health = bench.driver_->health();
  EXPECT_EQ(health.phase(), LinkPhase::up);
  EXPECT_TRUE(health.advice().empty()) << health.advice();
  EXPECT_EQ(health.rejected_total(), 0U);
  EXPECT_EQ(health.lost(), 0U);
  EXPECT_NEAR(static_cast<double>(bench.states_.size()), 98, 3);
  EXPECT_EQ(bench.driver_->device_info().name.view(), "Plc30 App");
  const auto& state = bench.last();
  EXPECT_EQ(state.device.view(), "winch");
  EXPECT_EQ(state.drive_state, State::off);
  EXPECT_TRUE(state.ready);
  EXPECT_FALSE(state.enabled);
  EXPECT_TRUE(state.homed);
  EXPECT_TRUE(state.command_path_alive);
  EXPECT_DOUBLE_EQ(state.wire_length_m, 2.0);
  EXPECT_DOUBLE_EQ(state.wire_length_min_m, 1.2);
  EXPECT_DOUBLE_EQ(state.wire_length_max_m, 2.7);
  EXPECT_EQ(state.motor_torque_nm, 0.5);
  EXPECT_EQ(state.motor_temperature_degc, 41.0);
  EXPECT_LE(state.t_measured_ns, state.t_received_ns);
  EXPECT_LT(state.t_received_ns - state.t_measured_ns, 2'000'000);
}

TEST(WinchPair, SaysNothingBeforeThePlcCycles) {
  Bench bench;
  bench.plc_alive = false;
  bench.run(500ms);
  EXPECT_TRUE(bench.states_.empty());
  EXPECT_NE(bench.driver_->health().phase(), LinkPhase::up);
}

TEST(WinchPair, MapsTheAxisToFreeWireLengthWithTheConfiguredSign) {
  DriverConfig driver;
  DeviceConfig device;
  driver.pay_out_sign = device.plc.pay_out_sign = -1.0;
  driver.wire_at_zero_travel_m = device.plc.wire_at_zero_travel_m = 9.0;
  device.plc.position_min_m = 6.0;  // 3 m of free wire
  device.plc.position_max_m = 7.5;  // 1.5 m
  Bench bench{driver, device};
  bench.engage();
  EXPECT_NEAR(bench.last().wire_length_m, 2.0, 1e-12);
  EXPECT_DOUBLE_EQ(bench.last().wire_length_min_m, 1.5);
  EXPECT_DOUBLE_EQ(bench.last().wire_length_max_m, 3.0);
  bench.command = Bench::make(Mode::velocity, true, 0.2);
  bench.run(1s);
  EXPECT_NEAR(bench.last().wire_speed_mps, 0.2, 1e-9);
  EXPECT_GT(bench.last().wire_length_m, 2.15);
}

TEST(WinchPair, FollowsAVelocityCommandOnceEnabled) {
  Bench bench;
  bench.engage();
  EXPECT_EQ(bench.last().drive_state, State::hold);
  EXPECT_TRUE(bench.last().enabled);
  EXPECT_FALSE(bench.device_->brake_closed());
  bench.command = Bench::make(Mode::velocity, true, 0.2);
  const double before = bench.device_->set_point_m();
  bench.run(1s);
  EXPECT_EQ(bench.last().drive_state, State::velocity);
  // 1 s at 0.2 m/s, less half the ramp (28 ms) and the way of the command (at most 25 ms)
  EXPECT_NEAR(bench.device_->set_point_m() - before, 0.2 - 0.2 * 0.04, 0.2 * 0.02);
  EXPECT_NEAR(bench.last().wire_speed_mps, 0.2, 1e-9);
  EXPECT_EQ(bench.driver_->health().rejected_total(), 0U);
}

TEST(WinchPair, WritesOneCommandPerPeriodAndMeasuresTheRoundTrip) {
  Bench bench;
  bench.run(500ms);
  const auto before = bench.driver_->counters().commands_written;
  bench.run(1s);
  EXPECT_EQ(bench.driver_->counters().commands_written - before, 100U);
  EXPECT_EQ(bench.driver_->counters().commands_skipped, 0U);
  EXPECT_LE(bench.driver_->round_trip().p50(), 2ms);
}

TEST(WinchPair, FollowsAPositionStreamAndStopsAtTheSoftLimit) {
  Bench bench;
  bench.engage();
  bench.command = Bench::make(Mode::position, true, 2.3);
  bench.run(1500ms);
  EXPECT_EQ(bench.last().drive_state, State::position);
  EXPECT_NEAR(bench.last().wire_length_m, 2.3, 1e-6);
  bench.command = Bench::make(Mode::velocity, true, 1.0);
  bench.run(2s);
  EXPECT_LE(bench.last().wire_length_m, 2.7 + 1e-12);
  EXPECT_NEAR(bench.last().wire_length_m, 2.7, 1e-3);
  EXPECT_TRUE(bench.last().at_upper_limit);
  EXPECT_NEAR(bench.last().wire_speed_mps, 0.0, 1e-2);
}

TEST(WinchPair, TurnsAStaleCommandIntoStopAndHold) {
  Bench bench;
  bench.engage();
  bench.command = Bench::make(Mode::velocity, true, 0.2);
  bench.run(500ms);
  bench.command.reset();
  bench.run(200ms);
  EXPECT_EQ(bench.last().drive_state, State::hold);
  EXPECT_TRUE(bench.last().enabled);
  EXPECT_NEAR(bench.last().wire_speed_mps, 0.0, 1e-12);
  EXPECT_EQ(bench.driver_->counters().commands_stale, 1U);
  EXPECT_EQ(bench.last().watchdog_trips, 0U) << "the heartbeat goes on";
}

TEST(WinchPair, RefusesCommandsThatAreNotFiniteOldOrForeign) {
  Bench bench;
  bench.run(100ms);
  auto c = Bench::make(Mode::velocity, true, std::nan(""));
  EXPECT_EQ(bench.give(c).fault().reason, Reason::bad_value);
  ASSERT_TRUE(bench.give(Bench::make(Mode::hold, false)).ok());
  c = Bench::make(Mode::velocity, true, 0.1);
  c.t_created_ns = to_ns(bench.now()) - 1;
  EXPECT_EQ(bench.driver_->set_command(c).fault().reason, Reason::out_of_order);
  c.device = "another";
  EXPECT_EQ(bench.give(c).fault().reason, Reason::foreign);
  EXPECT_EQ(bench.driver_->health().rejected(Reason::bad_value), 1U);
  EXPECT_EQ(bench.driver_->health().rejected(Reason::out_of_order), 1U);
  EXPECT_EQ(bench.driver_->health().rejected(Reason::foreign), 1U);
}

TEST(WinchPair, ACommandFromTheFutureStillBecomesStale) {
  Bench bench;
  bench.engage();
  bench.command.reset();
  auto c = Bench::make(Mode::velocity, true, 0.2);
  c.t_created_ns = to_ns(bench.now() + 1h);
  ASSERT_TRUE(bench.driver_->set_command(c).ok());
  bench.run(300ms);
  EXPECT_EQ(bench.last().drive_state, State::hold);
}

TEST(WinchPair, ALostLinkRampsHoldsAndLatchesAndNeverResumesByItself) {
  Bench bench;
  bench.engage();
  bench.command = Bench::make(Mode::velocity, true, 0.2);
  bench.run(500ms);
  bench.network_.set_stream_fault(Bench::kPlc, {.silent = true});
  bench.run(1s);
  EXPECT_EQ(bench.device_->plc().state(), PlcState::communication_lost);
  const double held = bench.device_->set_point_m();
  bench.run(500ms);
  EXPECT_EQ(bench.device_->set_point_m(), held);
  EXPECT_NE(bench.driver_->health().phase(), LinkPhase::up);

  bench.network_.set_stream_fault(Bench::kPlc, {});
  bench.run(8s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_GE(bench.driver_->health().reconnects(), 1U);
  EXPECT_EQ(bench.last().drive_state, State::communication_lost) << "enable held high must not resume";
  EXPECT_TRUE(advises(bench, "watchdog tripped"));
  EXPECT_EQ(bench.last().watchdog_trips, 1U);

  // A new enable edge alone does nothing while the PLC is latched.
  bench.command = Bench::make(Mode::hold, false);
  bench.run(100ms);
  bench.command->enable = true;
  bench.run(300ms);
  EXPECT_EQ(bench.last().drive_state, State::communication_lost);

  // Reset, then a new edge.
  bench.command = Bench::make(Mode::hold, false);
  bench.run(100ms);
  bench.command->reset = true;
  bench.run(200ms);
  EXPECT_EQ(bench.last().drive_state, State::off);
  EXPECT_TRUE(bench.driver_->health().advice().empty());
  bench.command->reset = false;
  bench.command->enable = true;
  bench.run(300ms);
  EXPECT_EQ(bench.last().drive_state, State::hold);
}

TEST(WinchPair, DoesTheEdgesItselfWhenResetAndEnableRiseTogether) {
  Bench bench;
  bench.engage();
  ASSERT_TRUE(bench.device_->set_fault("drive_fault", true, 0xF011).ok());
  bench.run(200ms);
  EXPECT_EQ(bench.last().drive_state, State::fault);
  EXPECT_TRUE(bench.last().error);
  EXPECT_EQ(bench.last().drive_diagnosis, 0xF011U);
  EXPECT_NE(bench.last().axis_error_id, 0U);
  EXPECT_TRUE(bench.device_->brake_closed());
  EXPECT_TRUE(advises(bench, "drive or axis fault"));

  bench.command = Bench::make(Mode::hold, false);
  bench.run(50ms);
  bench.command = Bench::make(Mode::hold, true, 0.0, true);
  bench.run(700ms);
  EXPECT_EQ(bench.last().drive_state, State::fault) << "the cause is still there";

  ASSERT_TRUE(bench.device_->set_fault("drive_fault", false).ok());
  bench.command = Bench::make(Mode::hold, false);
  bench.run(50ms);
  bench.command = Bench::make(Mode::hold, true, 0.0, true);
  bench.run(500ms);
  EXPECT_EQ(bench.last().drive_state, State::hold);
}

TEST(WinchPair, AnEnableHeldHighThroughAReconnectDoesNotCount) {
  Bench bench;
  bench.engage();
  bench.network_.reset_streams(Bench::kPlc);
  bench.run(2s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_FALSE(bench.driver_->health().reconnects() == 0);
  bench.run(1s);
  EXPECT_NE(bench.last().drive_state, State::hold);
  EXPECT_EQ(bench.device_->subscriptions(), 2U) << "those of the connection before are deleted";
  EXPECT_EQ(bench.driver_->counters().foreign_notifications, 0U);
}

TEST(WinchPair, DeletesTheNotificationsOfAFormerGateway) {
  Bench bench;
  bench.run(500ms);
  bench.start_gateway();
  bench.run(1s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_GT(bench.driver_->counters().foreign_notifications, 0U);
  EXPECT_LE(bench.driver_->counters().foreign_notifications, 3U);
  EXPECT_EQ(bench.device_->subscriptions(), 3U) << "the silent one of the symbol version cannot be seen";
}

TEST(WinchPair, WaitsForAPlcThatHasNotCycledYet) {
  SteppedClock clock;
  MemoryNetwork network{clock};
  const auto server = network.server(Bench::kPlc);
  WinchDevice device{{}, *server};
  server->on_event(&device);
  const auto client = network.client(Bench::kPlc, Bench::kGateway);
  int told = 0;
  WinchDriver driver{{}, *client, [&](const topic::WinchState&) { ++told; }};
  client->on_event(&driver);
  for (int ms = 1; ms <= 2000; ++ms) {
    network.run_until(LabTime{ms * 1ms});
    driver.step(clock.now());
    if (ms > 500 && ms % 5 == 0) device.cycle(clock.now(), {2.0, 0.0, 0.0, 40.0});
    if (ms == 500) {
      EXPECT_EQ(told, 0);
      EXPECT_GT(driver.health().rejected(Reason::bad_value), 0U);
      EXPECT_FALSE(driver.halted());
    }
  }
  EXPECT_GT(told, 80);
}

TEST(WinchPair, NamesTheMissingRoute) {
  DeviceConfig device;
  device.routes = {NetId{{1, 2, 3, 4, 5, 6}}};
  Bench bench{{}, device};
  bench.run(500ms);
  EXPECT_TRUE(advises(bench, "no route to NetId 192.168.90.70.1.1")) << bench.driver_->health().advice();
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::down);
}

TEST(WinchPair, NamesTheRefusedConnection) {
  Bench bench;
  bench.network_.set_stream_fault(Bench::kPlc, {.refuse = true});
  bench.run(150ms);
  EXPECT_TRUE(advises(bench, "refuses the TCP connection"));
  bench.network_.set_stream_fault(Bench::kPlc, {});
  bench.run(3s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_TRUE(bench.driver_->health().advice().empty());
}

TEST(WinchPair, NamesTheWrongNetId) {
  DriverConfig driver;
  driver.target.net_id = NetId{{10, 0, 0, 9, 1, 1}};
  Bench bench{driver};
  bench.run(100ms);
  // The answer comes from the address that was asked, so it is ours.
  EXPECT_TRUE(advises(bench, "AMS error 7")) << bench.driver_->health().advice();
  ASSERT_TRUE(bench.driver_->last_error().has_value());
  EXPECT_EQ(bench.driver_->last_error()->code, 7U);
  EXPECT_EQ(bench.driver_->last_error()->level, ErrorLevel::router);
}

TEST(WinchPair, NamesTheMissingPort) {
  DriverConfig driver;
  driver.target.port = 852;
  Bench bench{driver};
  bench.run(100ms);
  EXPECT_TRUE(advises(bench, "AMS error 6")) << bench.driver_->health().advice();
}

TEST(WinchPair, NamesThePlcThatIsNotInRunAndComesBackWhenItIs) {
  Bench bench;
  ASSERT_TRUE(bench.device_->set_fault("stop_plc", true).ok());
  bench.run(200ms);
  EXPECT_TRUE(advises(bench, "PLC is not in run")) << bench.driver_->health().advice();
  ASSERT_TRUE(bench.device_->set_fault("stop_plc", true, 15).ok());
  bench.run(3s);
  EXPECT_TRUE(advises(bench, "not in run mode") || advises(bench, "TwinCAT system"))
      << bench.driver_->health().advice();
  ASSERT_TRUE(bench.device_->set_fault("stop_plc", false).ok());
  bench.run(4s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
}

TEST(WinchPair, HaltsWhenTheLayoutIsNotOurs) {
  DriverConfig driver;
  driver.status_symbol = "GVL_Winch.stCommand";  // 64 bytes where 120 are expected
  Bench bench{driver};
  bench.run(1s);
  EXPECT_TRUE(bench.driver_->halted());
  EXPECT_TRUE(advises(bench, "structs are not ours"));
  EXPECT_EQ(bench.driver_->health().reconnects(), 0U);
  EXPECT_EQ(bench.device_->sessions(), 0U);
}

TEST(WinchPair, SaysWhenTheProjectLacksTheSymbols) {
  DriverConfig driver;
  driver.command_symbol = "MAIN.nothing";
  Bench bench{driver};
  bench.run(100ms);
  EXPECT_TRUE(advises(bench, "lacks GVL_Winch"));
  EXPECT_EQ(bench.driver_->last_error()->code, 0x710U);
}

TEST(WinchPair, TellsNothingWhileTheCycleCounterStandsStill) {
  Bench bench;
  bench.engage();
  ASSERT_TRUE(bench.device_->set_fault("frozen_cycle", true).ok());
  bench.run(20ms);
  const auto told = bench.states_.size();
  bench.run(100ms);
  EXPECT_EQ(bench.states_.size(), told);
  EXPECT_TRUE(advises(bench, "stands still"));
  bench.run(3s);
  EXPECT_EQ(bench.states_.size(), told);
  EXPECT_GT(bench.driver_->counters().status_repeated, 0U);
  ASSERT_TRUE(bench.device_->set_fault("frozen_cycle", false).ok());
  bench.run(4s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
}

TEST(WinchPair, ReconnectsAfterAFrameThatEndsInTheMiddle) {
  Bench bench;
  bench.run(500ms);
  ASSERT_TRUE(bench.device_->set_fault("close_mid_frame", true).ok());
  bench.run(50ms);
  EXPECT_NE(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_TRUE(advises(bench, "broke"));
  bench.run(2s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_EQ(bench.driver_->health().reconnects(), 1U);
}

TEST(WinchPair, DoesNotMindTinyChunks) {
  Bench bench;
  bench.network_.set_stream_fault(Bench::kPlc, {.chunk_bytes = 3});
  bench.run(1s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_EQ(bench.driver_->health().rejected_total(), 0U);
  EXPECT_GT(bench.states_.size(), 80U);
}

TEST(WinchPair, SkipsTicksWhileAReplyIsLateAndNeverQueues) {
  Bench bench;
  bench.engage();
  ASSERT_TRUE(bench.device_->set_fault("delayed", true, 0.035).ok());
  const auto before = bench.driver_->counters();
  bench.run(1s);
  const auto& after = bench.driver_->counters();
  EXPECT_NEAR(static_cast<double>(after.commands_written - before.commands_written), 25, 3);
  EXPECT_NEAR(static_cast<double>(after.commands_skipped - before.commands_skipped), 75, 3);
  EXPECT_EQ(bench.driver_->health().reconnects(), 0U);
}

TEST(WinchPair, GivesUpAfterThreeTimeoutsInARow) {
  Bench bench;
  bench.run(500ms);
  ASSERT_TRUE(bench.device_->set_fault("silent", true).ok());
  bench.run(450ms);
  EXPECT_NE(bench.driver_->health().phase(), LinkPhase::up);
  EXPECT_GE(bench.driver_->counters().timeouts, 3U);
  EXPECT_GE(bench.driver_->health().rejected(Reason::transport), 3U);
  EXPECT_TRUE(advises(bench, "does not answer"));
  ASSERT_TRUE(bench.device_->set_fault("silent", false).ok());
  bench.run(4s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
}

TEST(WinchPair, LivesWithRareOutliers) {
  Bench bench;
  bench.engage();
  ASSERT_TRUE(bench.device_->set_fault("outlier_100ms", true, 100).ok());
  bench.run(5s);
  EXPECT_EQ(bench.driver_->health().reconnects(), 0U);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
}

TEST(WinchPair, DropsTheRouteAndComesBack) {
  Bench bench;
  bench.run(500ms);
  ASSERT_TRUE(bench.device_->set_fault("drop_route", true).ok());
  bench.run(1s);
  EXPECT_TRUE(advises(bench, "no route to NetId"));
  ASSERT_TRUE(bench.device_->set_fault("drop_route", false).ok());
  bench.run(4s);
  EXPECT_EQ(bench.driver_->health().phase(), LinkPhase::up);
}

TEST(WinchPair, ASecondClientFromTheSameAddressDropsTheOlder) {
  Bench bench;
  bench.run(500ms);
  auto second = bench.network_.client(Bench::kPlc, Bench::kGateway);
  struct Quiet : StreamEvents {
    void on_open(LabTime) override {}
    void on_bytes(Bytes, LabTime) override {}
    void on_closed(std::string_view, LabTime) override {}
  } quiet;
  second->on_event(&quiet);
  second->open();
  bench.run(10ms);
  EXPECT_EQ(bench.device_->sessions(), 1U);
  EXPECT_NE(bench.driver_->health().phase(), LinkPhase::up);
  auto third = bench.network_.client(Bench::kPlc, Endpoint{0xC0A85A47, 0});
  third->on_event(&quiet);
  third->open();
  bench.run(10ms);
  EXPECT_EQ(bench.device_->sessions(), 2U) << "another address is another client";
}

TEST(WinchPair, StopsInGoodOrder) {
  Bench bench;
  bench.engage();
  bench.command = Bench::make(Mode::velocity, true, 0.3);
  bench.run(500ms);
  bench.driver_->orderly_stop();
  bench.run(500ms);
  EXPECT_TRUE(bench.driver_->stopped());
  EXPECT_EQ(bench.device_->plc().state(), PlcState::off);
  EXPECT_TRUE(bench.device_->brake_closed());
  EXPECT_EQ(bench.device_->subscriptions(), 0U);
  EXPECT_EQ(bench.device_->sessions(), 0U);
  EXPECT_EQ(bench.last().watchdog_trips, 0U);
  bench.run(2s);
  EXPECT_EQ(bench.device_->sessions(), 0U) << "stopped for good";
}

TEST(WinchPair, GivesBackTheHandlesOfTheConnectionBefore) {
  Bench bench;
  bench.run(500ms);
  for (int i = 0; i < 5; ++i) {
    bench.network_.reset_streams(Bench::kPlc);
    bench.run(3s);
  }
  EXPECT_EQ(bench.driver_->health().reconnects(), 5U);
  EXPECT_EQ(bench.device_->handles(), 2U);
  EXPECT_EQ(bench.device_->subscriptions(), 2U);
}

TEST(WinchPair, TellsTheLevelOfEveryTrouble) {
  struct Trouble {
    const char* fault;
    double value;
    const char* begins;
    const char* says;
  };
  for (const auto& trouble :
       {Trouble{"silent", 0, "AMS/TCP: ", "does not answer"},
        Trouble{"drop_route", 0, "AMS router: ", "no route"},
        Trouble{"router_error", 6, "AMS router: ", "AMS error 6"},
        Trouble{"router_error", 0x502, "AMS router: ", "0x502 (1282), router mailbox full"},
        Trouble{"ads_error", 0x708, "ADS device: ", "0x708 (1800), busy"},
        Trouble{"ads_error", 0x712, "ADS device: ", "not in run"},
        Trouble{"ads_error", 0x704, "ADS device: ", "0x704 (1796), access not permitted"},
        Trouble{"drive_fault", 0xF011, "drive: ", "0xF011"},
        Trouble{"watchdog_trip", 0, "PLC: ", "watchdog"}}) {
    Bench bench;
    bench.engage();
    ASSERT_TRUE(bench.device_->set_fault(trouble.fault, true, trouble.value).ok());
    bench.run(450ms);
    const auto advice = bench.driver_->health().advice();
    EXPECT_EQ(advice.find(trouble.begins), 0U) << trouble.fault << ": " << advice;
    EXPECT_TRUE(advises(bench, trouble.says)) << trouble.fault << ": " << advice;
  }
}

TEST(WinchPair, StopsAtOnceWhenThereIsNoLink) {
  Bench bench;
  bench.driver_->orderly_stop();
  EXPECT_TRUE(bench.driver_->stopped());
}

TEST(WinchPair, IsReproducible) {
  const auto run = [] {
    Bench bench;
    bench.engage();
    bench.command = Bench::make(Mode::velocity, true, 0.2);
    bench.run(300ms);
    bench.network_.reset_streams(Bench::kPlc);
    bench.run(2s);
    return std::pair{bench.states_.size(), bench.last().wire_length_m};
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace motionlab::winch
