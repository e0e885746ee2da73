/// @file  Driver and simulated PLC joined in memory on stepped time, with a wire between them that can fail.
#pragma once

#include <array>
#include <cmath>
#include <memory>
#include <string_view>
#include <vector>

#include "drivers/core/memory_network.hpp"
#include "drivers/plc_reply/plc_reply_driver.hpp"
#include "simulators/faults/faulty_wire.hpp"
#include "simulators/plc_reply/plc_reply_device.hpp"

namespace motionlab::plc_reply {

inline constexpr Endpoint kGateway{0x7F000001, 50060};
inline constexpr Endpoint kPlc{0x7F000001, 50050};

/// The PLC cycles every 5 ms and hears a unit half a cycle before; everybody steps every 0.5 ms.
class PlcPair {
 public:
  PlcPair()
      : network(clock, {.latency = 100us}),
        wire(network, 1, "plc", [this](Nanoseconds jump) { device.set_clock_jump(jump); }),
        our_socket(network.datagram(kGateway)),
        their_socket(wire.datagram(kPlc)),
        driver(
            driver_config(), *our_socket, [this](const topic::Bodies& b) { bodies.push_back(b); },
            [this](const topic::Mru& m) { units.push_back(m); }),
        device({.to = kGateway}, *their_socket) {
    our_socket->on_datagram([this](Bytes b, Endpoint from, LabTime t) { driver.on_datagram(b, from, t); });
    their_socket->on_datagram([this](Bytes b, Endpoint from, LabTime t) { device.on_datagram(b, from, t); });
    network.on_sent([this](Endpoint, Endpoint to, Bytes datagram, LabTime) {
      if (to == kPlc) asked.emplace_back(datagram.begin(), datagram.end());
    });
  }
  ~PlcPair() {
    our_socket->on_datagram({});
    their_socket->on_datagram({});
  }
  PlcPair(const PlcPair&) = delete;
  PlcPair& operator=(const PlcPair&) = delete;

  static DriverConfig driver_config() {
    DriverConfig config;
    config.plc = kPlc;
    return config;
  }

  static PlatformFeedback platform_at(std::size_t ship, LabTime t) {
    const double s = seconds(t.time_since_epoch()) + static_cast<double>(ship);
    return {{0.1 * std::sin(s), 0.2 * std::cos(s), 0.3 * std::sin(2 * s), 0.05 * std::sin(s),
             0.04 * std::cos(s), 0.03},
            {},
            {}};
  }
  static MruFeedback unit_at(std::size_t ship, LabTime t) {
    const double s = seconds(t.time_since_epoch()) + 2.0 * static_cast<double>(ship);
    return {{0.01 * std::sin(s), 0.02, 0.03, 0.04 * std::cos(s), 0.05, 0.06},
            {0.1 * std::sin(s), 0.2, 0.3, 0.4 * std::cos(s), 0.5, 0.6}};
  }

  void run(Nanoseconds duration) {
    for (const LabTime end = clock.now() + duration; clock.now() < end;) {
      network.run_until(clock.now() + 500us);
      const LabTime now = clock.now();
      driver.step(now);
      if ((now.time_since_epoch() % 5ms).count() == 0) {
        for (std::size_t unit = 0; unit < 2; ++unit) {
          if (heard[unit]) device.hear(unit, unit_at(unit, now), now + 2500us);
        }
        device.cycle(now, {platform_at(0, now), platform_at(1, now)});
      }
      wire.step(now);
      device.step(now);
    }
  }

  /// What the wire does not know, the device may.
  Status fault(std::string_view name, bool active, double value = 0.0) {
    if (const Status done = wire.set_fault(name, active, value); done) return done;
    return device.set_fault(name, active, value);
  }

  SteppedClock clock;
  MemoryNetwork network;
  faults::FaultyWire wire;
  std::unique_ptr<DatagramSocket> our_socket, their_socket;
  std::vector<topic::Bodies> bodies;
  std::vector<topic::Mru> units;
  std::vector<ByteBuffer> asked;  ///< every datagram that ever left for the PLC
  std::array<bool, 2> heard{true, true};
  PlcReplyDriver driver;
  PlcReplyDevice device;
};

}  // namespace motionlab::plc_reply
