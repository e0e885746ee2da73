/// @file  The whole line joined in memory on a virtual clock: world, devices, wires, drivers, estimator,
/// controller, guard.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "drivers/core/memory_network.hpp"
#include "drivers/core/time.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/record/run_recorder.hpp"
#include "gateway/record/run_tape.hpp"
#include "gateway/service/control_loop.hpp"
#include "gateway/service/devices.hpp"
#include "simulators/lab/fault_plan.hpp"
#include "simulators/lab/simulated_lab.hpp"

namespace motionlab::lockstep {

struct Config {
  service::GatewayConfig gateway;
  lab::LabConfig lab;
  std::vector<lab::PlannedFault> faults;
  bool timing =
      false;  ///< measure how long control steps take; the run is then no longer the same to the byte
};

/// Runs gateway and laboratory side by side, faster than time. Both are the objects that run in real time;
/// between them lies the memory network instead of sockets. The same configuration gives the same bytes.
/// Where the gateway's configuration names a recording it is written, over one of that name.
class Lockstep {
 public:
  explicit Lockstep(const Config& config);

  /// Advances everything by one control period.
  void step();

  [[nodiscard]] LabTime now() const { return clock_.now(); }
  [[nodiscard]] bus::LocalBus& bus() { return bus_; }
  [[nodiscard]] lab::SimulatedLab& lab() { return lab_; }
  [[nodiscard]] MemoryNetwork& network() { return network_; }

  /// Asks for a mode as a user would, by `motionlab/mode_request`.
  void request(topic::ModeAction action);

  /// Ends the recording, if there is one. @throws StartupError when it could not be written
  void finish_recording();

 private:
  struct RunningFault {
    lab::PlannedFault plan;
    bool active = false;
  };
  void apply_faults(LabTime t);

  SteppedClock clock_;
  MemoryNetwork network_;
  bus::LocalBus bus_;
  service::ArmSchedule schedule_;
  std::unique_ptr<record::RunTape> tape_;
  std::optional<record::RunRecorder> recorder_;
  lab::SimulatedLab lab_;
  service::Devices devices_;
  service::ControlLoop control_;
  bus::Publisher<topic::ModeRequest> requests_;
  std::vector<RunningFault> faults_;
  Nanoseconds period_;
  std::uint64_t requested_ = 0;
};

}  // namespace motionlab::lockstep
