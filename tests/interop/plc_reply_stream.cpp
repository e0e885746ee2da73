// What the driver of the PLC's remote reply and the simulated PLC say to each other, for a decoder that is
// not ours.
//
// One line each, numbers as the speaker means them, bytes in hexadecimal:
//   > BYTES                                      a request
//   < BYTES eta eta' eta'' eta v eta eta' eta'' eta v   a reply, and what EM8000, MRU1, EM1500, MRU2 were,
//   six each = BODY x y z w x y z                         a platform as the driver understood it ~ DEVICE x y
//   z roll pitch yaw vx vy vz wx wy wz   a unit as the driver understood it
#include <array>
#include <cstdio>

#include "drivers/core/memory_network.hpp"
#include "drivers/core/random.hpp"
#include "drivers/plc_reply/plc_reply_driver.hpp"
#include "simulators/plc_reply/plc_reply_device.hpp"

namespace {

using namespace motionlab;

void print(const auto& values) {
  for (const double value : values) std::printf(" %.17g", value);
}

void print(char mark, Bytes datagram) {
  std::printf("%c ", mark);
  for (const auto byte : datagram) std::printf("%02x", byte);
}

plc_reply::Six draw(Random& random) {
  plc_reply::Six values{};
  for (double& value : values) value = random.uniform(-1.0, 1.0);
  return values;
}

}  // namespace

int main() {
  constexpr Endpoint kOurs{0x7F000001, 50060}, kTheirs{0x7F000001, 50050};
  SteppedClock clock;
  MemoryNetwork network{clock, {.latency = 100us}};
  const auto our_socket = network.datagram(kOurs), their_socket = network.datagram(kTheirs);
  Random random{8};

  plc_reply::PlcReplyDevice device{{.to = kOurs}, *their_socket};
  plc_reply::DriverConfig config;
  config.plc = kTheirs;
  plc_reply::PlcReplyDriver driver{config, *our_socket,
                                   [](const topic::Bodies& body) {
                                     std::printf("= %s", body.body.str().c_str());
                                     print(body.p_camera_body_m);
                                     print(body.q_camera_body);
                                     std::printf("\n");
                                   },
                                   [](const topic::Mru& unit) {
                                     std::printf("~ %s", unit.device.str().c_str());
                                     print(unit.p_heading_origin_m);
                                     print(unit.euler_heading_mru_rad);
                                     print(unit.v_heading_origin_mps);
                                     print(unit.omega_mru_radps);
                                     std::printf("\n");
                                   }};
  our_socket->on_datagram([&](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
  their_socket->on_datagram([&](Bytes b, Endpoint from, LabTime t) { device.on_datagram(b, from, t); });

  std::array<plc_reply::PlatformFeedback, 2> platforms{};
  std::array<plc_reply::MruFeedback, 2> units{};
  network.on_sent([&](Endpoint, Endpoint to, Bytes datagram, LabTime) {
    print(to == kTheirs ? '>' : '<', datagram);
    if (to == kOurs) {
      for (std::size_t ship = 0; ship < 2; ++ship) {
        print(platforms[ship].eta);
        print(platforms[ship].eta_dot);
        print(platforms[ship].eta_ddot);
        print(units[ship].eta);
        print(units[ship].v);
      }
    }
    std::printf("\n");
  });
  for (int cycle = 0; cycle < 400; ++cycle) {
    for (int ms = 0; ms < 5; ++ms) {
      network.run_until(clock.now() + 1ms);
      driver.step(clock.now());
    }
    for (std::size_t unit = 0; unit < 2; ++unit) {
      units[unit] = {draw(random), draw(random)};
      device.hear(unit, units[unit], clock.now());
    }
    const std::array<plc_reply::PlatformFeedback, 2> next{
        {{draw(random), draw(random), draw(random)}, {draw(random), draw(random), draw(random)}}};
    device.cycle(clock.now(), next);
    platforms = next;
  }
  return 0;
}
