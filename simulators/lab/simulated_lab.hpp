/// @file  The simulated laboratory: one world, its sensors, and five devices on a network; a sixth, the PLC's
/// remote interface, where it is wanted.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/network.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"
#include "idl/truth_world.hpp"
#include "simulators/lab/lab_config.hpp"
#include "simulators/plant/world.hpp"

namespace motionlab::lab {

/// Everything on the far side of the wires. The network decides whether it talks to real sockets or to the
/// other half of a lockstep run.
///
/// `step(now)` runs, in the order of time, the robot PC's cycle (0.4 ms), the PLC's task (5 ms), MRUs and
/// cameras (their periods), and lets the devices send what is due. The first of each happens at `start`. A
/// world tick is run as soon as the robot PC has given its set point for it, so that a measurement inside the
/// tick can be taken from it; what the winch is told inside a tick acts from the next one on. Deterministic:
/// the same configuration, network and step times give the same bytes.
class SimulatedLab {
 public:
  /// Binds all sockets. @throws StartupError naming the device and the address
  SimulatedLab(const LabConfig& config, Network& network, LabTime start);
  ~SimulatedLab();
  SimulatedLab(const SimulatedLab&) = delete;
  SimulatedLab& operator=(const SimulatedLab&) = delete;

  /// Brings everything to `now`. About every millisecond; later calls catch up.
  void step(LabTime now);
  /// When something happens next: step no later than this to miss no instant.
  [[nodiscard]] LabTime next_event() const;

  /// What is really so, at the time of the last `step`.
  [[nodiscard]] topic::TruthWorld truth();
  [[nodiscard]] plant::WorldState state();
  [[nodiscard]] const plant::World& world() const;

  /// Begins or ends a fault of the wire (faults::WireFaults) or else of the device itself (`mru1`, `mru2`,
  /// `qualisys`, `arm`, `winch`, and `plc` where it is served), by its name; or of the `world` (see Gust).
  /// `ok`, begun, ends all that a device and its wire have.
  /// @returns refused, with the names that there are; the text lives until the next call
  Status set_fault(std::string_view device, std::string_view fault, bool active, double value = 0);

  /// What a device and its wire may be able to do wrong, in their own words. Refusals depend on how they are
  /// configured: `set_fault` has the last word. Nothing for a device that is not there.
  [[nodiscard]] std::vector<std::string> fault_names(std::string_view device) const;

  /// True while the robot program lives; the faithful one can end on its own defects.
  [[nodiscard]] bool arm_program_alive() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace motionlab::lab
