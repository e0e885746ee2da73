// Every fault of the robot computer against the driver: health, quality, reaction, recovery.
#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "tests/comau/comau_bench.hpp"

namespace motionlab::comau {
namespace {

enum class Reaction {
  follows,  ///< goes on as if nothing were
  dips,     ///< brakes while it does not know where the arm is, and goes on
  brakes,   ///< comes to rest, and goes on by itself when the fault is over
  holds     ///< comes to rest, and stays there until somebody says hold
};

struct Cell {
  std::string fault;
  Reaction reaction = Reaction::follows;
  LinkPhase phase = LinkPhase::up;  ///< when the fault has lasted
  std::optional<Reason> counted{};  ///< what the answers are refused for
  double told_share = 1.0;          ///< of the measurements of healthy times that are still told
  std::string_view advice{};        ///< a part of it when the fault has lasted
  bool faithful_alone = false;
  bool counts_losses = false;
};

void PrintTo(const Cell& cell, std::ostream* out) {
  *out << cell.fault;
}

const std::vector<Cell> kMatrix{
    {"off", Reaction::brakes, LinkPhase::down, {}, 0.0, "fallen silent"},
    {"stuck", Reaction::holds, LinkPhase::up, {}, 1.0, "told to move"},
    {"garbage", Reaction::brakes, LinkPhase::down, Reason::unexpected, 0.0, "all are refused"},
    // The jump is seen and refused; an offset that stays is then a posture like any other.
    {"wrong", Reaction::dips, LinkPhase::up, Reason::bad_value, 0.95, ""},
    {"slow", Reaction::follows, LinkPhase::up, {}, 0.25, "", false, true},
    {"delayed", Reaction::brakes, LinkPhase::up, {}, 0.97, "fresh enough"},
    {"intermittent", Reaction::dips, LinkPhase::up, {}, 0.5, {}, false, true},
    {"silent", Reaction::brakes, LinkPhase::down, {}, 0.0, "fallen silent"},
    {"freeze_counter", Reaction::brakes, LinkPhase::down, Reason::duplicate, 0.0, "stands still"},
    {"wrong_size", Reaction::brakes, LinkPhase::down, Reason::too_short, 0.0, "all are refused"},
    {"nan_answer", Reaction::brakes, LinkPhase::down, Reason::bad_value, 0.0, "all are refused"},
    {"powerlink_drop", Reaction::brakes, LinkPhase::down, Reason::duplicate, 0.0, "Power Link"},
    {"drive_off", Reaction::holds, LinkPhase::up, {}, 1.0, "drives on"},
    {"drive_fault", Reaction::holds, LinkPhase::up, {}, 1.0, "drives on"},
    {"hold", Reaction::holds, LinkPhase::up, {}, 1.0, "program started"},
    {"local", Reaction::holds, LinkPhase::up, {}, 1.0, "Remote mode"},
    {"override", Reaction::follows, LinkPhase::up, {}, 1.0, "override"},
    // Each command is whole in the cycle after, and this one says the same as the one before.
    {"torn", Reaction::follows, LinkPhase::up, {}, 1.0, "", true},
};

constexpr double kWanted_radps = 0.1;

class ArmFault : public ::testing::TestWithParam<std::tuple<Cell, bool>> {
 protected:
  ArmFault() : pair(std::get<1>(GetParam())) {
    pair.q[0] = -0.5;
    pair.run(300ms);
    pair.wanted = Joints{kWanted_radps, 0, 0, 0, 0, 0};
    pair.run(1500ms);
  }

  [[nodiscard]] double speed_sent() const { return pair.sent.back().qd_wanted_radps[0]; }
  [[nodiscard]] bool advice_has(std::string_view text) const {
    return pair.driver.health().advice().find(text) != std::string_view::npos;
  }
  void expect_well() {
    EXPECT_EQ(pair.driver.health().phase(), LinkPhase::up);
    EXPECT_TRUE(pair.driver.feedback_fresh(pair.clock.now()));
    EXPECT_TRUE(pair.driver.health().advice().empty()) << pair.driver.health().advice();
    EXPECT_TRUE(pair.device.following());
    EXPECT_NEAR(speed_sent(), kWanted_radps, 1e-7);
    EXPECT_NEAR(pair.qd[0], kWanted_radps, 0.01);
    EXPECT_NEAR(pair.states.back().q_rad[0], pair.q[0], 1e-3);
  }

