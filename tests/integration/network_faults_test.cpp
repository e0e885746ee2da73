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

/// Which ways the weather lies on: answers and measurements, commands, or both.
enum class Way { in, out, both };

class BadNetwork : public testing::TestWithParam<std::tuple<Weather, Way>> {};

TEST_P(BadNetwork, KeepsTheLoadStill) {
  const auto& [weather, way] = GetParam();
  const DatagramFault& fault = weather.fault;
  const lockstep::Config config = configure("thesis-wave");
  const auto& gateway = config.gateway;
  Line line(config);
  if (way != Way::out) {
    line.network().set_datagram_fault(gateway.mrus.front().listen, fault);
    line.network().set_datagram_fault(gateway.comau.listen, fault);
  }
  if (way != Way::in) line.network().set_datagram_fault(gateway.comau.driver.robot_computer, fault);
  line.engage_and_run_to(20);
  line.take_motion();
  line.run_to(50);
  EXPECT_EQ(line.mode().state, topic::ModeState::engaged) << line.mode().reason.view();
  const auto motion = line.take_motion();
  RecordProperty("swing_rms_deg", std::to_string(motion.swing_rms_deg));
  EXPECT_LE(motion.swing_rms_deg, 0.3);
  EXPECT_EQ(steps_beyond_limits(line.steps(), gateway.limits, gateway.control_period_s), 0U);
  if (way == Way::out) return;
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

const DatagramFault kEverything{
    .loss = 0.05, .duplicate = 0.05, .reorder = 0.02, .reorder_by = 7ms, .jitter = 3ms};

std::string name_of(const testing::TestParamInfo<BadNetwork::ParamType>& test) {
  constexpr std::string_view kWays[] = {"In", "Out", "BothWays"};
  return std::get<0>(test.param).name + std::string(kWays[static_cast<std::size_t>(std::get<1>(test.param))]);
}

INSTANTIATE_TEST_SUITE_P(OfOneKind, BadNetwork,
                         testing::Combine(testing::Values(Weather{"Loss", {.loss = 0.05}},
                                                          Weather{"Duplicates", {.duplicate = 0.2}},
                                                          Weather{"Reordering",
                                                                  {.reorder = 0.05, .reorder_by = 7ms}},
                                                          Weather{"Jitter", {.jitter = 3ms}}),
                                          testing::Values(Way::both)),
                         name_of);

// Both ways at once more than 25 ms without an answer are to be expected once in some ten seconds: each way
// alone.
INSTANTIATE_TEST_SUITE_P(OfAllKinds, BadNetwork,
                         testing::Combine(testing::Values(Weather{"Everything", kEverything}),
                                          testing::Values(Way::in, Way::out)),
                         name_of);

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
