// A network that loses, doubles, reorders and delays.
#include <gtest/gtest.h>

#include <string>

#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

struct Weather {
  std::string name;
  DatagramFault fault;
};
void PrintTo(const Weather& weather, std::ostream* out) {
  *out << weather.name;
}

class BadNetwork : public testing::TestWithParam<Weather> {};

TEST_P(BadNetwork, KeepsTheLoadStill) {
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  const auto& gateway = config.gateway;
  line.network().set_datagram_fault(gateway.mrus.front().listen, GetParam().fault);
  line.network().set_datagram_fault(gateway.comau.listen, GetParam().fault);
  line.network().set_datagram_fault(gateway.comau.driver.robot_computer, GetParam().fault);
  line.engage_and_run_to(20);
  line.take_motion();
  line.run_to(50);
  EXPECT_EQ(line.mode().state, topic::ModeState::engaged) << line.mode().reason.view();
  const auto motion = line.take_motion();
  RecordProperty("swing_rms_deg", std::to_string(motion.swing_rms_deg));
  EXPECT_LE(motion.swing_rms_deg, 0.3);
  EXPECT_EQ(steps_beyond_limits(line.steps(), gateway.limits, gateway.control_period_s), 0U);
  const auto& fault = GetParam().fault;
  for (const char* const device : {"mru1", "arm"}) {
    if (fault.loss > 0) {
      EXPECT_GT(line.health(device).lost, 0U) << device;
    }
    if (fault.duplicate > 0) {
      EXPECT_GT(line.rejected(device, Reason::duplicate), 0U) << device;
    }
    if (fault.reorder > 0) {
      EXPECT_GT(line.rejected(device, Reason::out_of_order), 0U) << device;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfDatagrams, BadNetwork,
    testing::Values(
        Weather{"Loss", {.loss = 0.05}}, Weather{"Duplicates", {.duplicate = 0.2}},
        Weather{"Reordering", {.reorder = 0.05, .reorder_by = 7ms}}, Weather{"Jitter", {.jitter = 3ms}},
        Weather{"Everything",
                {.loss = 0.05, .duplicate = 0.05, .reorder = 0.02, .reorder_by = 7ms, .jitter = 3ms}}),
    testing::PrintToStringParamName());

TEST(BadNetworkOfStreams, BytesOneByOneChangeNothing) {
  const lockstep::Config config = configure("thesis-wave");
  Line line(config);
  line.network().set_stream_fault(config.gateway.winch.plc, {.chunk_bytes = 1});
  line.network().set_stream_fault(config.gateway.qualisys.server, {.chunk_bytes = 1});
  line.engage_and_run_to(20);
  line.take_motion();
  line.run_to(30);
  EXPECT_EQ(line.mode().state, topic::ModeState::engaged) << line.mode().reason.view();
  EXPECT_LE(line.take_motion().swing_rms_deg, 0.12);
}

}  // namespace
}  // namespace motionlab::integration
