// Driver and simulated PLC joined in memory over every fault of the PLC and of the wire: what is asked all
// the while, what the driver says of it, and that all is well again afterwards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

#include "simulators/faults/wire_faults.hpp"
#include "tests/plc_reply/plc_reply_pair.hpp"

namespace motionlab::plc_reply {
namespace {

using testing::HasSubstr;

std::vector<std::string> words(std::string_view names) {
  std::istringstream in{std::string(names)};
  return {std::istream_iterator<std::string>(in), {}};
}

std::vector<std::string> every_fault() {
  auto all = words(PlcReplyDevice::fault_names());
  std::ranges::copy(words(faults::WireFaults::kNames), std::back_inserter(all));
  return all;
}

TEST(PlcReplyFaultMatrix, WhateverHappensNothingButZerosIsAskedAndNobodyHasControl) {
  for (const std::string& fault : every_fault()) {
    PlcPair pair;
    pair.run(300ms);
    ASSERT_TRUE(pair.fault(fault, true)) << fault;
    for (int i = 0; i < 50; ++i) {
      pair.run(10ms);
      EXPECT_FALSE(pair.device.controlled(pair.clock.now())) << fault;
    }
    ASSERT_TRUE(pair.fault(fault, false)) << fault;
    pair.run(700ms);
    EXPECT_GT(pair.asked.size(), 290U) << fault << ": it goes on asking";
    for (const ByteBuffer& request : pair.asked) ASSERT_EQ(request, ByteBuffer(136, 0)) << fault;
  }
}

TEST(PlcReplyFaultMatrix, EveryFaultEndsWell) {
  for (const std::string& fault : every_fault()) {
    PlcPair pair;
    pair.run(1s);
    ASSERT_TRUE(pair.fault(fault, true)) << fault;
    pair.run(1s);
    for (const topic::Bodies& body : pair.bodies) {
      for (const double p : body.p_camera_body_m) ASSERT_LE(std::abs(p), 10.0) << fault;
      ASSERT_LE(body.t_measured_ns, body.t_received_ns) << fault;
    }
    ASSERT_TRUE(pair.fault(fault, false)) << fault;
    pair.run(200ms);
    pair.bodies.clear();
    pair.units.clear();
    const auto rejected = pair.driver.health().rejected_total();
    pair.run(1s);
    EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up) << fault;
    EXPECT_TRUE(pair.driver.health().advice().empty()) << fault << ": " << pair.driver.health().advice();
    EXPECT_EQ(pair.driver.health().rejected_total(), rejected) << fault;
    EXPECT_NEAR(static_cast<double>(pair.bodies.size()), 400.0, 2.0) << fault;
    EXPECT_NEAR(static_cast<double>(pair.units.size()), 400.0, 2.0) << fault;
  }
}

/// What one second with a fault has to show.
struct Cell {
  std::string fault;
  double value = 0.0;
  double bodies = 400;  ///< samples, give or take a tenth
  double units = 400;
  LinkPhase phase = LinkPhase::up;
  std::optional<Reason> reason{};  ///< counted at least ten times
  std::string advice{};            ///< is in what the driver advises; empty: it advises nothing
};
void PrintTo(const Cell& cell, std::ostream* out) {
  *out << cell.fault;
}

class PlcReplyFaultCell : public testing::TestWithParam<Cell> {};

TEST_P(PlcReplyFaultCell, AreSeenForWhatTheyAre) {
  const Cell& cell = GetParam();
  PlcPair pair;
  pair.run(1s);
  ASSERT_TRUE(pair.fault(cell.fault, true, cell.value));
  pair.run(10ms);  // what is under way arrives
  pair.bodies.clear();
  pair.units.clear();
  pair.run(1s);
  const LinkHealth& health = pair.driver.health();
  EXPECT_NEAR(static_cast<double>(pair.bodies.size()), cell.bodies, 0.1 * cell.bodies + 1);
  EXPECT_NEAR(static_cast<double>(pair.units.size()), cell.units, 0.1 * cell.units + 1);
  EXPECT_EQ(health.phase(), cell.phase);
  EXPECT_THAT(std::string(health.advice()), HasSubstr(cell.advice));
  EXPECT_EQ(health.advice().empty(), cell.advice.empty()) << health.advice();
  if (cell.reason) {
    EXPECT_GE(health.rejected(*cell.reason), 10U);
    EXPECT_EQ(health.rejected(*cell.reason), health.rejected_total());
  } else {
    EXPECT_EQ(health.rejected_total(), 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, PlcReplyFaultCell,
    testing::Values(
        Cell{.fault = "off", .bodies = 0, .units = 0, .phase = LinkPhase::down, .advice = "fallen silent"},
        Cell{.fault = "silent", .bodies = 0, .units = 0, .phase = LinkPhase::down, .advice = "fallen silent"},
        Cell{.fault = "cut", .bodies = 0, .units = 0, .phase = LinkPhase::down, .advice = "fallen silent"},
        Cell{.fault = "garbage",
             .bodies = 0,
             .units = 0,
             .phase = LinkPhase::down,
             .reason = Reason::bad_value,
             .advice = "No good reply"},
        Cell{.fault = "nan",
             .bodies = 0,
             .units = 0,
             .phase = LinkPhase::down,
             .reason = Reason::bad_value,
             .advice = "No good reply"},
        Cell{.fault = "wrong_size",
             .value = 4,
             .bodies = 0,
             .units = 0,
             .phase = LinkPhase::down,
             .reason = Reason::too_long,
             .advice = "No good reply"},
        Cell{.fault = "wrong_size",
             .value = -4,
             .bodies = 0,
             .units = 0,
             .phase = LinkPhase::down,
             .reason = Reason::too_short,
             .advice = "No good reply"},
        Cell{.fault = "stuck", .units = 0, .advice = "mru1"},
        Cell{.fault = "wrong"},  // only another source could know
        Cell{.fault = "slow", .value = 4, .bodies = 100, .units = 100},
        Cell{.fault = "delayed", .value = 0.05, .bodies = 380, .units = 380},
        Cell{.fault = "loss", .value = 0.2, .bodies = 256, .units = 256},  // of both ways
        Cell{.fault = "duplicate", .value = 0.5},
        Cell{.fault = "reorder", .value = 0.2, .bodies = 280, .units = 280, .reason = Reason::out_of_order},
        Cell{.fault = "truncate", .value = 0.2, .bodies = 256, .units = 256, .reason = Reason::too_short},
        Cell{.fault = "foreign", .value = 0.3, .reason = Reason::foreign}),
    [](const auto& test) {
      std::string name = test.param.fault + "_" + std::to_string(test.index);
      std::ranges::replace(name, '-', '_');
      return name;
    });

}  // namespace
}  // namespace motionlab::plc_reply
