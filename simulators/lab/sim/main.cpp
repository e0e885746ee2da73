/// @file  motionlab-sim: the simulated laboratory on real sockets, in real time.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <vector>

#include "drivers/core/asio_network.hpp"
#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"
#include "gateway/bus/dds_bus.hpp"
#include "gateway/bus/local_bus.hpp"
#include "simulators/lab/fault_plan.hpp"
#include "simulators/lab/lab_config.hpp"
#include "simulators/lab/settings.hpp"
#include "simulators/lab/simulated_lab.hpp"

namespace {

using namespace motionlab;

constexpr auto kService = std::chrono::microseconds{500};
constexpr Nanoseconds kTruthPeriod = 5ms;
constexpr Nanoseconds kDisciplinePeriod = 1s;
/// So far ahead a sea without an end is checked against the platform's limits.
constexpr double kLookAhead_s = 600;

struct Options {
  std::string config = "deploy/config/world.toml";
  std::vector<std::string> overlays;
  std::string scenario = "thesis-wave";
  std::string platform = "tracked";
  std::string sensors = "real";
  std::string differences = "on";
  std::string limits = "mechanical";
  std::vector<std::string> settings;
  std::uint64_t seed = 1;
  double seconds = 0;
  std::int64_t start_at_ns = 0;
  std::vector<std::string> faults;
  bool dds = true;
};

std::vector<std::filesystem::path> paths(const std::vector<std::string>& texts) {
  return {texts.begin(), texts.end()};
}

lab::LabConfig configure(const Options& options, LabTime now) {
  const auto settings = lab::Settings::parse(options.settings);
  lab::LabConfig config = lab::LabConfig::load(options.config, paths(options.overlays), settings.world);
  config.set_scenario(options.scenario);
  if (options.start_at_ns > 0) {
    config.scenario.delay_s = std::max(0.0, seconds(from_ns(options.start_at_ns) - now));
  }
  config.seed = options.seed;
  config.refuse_beyond(
      options.limits == "plc" ? plant::PlatformLimits::plc() : plant::PlatformLimits::mechanical(),
      options.seconds > 0 ? options.seconds : kLookAhead_s);
  config.set_platform_tracked(options.platform == "tracked");
  if (options.differences == "off") config.use_belief_as_world();
  if (options.sensors == "ideal") config.use_perfect_sensors();
  return config;
}

/// Those of the world's file, then those of the command line.
std::vector<lab::PlannedFault> planned_faults(const lab::LabConfig& config, const Options& options) {
  std::vector<lab::PlannedFault> faults = config.faults;
  for (const std::string& text : options.faults) faults.push_back(lab::PlannedFault::parse(text));
  return faults;
}

/// The planned faults, each switched on and off once.
class FaultSchedule {
 public:
  FaultSchedule(const std::vector<lab::PlannedFault>& faults, lab::SimulatedLab& lab) : lab_(lab) {
    for (const lab::PlannedFault& planned : faults) {
      entries_.push_back({planned});
      // Ending a fault that never began changes nothing, but a name that is not known is refused.
      if (const Status known = lab_.set_fault(planned.device, planned.fault, false); !known) {
        throw StartupError("fault " + planned.device + ":" + planned.fault + ": " +
                           std::string(known.fault().text));
      }
    }
  }

  void step(double since_start_s) {
    for (Entry& entry : entries_) {
      if (!entry.begun && since_start_s >= entry.planned.from_s) entry.begun = set(entry.planned, true);
      if (!entry.ended && entry.planned.until_s && since_start_s >= *entry.planned.until_s) {
        entry.ended = set(entry.planned, false);
      }
    }
  }

 private:
  struct Entry {
    lab::PlannedFault planned;
    bool begun = false;
    bool ended = false;
  };

  bool set(const lab::PlannedFault& fault, bool active) {
    (void)lab_.set_fault(fault.device, fault.fault, active, fault.value);
    std::cout << fault.device << ": fault " << fault.fault << (active ? " begins" : " ends") << std::endl;
    return true;
  }

  lab::SimulatedLab& lab_;
  std::vector<Entry> entries_;
};

/// Truth goes out, faults come in. Both in the partition that the gateway never joins.
class TruthDoor {
 public:
  explicit TruthDoor(const lab::LabConfig& config)
      : publisher_(local_.advertise<topic::TruthWorld>()),
        faults_(local_.subscribe<topic::SimControl>()),
        dds_({.domain = config.bus_domain,
              .interface_whitelist = config.bus_interfaces,
              .participant = "motionlab-sim",
              .join_truth = true},
             local_) {
    dds_.out<topic::TruthWorld>();
    dds_.in<topic::SimControl>();
    dds_.start();
  }
  ~TruthDoor() { dds_.stop(); }
  TruthDoor(const TruthDoor&) = delete;
  TruthDoor& operator=(const TruthDoor&) = delete;

  void step(lab::SimulatedLab& lab, LabTime now) {
    while (const auto wanted = faults_.next()) {
      const Status done = lab.set_fault(wanted->device, wanted->fault, wanted->active, wanted->value);
      if (done) {
        std::cout << wanted->device.view() << ": fault " << wanted->fault.view()
                  << (wanted->active ? " begins" : " ends") << std::endl;
      } else {
        std::cerr << "sim/control: " << done.fault().text << std::endl;
      }
    }
    if (now < next_) return;
    next_ = std::max(next_ + kTruthPeriod, now);
    publisher_.publish(lab.truth());
  }

