// The PLC's remote reply on the whole line: what it says of the platforms is true, and nothing moves by it.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <utility>

#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

constexpr Endpoint kPlc{0x7F000001, 50050};

/// Two ships in a sea; the PLC is there in any case.
lockstep::Config sea(bool asked) {
  lockstep::Config config = configure("sea", 2);
  const std::string enabled = asked ? "[plc_reply]\nenabled = true\n" : "";
  config.gateway = service::load_gateway_config(config_file("lab.toml"), {config_file("loopback.toml")},
                                                {{"this test", enabled}});
  config.lab.plc_reply_enabled = true;
  config.lab.set_second_ship("sea");
  return config;
}

TEST(PlcReply, PutsThePlatformsWhereTheyTrulyWere) {
  Line line(sea(true));
  auto bodies = line.lockstep().bus().subscribe<topic::Bodies>();
  const auto& calibration = line.lockstep().lab().world().calibration();
  std::deque<plant::WorldState> past;
  double worst_m = 0, worst_turn = 0;
  std::array<int, 2> compared{};
  while (line.now_s() < 12) {
    line.step();
    past.push_back(line.lockstep().lab().state());
    if (past.size() > 20) past.pop_front();
    while (const auto body = bodies.next()) {
      if (body->device.view() != "plc") continue;
      ASSERT_TRUE(body->tracked);
      const auto then = std::ranges::find(past, from_ns(body->t_measured_ns), &plant::WorldState::t);
      if (then == past.end()) continue;  // before the first step
      const bool second = body->body.view() == "em1500";
      ++compared[second ? 1 : 0];
      const auto& p = body->p_camera_body_m;
      const auto& q = body->q_camera_body;
      const math::RigidTransform X_NB =
          math::RigidTransform::from_quaternion({q[0], q[1], q[2], q[3]}, {p[0], p[1], p[2]});
      const math::RigidTransform X_WB =
          (second ? calibration.world_to_em1500 : calibration.world_to_em8000) * X_NB;
      const math::RigidTransform& truth = (second ? then->second : then->platform).X_WB;
      worst_m = std::max(worst_m, (X_WB.p - truth.p).norm());
      worst_turn = std::max(worst_turn, (X_WB.R - truth.R).norm());
    }
  }
  EXPECT_GT(compared[0], 2300);
  EXPECT_GT(compared[1], 2300);
  EXPECT_LT(worst_m, 1e-6) << "single precision";
  EXPECT_LT(worst_turn, 1e-6);
  EXPECT_GT((past.back().platform.X_WB.p - calibration.world_to_em8000.p).norm(), 0.01) << "it moves";
}

TEST(PlcReply, SaysOfTheUnitsWhatTheySayThemselves) {
  Line line(sea(true));
  auto mrus = line.lockstep().bus().subscribe<topic::Mru>();
  std::array<std::deque<topic::Mru>, 2> said;
  std::array<int, 2> compared{};
  while (line.now_s() < 5) {
    line.step();
    while (const auto mru = mrus.next()) {
      const std::string_view device = mru->device.view();
      auto& past = said[device.ends_with("2") ? 1 : 0];
      if (!device.starts_with("plc_")) {
        past.push_back(*mru);
        continue;
      }
      EXPECT_FALSE(mru->stable);
      const auto same = std::ranges::find_if(past, [&](const topic::Mru& one) {
        return one.euler_heading_mru_rad == mru->euler_heading_mru_rad &&
               one.omega_mru_radps == mru->omega_mru_radps &&
               one.p_heading_origin_m == mru->p_heading_origin_m &&
               one.v_heading_origin_mps == mru->v_heading_origin_mps;
      });
      ASSERT_NE(same, past.end());
      ++compared[device.ends_with("2") ? 1 : 0];
      past.erase(past.begin(), same);
    }
  }
  EXPECT_GT(compared[0], 950);
  EXPECT_GT(compared[1], 950);
}

TEST(PlcReply, ChangesNoBitOfWhatIsCommandedAndAsksWithZerosAlone) {
  const auto run = [](bool asked) {
    Line line(sea(asked));
    Hash sent;
    std::size_t requests = 0;
    line.network().on_sent([&](Endpoint, Endpoint to, Bytes datagram, LabTime t) {
      if (to == kPlc) {
        ++requests;
        EXPECT_EQ(datagram.size(), 136U);
        EXPECT_TRUE(std::ranges::all_of(datagram, [](auto byte) { return byte == 0; }));
      } else if (to == line.config().gateway.comau.driver.robot_computer) {
        const std::int64_t t_ns = to_ns(t);
        sent.bytes(&t_ns, sizeof t_ns);
        sent.bytes(datagram.data(), datagram.size());
      }
    });
    line.engage_and_run_to(15);
    EXPECT_EQ(line.mode().state, ModeState::engaged);
    line.ask(ModeAction::settle);
    line.run_to(16);
    EXPECT_NEAR(static_cast<double>(requests), asked ? 3200.0 : 0.0, 2.0);
    return std::pair{line.commands_hash(), sent.value()};
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(PlcReply, IsMissedByNobodyWhenItFallsSilent) {
  Line line(sea(true));
  line.engage_and_run_to(12);
  EXPECT_EQ(line.health("plc").link, topic::LinkState::up);
  EXPECT_FALSE(line.health("plc").required);
  EXPECT_NEAR(line.health("plc").rate_hz, 200, 1);
  line.fault("plc", "off", true);
  line.run_for(1);
  EXPECT_EQ(line.health("plc").link, topic::LinkState::down);
  EXPECT_FALSE(line.health("plc").advice.empty());
  EXPECT_EQ(line.mode().state, ModeState::engaged);
  EXPECT_TRUE(line.mode().fault_code.empty());
  line.fault("plc", "ok", true);
  line.run_for(1);
  EXPECT_EQ(line.health("plc").link, topic::LinkState::up);
  EXPECT_EQ(line.mode().state, ModeState::engaged);
}

TEST(PlcReply, ThatIsNotServedHasNoFaults) {
  lockstep::Config config = configure("calm");
  lockstep::Lockstep line(config);
  EXPECT_FALSE(line.lab().set_fault("plc", "off", true));
  EXPECT_TRUE(line.lab().fault_names("plc").empty());
}

}  // namespace
}  // namespace motionlab::integration
