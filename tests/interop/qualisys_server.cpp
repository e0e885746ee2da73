// The simulated camera server alone on real sockets, for other people's clients.
//
//   interop_qualisys_server [seconds]    serves on free ports of 127.0.0.1, prints them, ends by itself
//
// It shows the same scene for ever; the number of the frame moves the load along x by a millimetre each,
// modulo 1000.
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdlib>
#include <functional>
#include <iostream>

#include "drivers/core/asio_network.hpp"
#include "drivers/core/real_clock.hpp"
#include "simulators/qualisys/qualisys_device.hpp"

namespace {

using namespace motionlab;

/// Roll 10, pitch 20, yaw 30 deg about the body's own axes: a known tilt, worked out by hand from half
/// angles.
constexpr std::array<double, 4> kTilted{0.943714364147489, 0.127679440695781, 0.144878125417369,
                                        0.268535822751569};

qualisys::CameraFrame scene(std::uint64_t number) {
  qualisys::CameraFrame frame;
  frame.bodies = {
      {"load", true, {1.0 + 0.001 * static_cast<double>(number % 1000), -0.25025, 1.5}, kTilted, 0.00025},
      {"platform", true, {-1.0, 2.5, 0.5}, {1.0, 0.0, 0.0, 0.0}, 0.0005}};
  frame.markers = {{"corner", true, {0.1, 0.2, 0.3}, 0.0004}};
  frame.unlabelled = {{{4.0, 5.0, 6.0}, 7, 0.001}, {{4.0, 5.062, 6.0}, 4'000'000'000U, 0.002}};
  frame.drop_rate = 0.002;
  frame.out_of_sync_rate = 0.001;
  return frame;
}

}  // namespace

int main(int argc, char** argv) {
  const double limit_s = argc > 1 ? std::atof(argv[1]) : 30.0;
  constexpr Nanoseconds kPeriod = 5ms;

  boost::asio::io_context io;
  const RealClock clock;
  AsioNetwork network{io, clock};
  const auto little = network.server(Endpoint::parse("127.0.0.1:0"));
  const auto big = network.server(Endpoint::parse("127.0.0.1:0"));
  const auto frames = network.datagram(Endpoint::parse("127.0.0.1:0"));
  const auto discovery = network.datagram(Endpoint::parse("127.0.0.1:0"));
  qualisys::DeviceConfig config;
  config.bodies = {{"load", true}, {"platform", true}, {"never seen", true}};
  config.labels = {"corner", "never seen"};
  config.timecode = qualisys::TimecodeSource::camera;
  config.base_port = static_cast<std::uint16_t>(little->local().port - 1);
  qualisys::QualisysDevice device{config, *little, *frames};
  little->on_event(&device);
  big->on_event(&device.serve_big_endian(*big));
  discovery->on_datagram([&](Bytes bytes, Endpoint from, LabTime t) { device.on_discovery(bytes, from, t); });

  const LabTime start = clock.now();
  LabTime next_exposure = start;
  boost::asio::steady_timer timer{io};
  std::function<void()> tick = [&] {
    const LabTime now = clock.now();
    if (now >= next_exposure) {
      device.capture(scene(device.frames() + 1), now);
      next_exposure += kPeriod;
      if (next_exposure <= now) next_exposure = now + kPeriod;
    }
    device.step(now);
    if (seconds(now - start) > limit_s) {
      io.stop();
      return;
    }
    timer.expires_after(1ms);
    timer.async_wait([&](const boost::system::error_code& error) {
      if (!error) tick();
    });
  };
  std::cout << "listening on " << little->local().port << ' ' << big->local().port << ' '
            << discovery->local().port << std::endl;
  tick();
  io.run();
  little->on_event(nullptr);
  big->on_event(nullptr);
  return 0;
}
