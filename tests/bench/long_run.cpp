/// @file  long_run: gateway and simulated laboratory as processes, engaged in a sea for a long time, and the
/// accounts.
///
///   long_run [--minutes M] [--short]
///
/// It fails when the engagement ends by itself, a sample or a beat of the control thread is unaccounted for,
/// one of its pages was not in memory, or memory grows; and, unless --short says that this is any machine,
/// when the 99th percentile of a control step is above 60 us. Freshness limits are those of
/// shared-vm.toml, and the control thread has the machine's last processor to itself, kept awake, where there
/// are two; with --short a second, for a machine that stands still.
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "gateway/service/real_time.hpp"
#include "tests/bench/engagement_accounts.hpp"
#include "tests/bench/gateway_meter.hpp"
#include "tests/integration/process_bench.hpp"

namespace motionlab {

const char* const integration::kGatewayProgram = MOTIONLAB_GATEWAY;
const char* const integration::kSimulatorProgram = MOTIONLAB_SIM;

namespace {

using Steady = std::chrono::steady_clock;
using Minutes = std::chrono::duration<double, std::ratio<60>>;

/// Whether all was as it must be; what was not is said as it is found.
class Verdict {
 public:
  void require(bool holds, const std::string& otherwise) {
    if (holds) return;
    std::printf("NOT SO: %s\n", otherwise.c_str());
    std::fflush(stdout);
    good_ = false;
  }
  [[nodiscard]] bool good() const { return good_; }

 private:
  bool good_ = true;
};

/// The same of every device, by its name, and of the control thread as "gateway".
using AllHealth = std::map<std::string, topic::Health>;

class LongRun : public integration::ProcessBench {
 public:
  LongRun() { set_up("long-run"); }
  ~LongRun() { tear_down(); }

  /// @returns whether all was as it must be; what was not is printed
  bool run(Minutes time, bool any_machine) {
    const auto length = std::chrono::duration_cast<Steady::duration>(time);
    const auto config =
        service::load_gateway_config(integration::config_file("lab.toml"),
                                     {integration::config_file("loopback.toml"), folder_ / "gateway.toml"});
    periods_ = test::periods(config);
    control_period_s_ = config.control_period_s;
    auto command = gateway_command();
    const int last_cpu = static_cast<int>(std::thread::hardware_concurrency()) - 1;
    if (!any_machine)
      command.insert(command.end(), {"--overlay", integration::config_file("shared-vm.toml")});
    if (!any_machine && last_cpu > 0) {
      write("own-processor.toml", "[control]\ncpu = " + std::to_string(last_cpu) + "\nawake = true\n");
      command.insert(command.end(), {"--overlay", (folder_ / "own-processor.toml").string()});
      service::leave_processor(last_cpu);  // and so does the simulator
    }
    gateway_ = std::make_unique<integration::Child>(command, folder_ / "gateway.log");
    simulator_ = start_simulator({"--scenario", "sea"});
    meter_ = std::make_unique<test::GatewayMeter>(domain_, "127.0.0.1");
    verdict_.require(meter_->engage(), "it can be engaged");
    std::this_thread::sleep_for(kToSettle);

    const AllHealth before = health();
    const topic::Timing timing_before = meter_->next_timing();
    watch(length);
    const test::ThreadAccount thread(timing_before, meter_->next_timing());
    const AllHealth after = health();

    judge_thread(thread, any_machine);
    judge_devices(before, after);
    judge_beats(before.at("gateway"), after.at("gateway"));
    judge_memory();
    meter_->ask(topic::ModeAction::settle);
    if (!verdict_.good()) std::printf("\nthe gateway's words:\n%s", gateway_->output().c_str());
    return verdict_.good();
  }

 private:
  [[nodiscard]] AllHealth health() const {
    AllHealth all{{"gateway", meter_->health("gateway")}};
    for (const auto& [device, period_s] : periods_) all[device] = meter_->health(device);
    return all;
  }

  void watch(Steady::duration length) {
    const auto engaged_since = meter_->mode().t_changed_ns;
    const auto begin = Steady::now();
    auto next = begin;
    while (next < begin + length && verdict_.good()) {
      next += length / kLooks;
      std::this_thread::sleep_until(next);
      gateway_memory_.add(test::resident_kb(gateway_->pid()));
      simulator_memory_.add(test::resident_kb(simulator_->pid()));
      verdict_.require(gateway_->running() && simulator_->running(), "both programs run");
      const topic::Mode mode = meter_->mode();
      verdict_.require(mode.state == topic::ModeState::engaged && mode.t_changed_ns == engaged_since,
                       "it stays engaged: " + std::string(mode.reason.view()));
    }
    std::printf("engaged for %.1f minutes in a sea\n\n", Minutes(Steady::now() - begin).count());
  }

