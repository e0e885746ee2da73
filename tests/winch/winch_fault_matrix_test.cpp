// Driver and simulated controller on one wire, over every fault of the controller: what the link's health
// says, what the samples are worth, what the winch does, and how all of it comes back.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>
#include <string>

#include "tests/winch/winch_bench.hpp"

namespace motionlab::winch {
namespace {

using Mode = topic::WinchCommandMode;
using State = topic::WinchDriveState;

enum class Samples { flow, sparse, none };

/// What samples say of the world while the fault lasts.
enum class Quality { good, stuck, wrong, old, error, latched, disabled };

struct Cell {
  std::string fault;
  double value = 0;
  // while it lasts, after 1 s
  LinkPhase phase = LinkPhase::up;
  Samples samples = Samples::flow;
  Quality quality = Quality::good;
  std::string advice{};  ///< part of it; empty: none is given
  PlcState reaction = PlcState::velocity;
  // 6 s after its end, before anybody acts
  PlcState resumes = PlcState::velocity;
  bool halts = false;  ///< for good: people must act
};

void PrintTo(const Cell& cell, std::ostream* out) {
  *out << cell.fault << " " << cell.value;
}

constexpr LinkPhase kUp = LinkPhase::up;
constexpr LinkPhase kAway = LinkPhase::down;  ///< down, or trying

const Cell kCells[] = {
    // The PLC loses power: its brake closes. It boots disabled.
    {"off", 0, kAway, Samples::none, Quality::good, "does not answer", PlcState::off, PlcState::off},
    // Sensors that lie plausibly cannot be seen on the wire.
    {"stuck", 0, kUp, Samples::flow, Quality::stuck, "", PlcState::velocity, PlcState::velocity},
    {"wrong", 0.1, kUp, Samples::flow, Quality::wrong, "", PlcState::velocity, PlcState::velocity},
    {"garbage", 0, kAway, Samples::none, Quality::good, "malformed", PlcState::communication_lost,
     PlcState::communication_lost},
    {"slow", 4, kUp, Samples::sparse, Quality::good, "", PlcState::velocity, PlcState::velocity},
    {"delayed", 0.06, kUp, Samples::flow, Quality::old, "", PlcState::velocity, PlcState::velocity},
    // A silence of 0.2 s swallows the answer to a write: the next heartbeat waits too long for the PLC.
    {"intermittent", 0.2, kAway, Samples::sparse, Quality::latched, "does not answer",
     PlcState::communication_lost, PlcState::communication_lost},
    {"silent", 0, kAway, Samples::none, Quality::good, "does not answer", PlcState::communication_lost,
     PlcState::communication_lost},
    {"drop_route", 0, kAway, Samples::none, Quality::good, "no route", PlcState::communication_lost,
     PlcState::communication_lost},
    {"stop_plc", 0, kAway, Samples::none, Quality::good, "not in run", PlcState::off, PlcState::off},
    {"stop_plc", 15, kAway, Samples::none, Quality::good, "TwinCAT system", PlcState::off, PlcState::off},
    {"online_change", 0, kUp, Samples::flow, Quality::good, "", PlcState::velocity, PlcState::velocity},
    // The commands still arrive, so the PLC goes on until the driver gives the connection up. The next one
    // comes
    // sooner than the watchdog, and disables.
    {"frozen_cycle", 0, kAway, Samples::none, Quality::good, "stands still", PlcState::off, PlcState::off},
    {"drive_fault", 0xF011, kUp, Samples::flow, Quality::error, "drive: ", PlcState::fault, PlcState::fault},
    {"watchdog_trip", 0, kUp, Samples::flow, Quality::latched, "watchdog tripped",
     PlcState::communication_lost, PlcState::communication_lost},
    {"router_error", 6, kAway, Samples::none, Quality::good, "AMS error 6", PlcState::communication_lost,
     PlcState::communication_lost},
    // Writes fail, notifications go on.
    {"ads_error", 0x708, kUp, Samples::flow, Quality::latched, "0x708 (1800), busy",
     PlcState::communication_lost, PlcState::communication_lost},
    {"other_layout", 0, kAway, Samples::none, Quality::good, "structs are not ours",
     PlcState::communication_lost, PlcState::communication_lost, true},
    {"close_mid_frame", 0, kUp, Samples::flow, Quality::disabled, "", PlcState::off, PlcState::off},
    {"outlier_100ms", 100, kUp, Samples::flow, Quality::good, "", PlcState::velocity, PlcState::velocity},
};

class WinchFaultMatrix : public testing::TestWithParam<Cell> {
 protected:
  [[nodiscard]] bool away() const { return bench_.driver_->health().phase() != LinkPhase::up; }
  [[nodiscard]] std::string_view advice() const { return bench_.driver_->health().advice(); }

