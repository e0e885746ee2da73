// What it costs to be watched: a recorder of everything, the console with one client, and what ten observers
// do to the control thread of an engaged gateway, in interleaved pairs of stretches alone and watched.
//   bench_watching [--pairs N] [--seconds S]
//   bench_watching --short     no pairs, coarse limits: a test for any machine
// Fails when the recorder loses a sample by itself or either takes more than a tenth of a core, and when the
// median ratio of a step's processor time is above 1.1.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/gateway_meter.hpp"
#include "tests/bench/page_client.hpp"
#include "tests/integration/process_bench.hpp"

namespace motionlab {

const char* const integration::kGatewayProgram = MOTIONLAB_GATEWAY;
const char* const integration::kSimulatorProgram = MOTIONLAB_SIM;

namespace {

using integration::Child;
using integration::eventually;

constexpr int kObservers = 10;

struct Options {
  int pairs = 7;
  double seconds = 10;
  double most_share = 0.10, most_cpu = 1.1;
} options;

std::chrono::milliseconds stretch() {
  return std::chrono::milliseconds(static_cast<std::chrono::milliseconds::rep>(1e3 * options.seconds));
}

/// The share of a core that a process takes from now on, for a stretch.
double share_of(pid_t process) {
  const auto begin = std::chrono::steady_clock::now();
  const double before = integration::processor_s(process);
  std::this_thread::sleep_for(stretch());
  return (integration::processor_s(process) - before) /
         std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Processes that say goodbye at the end of their life, so that nobody goes on sending to them.
class Recorders {
 public:
  void add(std::unique_ptr<Child> recorder) { all_.push_back(std::move(recorder)); }
  Recorders() = default;
  Recorders(Recorders&&) = default;
  ~Recorders() {
    for (const auto& recorder : all_) recorder->send(SIGTERM);
    for (const auto& recorder : all_) (void)recorder->exit_code(test::kPatience);
  }

 private:
  std::vector<std::unique_ptr<Child>> all_;
};

class Watching : public integration::Processes {
 protected:
  void SetUp() override {
    Processes::SetUp();
    gateway_ = start_gateway();
    simulator_ = start_simulator({"--scenario", "sea"});
    meter_ = std::make_unique<test::GatewayMeter>(domain_, "127.0.0.1");
    ASSERT_TRUE(meter_->engage()) << meter_->mode().reason.view() << gateway_->output();
  }

  [[nodiscard]] std::unique_ptr<Child> start_recorder(const std::string& name) const {
    return std::make_unique<Child>(
        std::vector<std::string>{MOTIONLAB_HAND, "--domain", std::to_string(domain_), "--interface",
                                 "127.0.0.1", "record", "-o", (folder_ / (name + ".mcap")).string(),
                                 "--json"},
        folder_ / (name + ".log"));
  }
  [[nodiscard]] std::unique_ptr<Child> start_console() const {
    auto command = gateway_command();
    command.front() = MOTIONLAB_CONSOLE;
    command.insert(command.end(), {"--listen", "127.0.0.1:0"});
    return std::make_unique<Child>(command, folder_ / "console.log");
  }
  static std::uint16_t port_of(const Child& console) {
    static const std::string kBefore = "http://127.0.0.1:";
    std::size_t at = std::string::npos;
    (void)eventually([&] { return (at = console.output().find(kBefore)) != std::string::npos; },
                     test::kPatience);
    return at == std::string::npos
               ? 0
               : static_cast<std::uint16_t>(std::atoi(console.output().c_str() + at + kBefore.size()));
  }

  /// Pairs of stretches, in turn without and with what `watch` makes and keeps.
  template <class Watch>
  void compare(const char* who, Watch&& watch) {
    std::printf("%-14s %23s %23s %19s\n", who, "step cpu p50 [us]", "step cpu p99 [us]", "wake-up p99 [us]");
    std::vector<double> cpu, cpu_p99;
    for (int pair = 0; pair < options.pairs; ++pair) {
      test::Stretch alone, watched;
      const auto look = [&](bool is_watched) {
        const auto watchers = is_watched ? watch() : decltype(watch()){};
        std::this_thread::sleep_for(std::chrono::seconds{3});
        ASSERT_TRUE(meter_->engage()) << meter_->mode().reason.view() << gateway_->output();
        (is_watched ? watched : alone) = meter_->look_on(stretch());
      };
      look(pair % 2 != 0);
      look(pair % 2 == 0);
      if (HasFatalFailure()) return;
      cpu.push_back(watched.cpu_us(0.5) / alone.cpu_us(0.5));
      cpu_p99.push_back(watched.cpu_us(0.99) / alone.cpu_us(0.99));
      std::printf("%14d %8.1f > %5.1f %5.2fx %8.1f > %5.1f %5.2fx %8.0f > %5.0f\n", pair + 1,
                  alone.cpu_us(0.5), watched.cpu_us(0.5), cpu.back(), alone.cpu_us(0.99),
                  watched.cpu_us(0.99), cpu_p99.back(), alone.wakeup_us(0.99), watched.wakeup_us(0.99));
      std::fflush(stdout);
    }
    std::printf("median ratios: step cpu p50 %.2f, p99 %.2f\n", test::quantile(cpu, 0.5),
                test::quantile(cpu_p99, 0.5));
    EXPECT_LE(test::quantile(cpu, 0.5), options.most_cpu);
  }

  std::unique_ptr<Child> gateway_, simulator_;
  std::unique_ptr<test::GatewayMeter> meter_;
};

TEST_F(Watching, ARecorderOfEverythingIsCheapAndDropsNothing) {
  const auto recorder = start_recorder("run");
  std::this_thread::sleep_for(std::chrono::seconds{3});
  const double share = share_of(recorder->pid());
  recorder->send(SIGTERM);
  ASSERT_EQ(recorder->exit_code(test::kPatience), 0) << recorder->output();
  const auto told = nlohmann::json::parse(recorder->output());
  std::uint64_t on_dds = 0, in_queue = 0;
  for (const auto& topic : told.at("losses")) {
    on_dds += topic.at("lost_on_dds").get<std::uint64_t>();
    in_queue += topic.at("lost_in_queue").get<std::uint64_t>();
  }
  std::printf(
      "a recorder of everything: %.1f %% of a core, %.0f messages/s, lost %llu on DDS, %llu in its queue\n",
      100 * share, told.at("messages").get<double>() / told.at("seconds").get<double>(),
      static_cast<unsigned long long>(on_dds), static_cast<unsigned long long>(in_queue));
  EXPECT_EQ(in_queue, 0U);
  EXPECT_LE(share, options.most_share);
}

TEST_F(Watching, AConsoleWithOneClientIsCheap) {
  const auto console = start_console();
  const std::uint16_t port = port_of(*console);
  ASSERT_NE(port, 0) << console->output();
  const test::PageClient client(port);
  ASSERT_TRUE(eventually([&] { return client.samples() > 500; }, test::kPatience));
  const std::uint64_t before = client.samples();
  const double share = share_of(console->pid());
  std::printf("the console with one client: %.1f %% of a core, %.0f samples/s\n", 100 * share,
              static_cast<double>(client.samples() - before) / options.seconds);
  EXPECT_TRUE(client.well());
  EXPECT_LE(share, options.most_share);
}

TEST_F(Watching, TenClientsOfTheConsoleDoNotLengthenTheControlStep) {
  const auto console = start_console();
  const std::uint16_t port = port_of(*console);
  ASSERT_NE(port, 0) << console->output();
  compare("ten clients", [port] {
    std::vector<std::unique_ptr<test::PageClient>> clients;
    for (int i = 0; i < kObservers; ++i) clients.push_back(std::make_unique<test::PageClient>(port));
    return clients;
  });
}

TEST_F(Watching, TenRecordersOfEverythingDoNotLengthenTheControlStep) {
  int run = 0;
  compare("ten recorders", [this, &run] {
    Recorders recorders;
    ++run;
    for (int i = 0; i < kObservers; ++i) {
      recorders.add(start_recorder(std::to_string(run) + "-" + std::to_string(i)));
    }
    return recorders;
  });
}

}  // namespace
}  // namespace motionlab

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  auto& options = motionlab::options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--short") {
      options = {.seconds = 3, .most_share = 1};
      testing::GTEST_FLAG(filter) = "*Cheap*";
      continue;
    }
    const double number = i + 1 < argc ? std::atof(argv[i + 1]) : 0;
    if (number > 0 && word == "--pairs") {
      options.pairs = static_cast<int>(number);
    } else if (number > 0 && word == "--seconds") {
      options.seconds = number;
    } else {
      std::fprintf(stderr, "%s: see the head of tests/bench/watching_bench.cpp\n", argv[i]);
      return 64;
    }
    ++i;
  }
  return RUN_ALL_TESTS();
}
