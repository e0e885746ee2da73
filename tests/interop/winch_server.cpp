// The simulated winch controller alone on a real TCP port, for other people's ADS clients.
//
//   interop_winch_server [seconds]    serves on a free port of 127.0.0.1, prints it, ends by itself
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdlib>
#include <functional>
#include <iostream>

#include "drivers/core/asio_network.hpp"
#include "drivers/core/real_clock.hpp"
#include "simulators/winch/winch_device.hpp"

int main(int argc, char** argv) {
  using namespace motionlab;
  const double limit_s = argc > 1 ? std::atof(argv[1]) : 30.0;
  constexpr Nanoseconds kTaskPeriod = 5ms;

  boost::asio::io_context io;
  const RealClock clock;
  AsioNetwork network{io, clock};
  const auto server = network.server(Endpoint::parse("127.0.0.1:0"));
  winch::WinchDevice device{{}, *server};
  server->on_event(&device);

  // An ideal drive: what it holds is what is measured; behind a closed brake the wire stays where it is.
  const LabTime start = clock.now();
  LabTime next_cycle = start;
  LabTime last_cycle = start - kTaskPeriod;
  double last_step_s = seconds(kTaskPeriod);  // the set point of the last cycle moved over this time
  winch::Measurement measurement{.wire_length_m = 2.0};
  boost::asio::steady_timer timer{io};
  std::function<void()> tick = [&] {
    const LabTime now = clock.now();
    device.step(now);
    if (now >= next_cycle) {
      const double before_m = measurement.wire_length_m;
      if (!device.brake_closed()) measurement.wire_length_m = device.set_point_m();
      measurement.wire_speed_mps = (measurement.wire_length_m - before_m) / last_step_s;
      device.cycle(now, measurement);
      last_step_s = seconds(now - last_cycle);
      last_cycle = now;
      next_cycle += kTaskPeriod;
      if (next_cycle <= now) next_cycle = now + kTaskPeriod;
    }
    if (seconds(now - start) > limit_s) {
      io.stop();
      return;
    }
    timer.expires_after(1ms);
    timer.async_wait([&](const boost::system::error_code& error) {
      if (!error) tick();
    });
  };
  std::cout << "listening on " << to_string(server->local()) << std::endl;
  tick();
  io.run();
  server->on_event(nullptr);
  return 0;
}