  ComauPair pair;
};

TEST_P(ArmFault, IsSeenAnsweredAndOutlived) {
  const auto& [cell, hardened] = GetParam();
  if (cell.faithful_alone && hardened) {
    EXPECT_FALSE(pair.device.set_fault(cell.fault, true).ok());
    return;
  }
  expect_well();

  // The fault, for a second and a half.
  ASSERT_TRUE(pair.device.set_fault(cell.fault, true).ok());
  const LinkHealth before = pair.driver.health();
  const auto first_state = pair.states.size();
  const auto first_sent = pair.sent.size();
  pair.run(1500ms);
  const LinkHealth& health = pair.driver.health();

  EXPECT_EQ(health.phase(), cell.phase);
  if (cell.counted) {
    EXPECT_GE(health.rejected(*cell.counted), before.rejected(*cell.counted) + 5);
  } else {
    EXPECT_EQ(health.rejected_total(), before.rejected_total()) << to_string(health.last_fault()->reason);
  }
  EXPECT_EQ(health.lost() > before.lost() + 50, cell.counts_losses);
  const double told = static_cast<double>(pair.states.size() - first_state) / 300.0;
  EXPECT_NEAR(told, cell.told_share, 0.04);
  if (cell.advice.data() != nullptr) {
    EXPECT_EQ(advice_has(cell.advice), true) << health.advice();
    EXPECT_EQ(cell.advice.empty(), health.advice().empty()) << health.advice();
  }
  double slowest = kWanted_radps;
  for (auto k = first_sent; k < pair.sent.size(); ++k) {
    slowest = std::min(slowest, pair.sent[k].qd_wanted_radps[0]);
  }
  const bool rests = cell.reaction == Reaction::brakes || cell.reaction == Reaction::holds;
  EXPECT_EQ(slowest < 0.99 * kWanted_radps, cell.reaction != Reaction::follows);
  EXPECT_EQ(!pair.sent.back().follow, rests);
  // At 1 rad/s² a tenth of a second is needed; until then the arm is told less and less, never more.
  if (rests) {
    const auto rest =
        std::find_if(pair.sent.begin() + static_cast<std::ptrdiff_t>(first_sent), pair.sent.end(),
                     [](const topic::ArmCommand& c) { return c.qd_wanted_radps[0] == 0; });
    const auto periods = rest - (pair.sent.begin() + static_cast<std::ptrdiff_t>(first_sent));
    EXPECT_LE(static_cast<double>(periods) * 0.005, cell.reaction == Reaction::holds ? 0.5 : 0.16);
  }

  // It ends.
  ASSERT_TRUE(pair.device.set_fault(cell.fault, false).ok());
  pair.run(2s);
  if (cell.reaction == Reaction::holds) {
    EXPECT_FALSE(pair.sent.back().follow) << "what starts the arm's program again must not move it";
    EXPECT_TRUE(advice_has("until settled"));
    pair.wanted.reset();
    pair.want({}, false);
    pair.run(50ms);
    pair.wanted = Joints{kWanted_radps, 0, 0, 0, 0, 0};
    pair.run(2s);
  }
  expect_well();

  // And whatever it was, nothing left that the arm may not be told.
  const DriverConfig limits = ComauPair::driver_config();
  for (std::size_t k = 1; k < pair.sent.size(); ++k) {
    const double v0 = pair.sent[k - 1].qd_wanted_radps[0];
    const double v1 = pair.sent[k].qd_wanted_radps[0];
    ASSERT_LE(std::abs(v1 - v0), limits.qdd_max_radps2[0] * limits.command_period_s + 1e-9);
    ASSERT_TRUE(pair.sent[k].follow || v0 == 0.0) << "mode 0 only from rest";
  }
}

INSTANTIATE_TEST_SUITE_P(OfTheRobotComputer, ArmFault,
                         ::testing::Combine(::testing::ValuesIn(kMatrix), ::testing::Bool()),
                         [](const auto& test) {
                           return std::get<0>(test.param).fault +
                                  (std::get<1>(test.param) ? "Hardened" : "Faithful");
                         });

TEST(ArmFaultMatrix, HasACellForEveryFault) {
  std::istringstream names{std::string{ComauDevice::fault_names()}};
  std::size_t known = 0;
  for (std::string name; names >> name; ++known) {
    EXPECT_TRUE(std::ranges::any_of(kMatrix, [&](const Cell& cell) { return cell.fault == name; })) << name;
  }
  EXPECT_EQ(known, kMatrix.size());
}

}  // namespace
}  // namespace motionlab::comau
