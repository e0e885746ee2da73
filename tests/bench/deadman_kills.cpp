/// @file  deadman_kills: kills an engaged gateway again and again and takes the time until the arm is braked.
///
/// Measured at the arm's end of the wire, by the kernel's arrival stamps: from just before kill -9 to the
/// first datagram of the ramp. Each time the wire must show braking within the deceleration limit down to
/// mode 0, and the plant an arm that rests. Times are printed, and asserted only as far as any machine can
/// keep them.
///
///   deadman_kills [--kills N] [--robot hardened|faithful]

#include <cstdio>
#include <cstdlib>
#include <iostream>

#include "tests/integration/deadman_bench.hpp"

namespace motionlab::integration {

const char* const kGatewayProgram = MOTIONLAB_GATEWAY;
const char* const kSimulatorProgram = MOTIONLAB_SIM;

namespace {

/// A machine that others share may stand still for so long, and still the arm has to be braked.
constexpr double kCoarsest_ms = 2000.0;

struct Kill {
  double to_braking_ms = 0;
  double speed_radps = 0;          ///< of the fastest joint, when it was killed
  double deceleration_radps2 = 0;  ///< the hardest on the plant, over a tenth of a second
};

/// So many lives may end before they were engaged: on a machine that stands still, devices seem to be lost.
constexpr int kStillborn = 5;

/// Engages, however often that takes.
bool engage(DeadmanBench& bench) {
  for (int attempt = 0; attempt < kStillborn; ++attempt) {
    const std::string wrong = bench.engage_in_a_sea();
    if (wrong.empty()) return true;
    std::cerr << "once more: " << wrong << std::endl;
    bench.gateway_.reset();
    (void)bench.port_is_free();
  }
  return false;
}

/// One life of a gateway. @returns nothing, and says why, when something was not as it must be
std::optional<Kill> kill_one(DeadmanBench& bench, Witness& witness) {
  const auto failed = [&](const std::string& why) {
    std::cerr << why << std::endl;
    if (bench.gateway_) std::cerr << bench.gateway_->output() << std::endl;
    return std::nullopt;
  };
  if (!engage(bench)) return failed("the gateway does not engage");
  witness.look_anew();
  const std::int64_t t_kill_ns = real_time_ns();
  bench.gateway_->send(SIGKILL);
  if (bench.gateway_->exit_code(kPatience) != -SIGKILL) return failed("the gateway was not killed");
  if (!bench.port_is_free()) return failed("the deadman does not come to an end");
  if (!witness.arm_rests()) return failed("the arm does not come to rest");
  const auto seen = bench.tap_->seen();
  const auto first = first_braking(seen, t_kill_ns);
  if (!first) return failed("no braking datagram on the arm's wire");
  if (!brakes_to_the_end(seen, *first))
    return failed("the ramp is not one of the stop deceleration down to mode 0");
  return Kill{1e-6 * static_cast<double>(seen[*first].t_ns - t_kill_ns), seen[*first].fastest_radps(),
              witness.hardest_braking_radps2()};
}

int measure(int kills, bool faithful) {
  DeadmanBench bench;
  bench.set_up(faithful ? "kills-faithful" : "kills-hardened", faithful);
  std::vector<double> times;
  std::vector<double> decelerations;
  {
    Witness witness(bench.domain_);
    for (int i = 0; i < kills; ++i) {
      const auto kill = kill_one(bench, witness);
      if (!kill) break;
      std::printf("kill %3d: %8.2f ms, at %.3f rad/s, plant braked with at most %.2f rad/s2\n", i + 1,
                  kill->to_braking_ms, kill->speed_radps, kill->deceleration_radps2);
      std::fflush(stdout);
      times.push_back(kill->to_braking_ms);
      decelerations.push_back(kill->deceleration_radps2);
    }
  }
  bench.tear_down();
  if (times.size() < static_cast<std::size_t>(kills)) return 1;
  std::ranges::sort(times);
  std::ranges::sort(decelerations);
  std::printf(
      "%s: %d kills, kill -9 to the first braking datagram at the arm: median %.2f ms, worst %.2f ms; "
      "braking on the plant: median %.2f, worst %.2f rad/s2 (limit on the wire %.2f)\n",
      faithful ? "faithful" : "hardened", kills, times[times.size() / 2], times.back(),
      decelerations[decelerations.size() / 2], decelerations.back(), kStopDeceleration);
  return times[times.size() / 2] < kCoarsest_ms ? 0 : 1;
}

}  // namespace
}  // namespace motionlab::integration

int main(int argc, char** argv) {
  int kills = 100;
  bool faithful = false;
  for (int i = 1; i < argc; ++i) {
    const std::string option = argv[i];
    const std::string value = i + 1 < argc ? argv[++i] : "";
    if (option == "--kills" && std::atoi(value.c_str()) > 0) {
      kills = std::atoi(value.c_str());
    } else if (option == "--robot" && (value == "hardened" || value == "faithful")) {
      faithful = value == "faithful";
    } else {
      std::cerr << "usage: deadman_kills [--kills N] [--robot hardened|faithful]\n";
      return 64;
    }
  }
  return motionlab::integration::measure(kills, faithful);
}