  Bench bench_;
};

TEST_P(WinchFaultMatrix, HasItsHealthItsQualityItsReactionAndItsRecovery) {
  const Cell& cell = GetParam();
  bench_.engage();
  bench_.command = Bench::make(Mode::velocity, true, 0.05);
  bench_.run(300ms);
  ASSERT_EQ(bench_.device_->plc().state(), PlcState::velocity);
  ASSERT_TRUE(advice().empty()) << advice();

  ASSERT_TRUE(bench_.device_->set_fault(cell.fault, true, cell.value).ok());
  bench_.run(700ms);
  const auto told_before = bench_.states_.size();
  const double length_before = bench_.last().wire_length_m;
  bench_.run(600ms);

  // Health.
  EXPECT_EQ(away(), cell.phase != kUp) << advice();
  if (cell.advice.empty()) {
    EXPECT_EQ(cell.phase, kUp);
  } else {
    EXPECT_NE(advice().find(cell.advice), std::string_view::npos) << advice();
  }
  const auto told = bench_.states_.size() - told_before;
  switch (cell.samples) {
    case Samples::flow:
      EXPECT_NEAR(static_cast<double>(told), 60, 13);
      break;
    case Samples::sparse:
      EXPECT_GT(told, 5U);
      EXPECT_LT(told, 45U);
      break;
    case Samples::none:
      EXPECT_EQ(told, 0U);
      break;
  }

  // Quality.
  const auto& state = bench_.last();
  const double true_length = bench_.device_->set_point_m();
  switch (cell.quality) {
    case Quality::good:
      break;
    case Quality::stuck:
      EXPECT_EQ(state.wire_length_m, length_before);
      EXPECT_GT(std::abs(true_length - state.wire_length_m), 0.01);
      break;
    case Quality::wrong:
      EXPECT_NEAR(state.wire_length_m - true_length, cell.value, 0.005);
      break;
    case Quality::old:
      EXPECT_GT(state.t_received_ns - state.t_measured_ns, 50'000'000);
      EXPECT_TRUE(std::any_of(bench_.states_.begin() + static_cast<std::ptrdiff_t>(told_before),
                              bench_.states_.end(), [](const auto& s) { return !s.command_path_alive; }));
      break;
    case Quality::error:
      EXPECT_TRUE(state.error);
      EXPECT_EQ(state.drive_diagnosis, cell.value);
      break;
    case Quality::latched:
      EXPECT_EQ(state.drive_state, State::communication_lost);
      EXPECT_GE(state.watchdog_trips, 1U);
      break;
    case Quality::disabled:
      EXPECT_FALSE(state.enabled);
      EXPECT_EQ(state.watchdog_trips, 0U);
      break;
  }

  // Reaction: it goes on as told, or is at rest.
  EXPECT_EQ(bench_.device_->plc().state(), cell.reaction);
  if (cell.reaction != PlcState::velocity) {
    const double at = bench_.device_->set_point_m();
    bench_.run(100ms);
    EXPECT_EQ(bench_.device_->set_point_m(), at) << "at rest";
  }

  // Recovery: the link by itself, motion never.
  ASSERT_TRUE(bench_.device_->set_fault(cell.fault, false).ok());
  bench_.run(6s);
  EXPECT_EQ(bench_.driver_->halted(), cell.halts);
  EXPECT_EQ(bench_.device_->plc().state(), cell.resumes);
  if (cell.halts) return;
  EXPECT_EQ(bench_.driver_->health().phase(), LinkPhase::up);
  EXPECT_NEAR(bench_.driver_->health().rate_hz(bench_.now()), 100, 5);
  EXPECT_NEAR(bench_.last().wire_length_m, bench_.device_->set_point_m(), 0.005);
  bench_.command = Bench::make(Mode::hold, false);
  bench_.run(300ms);
  bench_.command->reset = true;
  bench_.run(300ms);
  bench_.command = Bench::make(Mode::hold, true);
  bench_.run(400ms);
  EXPECT_EQ(bench_.last().drive_state, State::hold);
  EXPECT_TRUE(bench_.last().command_path_alive);
  EXPECT_TRUE(advice().empty()) << advice();
}

std::string name_of(const testing::TestParamInfo<Cell>& info) {
  return info.param.fault + (info.param.value == 15 ? "_config" : "");
}

INSTANTIATE_TEST_SUITE_P(OverEveryFault, WinchFaultMatrix, testing::ValuesIn(kCells), name_of);

TEST(WinchFaultMatrixTable, HasARowForEveryFaultOfTheController) {
  std::set<std::string> rows;
  for (const auto& cell : kCells) rows.insert(cell.fault);
  std::istringstream names{std::string{WinchDevice::fault_names()}};
  for (std::string name; names >> name;) EXPECT_EQ(rows.erase(name), 1U) << name;
  EXPECT_TRUE(rows.empty());
}

}  // namespace
}  // namespace motionlab::winch