 private:
  bus::LocalBus local_;
  bus::Publisher<topic::TruthWorld> publisher_;
  bus::Subscription<topic::SimControl> faults_;
  bus::DdsBus dds_;
  LabTime next_{};
};

class Simulator {
 public:
  explicit Simulator(const Options& options)
      : config_(configure(options, clock_.now())),
        network_(io_, clock_),
        born_(clock_.now()),
        start_(born_ + from_seconds(config_.scenario.delay_s)),
        lab_(config_, network_, born_),
        schedule_(planned_faults(config_, options), lab_),
        timer_(io_),
        signals_(io_, SIGINT, SIGTERM) {
    if (options.seconds > 0) end_ = start_ + from_seconds(options.seconds);
    if (options.dds) door_.emplace(config_);
    signals_.async_wait([this](const boost::system::error_code& error, int) {
      if (!error) io_.stop();
    });
  }

  [[nodiscard]] const lab::LabConfig& config() const { return config_; }

  void run() {
    serve();
    io_.run();
  }

 private:
  void serve() {
    const LabTime now = clock_.now();
    lab_.step(now);
    schedule_.step(seconds(now - start_));
    if (door_) door_->step(lab_, now);
    if (end_ && now >= *end_) {
      io_.stop();
      return;
    }
    if (now >= next_discipline_) {
      clock_.discipline();
      next_discipline_ = now + kDisciplinePeriod;
    }
    if (!lab_.arm_program_alive() && !said_crashed_) {
      said_crashed_ = true;
      std::cerr << "arm: the robot PC's program has ended on its own defect (remote mode before the first "
                   "datagram); "
                   "start again, or set hardened = true in [devices.arm]"
                << std::endl;
    }
    timer_.expires_after(kService);
    timer_.async_wait([this](const boost::system::error_code& error) {
      if (!error) serve();
    });
  }

  RealClock clock_;
  lab::LabConfig config_;
  boost::asio::io_context io_{1};
  AsioNetwork network_;
  LabTime born_;   ///< the devices live
  LabTime start_;  ///< the scenario begins
  std::optional<LabTime> end_;
  LabTime next_discipline_{};
  lab::SimulatedLab lab_;
  FaultSchedule schedule_;
  std::optional<TruthDoor> door_;
  boost::asio::steady_timer timer_;
  boost::asio::signal_set signals_;
  bool said_crashed_ = false;
};

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "The simulated Motion-Lab: two MRUs, cameras, crane arm and winch on real sockets, in real time."};
  app.add_option("--config", options.config, "the world")->capture_default_str();
  app.add_option("--overlay", options.overlays, "files laid over it, in order");
  app.add_option("--scenario", options.scenario, "thesis-wave, sea, pierson-moskowitz, calm or csv:FILE")
      ->capture_default_str();
  app.add_option("--seed", options.seed, "of everything random")->capture_default_str();
  app.add_option("--seconds", options.seconds, "run the scenario so long; 0: until a signal")
      ->check(CLI::Range(0.0, 1e9));
  app.add_option(
      "--fault", options.faults,
      "DEVICE:FAULT[=VALUE]@FROM[..UNTIL], seconds since the scenario began; ok ends all of a device's");
  app.add_option("--platform", options.platform, "markers on the platform or not")
      ->check(CLI::IsMember({"tracked", "untracked"}))
      ->capture_default_str();
  app.add_option("--sensors", options.sensors, "ideal: no noise, bias or drift")
      ->check(CLI::IsMember({"ideal", "real"}))
      ->capture_default_str();
  app.add_option("--differences", options.differences, "off: the world is what the gateway believes")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  app.add_option("--limits", options.limits, "of the platform, which the sea has to keep")
      ->check(CLI::IsMember({"mechanical", "plc"}))
      ->capture_default_str();
  app.add_option("--set", options.settings, "world.KEY=VALUE over the files, e.g. world.load.mass_kg=36")
      ->take_all();
  app.add_option("--start-at-ns", options.start_at_ns,
                 "laboratory time at which the scenario begins (the ship stands still until then); 0: now");
  app.add_flag("!--no-dds", options.dds, "publish no truth, take no faults at run time");
  CLI11_PARSE(app, argc, argv);

  try {
    Simulator simulator(options);
    const lab::LabConfig& config = simulator.config();
    std::cout << "motionlab-sim: " << options.scenario << ", seed " << options.seed << ", arm at "
              << to_string(config.arm_listen) << ", cameras at " << to_string(config.qualisys_listen)
              << ", winch at " << to_string(config.winch_listen) << ", MRUs to "
              << to_string(config.mru1.device.to) << " and " << to_string(config.mru2.device.to) << std::endl;
    simulator.run();
  } catch (const StartupError& error) {
    std::cerr << "motionlab-sim: " << error.what() << std::endl;
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "motionlab-sim: " << error.what() << std::endl;
    return 1;
  }
  return 0;
}