  void judge_thread(const test::ThreadAccount& thread, bool any_machine) {
    thread.print();
    verdict_.require(any_machine || service::TimeHistogram::quantile_us(thread.step, 0.99) <= kMostStep_us,
                     "99 % of the steps take at most 60 us");
    verdict_.require(thread.page_faults == 0, "every page of the control thread is in memory: " +
                                                  std::to_string(thread.page_faults) + " were not");
  }

  void judge_devices(const AllHealth& before, const AllHealth& after) {
    std::printf("\n%-10s %10s %10s %7s %9s %11s %12s\n", "device", "expected", "received", "lost", "rejected",
                "reconnects", "oldest [ms]");
    for (const auto& [device, period_s] : periods_) {
      const test::DeviceAccount account(before.at(device), after.at(device), period_s);
      account.print();
      // The arm only answers: what slept through beats of the control thread sent no command either.
      const double left = account.unaccounted(device == "arm" ? slept_s(before, after) / period_s : 0);
      verdict_.require(
          left == 0, "every sample of " + device + " is accounted for: " + std::to_string(left) + " are not");
      verdict_.require(account.reconnects == 0, device + " stays connected");
    }
  }

  void judge_beats(const topic::Health& before, const topic::Health& after) {
    const test::DeviceAccount beats(before, after, control_period_s_);
    std::array<std::uint64_t, 4> missed{};
    for (std::size_t i = 0; i < missed.size(); ++i) {
      missed[i] = after.missed_deadlines[i] - before.missed_deadlines[i];
    }
    std::printf("\nbeats of the control thread: %.0f, steps: %llu\n", beats.expected,
                as_printed(beats.received));
    std::printf(
        "deadlines missed by a late wake-up %llu, a long step %llu, a late sample %llu, a late device %llu\n",
        as_printed(missed[0]), as_printed(missed[1]), as_printed(missed[2]), as_printed(missed[3]));
    const double left = beats.expected - static_cast<double>(beats.received + missed[0]);
    verdict_.require(std::abs(left) <= kBeatsOff, "every beat was a step or is counted as slept through: " +
                                                      std::to_string(left) + " are not");
  }

  void judge_memory() {
    const auto judge = [this](const char* who, const test::MemoryWatch& memory) {
      std::printf("%s: %.0f kB resident, grown by %.0f kB\n", who, memory.newest_kb(), memory.growth_kb());
      verdict_.require(memory.growth_kb() <= kMostGrowth_kb, std::string(who) + " does not grow");
    };
    judge("gateway", gateway_memory_);
    judge("simulator", simulator_memory_);
  }

  /// For so long the control thread slept through its beats.
  [[nodiscard]] double slept_s(const AllHealth& before, const AllHealth& after) const {
    return control_period_s_ * static_cast<double>(after.at("gateway").missed_deadlines[0] -
                                                   before.at("gateway").missed_deadlines[0]);
  }
  static unsigned long long as_printed(std::uint64_t count) { return count; }

  static constexpr std::chrono::seconds kToSettle{10};  // the ramp of authority, and first caches
  static constexpr int kLooks = 200;
  static constexpr double kMostStep_us = 60;
  static constexpr double kMostGrowth_kb = 512;
  static constexpr double kBeatsOff = 3;  // the two looks are not taken on a beat

  Verdict verdict_;
  std::vector<std::pair<std::string, double>> periods_;
  double control_period_s_ = 0;
  std::unique_ptr<integration::Child> gateway_, simulator_;
  std::unique_ptr<test::GatewayMeter> meter_;
  test::MemoryWatch gateway_memory_, simulator_memory_;
};

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  double minutes = 30;
  bool any_machine = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--short") == 0) {
      any_machine = true;
      minutes = 0.3;
    } else if (std::strcmp(argv[i], "--minutes") == 0 && i + 1 < argc) {
      minutes = std::atof(argv[++i]);
    } else {
      minutes = 0;
    }
  }
  if (!(minutes > 0)) {
    std::fputs("usage: long_run [--minutes M] [--short]\n", stderr);
    return 64;
  }
  motionlab::LongRun run;
  return run.run(motionlab::Minutes(minutes), any_machine) ? 0 : 1;
}
