// What a simulated motion reference unit sends, for decoders that other people wrote.
//
//   mru_stream FORMAT    writes to standard output, a hundred times: one line of JSON with what was measured,
//   in SI; then
//                        the number of bytes of the datagram as text, a newline, and the datagram
#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <string>

#include "drivers/core/random.hpp"
#include "simulators/mru/mru_device.hpp"

namespace {

using namespace motionlab;

class StandardOutput : public DatagramOut {
 public:
  Status send(Endpoint, Bytes datagram) override {
    std::printf("%zu\n", datagram.size());
    std::fwrite(datagram.data(), 1, datagram.size(), stdout);
    return Done{};
  }
};

void print(const char* name, const std::array<double, 3>& values) {
  std::printf("\"%s\": [%.17g, %.17g, %.17g], ", name, values[0], values[1], values[2]);
}

std::array<double, 3> draw(Random& random, double most) {
  return {random.uniform(-most, most), random.uniform(-most, most), random.uniform(-most, most)};
}

}  // namespace

int main(int argc, char** argv) {
  const std::string name = argc > 1 ? argv[1] : "";
  const auto* const format = std::ranges::find(mru::kFormatNames, name);
  if (format == mru::kFormatNames.end()) {
    std::cerr << "usage: mru_stream FORMAT\n";
    return 64;
  }
  mru::DeviceConfig config;
  config.format = mru::kFormats[static_cast<std::size_t>(format - mru::kFormatNames.begin())];
  config.system_time_start_ms = 123'456;
  StandardOutput out;
  mru::MruDevice device{config, out};
  Random random{4};
  LabTime t = from_ns(1'700'000'000'250'000'000);
  for (int i = 0; i < 100; ++i, t += 5ms) {
    const bool stable = i % 10 != 9;
    (void)device.set_fault("unstable", !stable);
    mru::Reading reading;
    reading.euler_heading_mru_rad = draw(random, 0.5);
    reading.euler_heading_mru_rad[2] = random.uniform(-3.1, 3.1);
    reading.omega_mru_radps = draw(random, 0.5);
    reading.omega_down_radps = random.uniform(-0.5, 0.5);
    reading.v_mru_mps = draw(random, 2.0);
    reading.a_mru_mps2 = draw(random, 2.0);
    reading.p_heading_origin_m = draw(random, 2.0);
    reading.v_heading_origin_mps = draw(random, 2.0);
    reading.a_heading_origin_mps2 = draw(random, 2.0);
    std::printf("{\"t_ns\": %lld, \"since_start_ms\": %d, \"stable\": %s, ", static_cast<long long>(to_ns(t)),
                5 * i, stable ? "true" : "false");
    print("euler_rad", reading.euler_heading_mru_rad);
    print("omega_radps", reading.omega_mru_radps);
    print("v_unit_mps", reading.v_mru_mps);
    print("a_unit_mps2", reading.a_mru_mps2);
    print("p_heading_m", reading.p_heading_origin_m);
    print("v_heading_mps", reading.v_heading_origin_mps);
    print("a_heading_mps2", reading.a_heading_origin_mps2);
    std::printf("\"omega_down_radps\": %.17g, \"temperature_degc\": %.17g}\n", reading.omega_down_radps,
                reading.sensor_temperature_degc);
    device.measure(reading, t);
    device.step(t + 100ms);
  }
  return 0;
}
