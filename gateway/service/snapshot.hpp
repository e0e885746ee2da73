/// @file  What enters a control step, gathered once, and what is known then: asynchrony ends here.
#pragma once

#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/service/devices.hpp"
#include "gateway/service/gateway_config.hpp"
#include "idl/snapshot.hpp"
#include "idl/topics.hpp"

namespace motionlab::service {

/// The newest samples at one time, each with its age.
struct Snapshot {
  LabTime t{};
  LabTime t_next_send{};      ///< when the arm's next command leaves
  bool deadman_lost = false;  ///< nobody would brake the arm if this process died
  std::optional<topic::Mru> mru;
  std::optional<topic::Bodies> load;
  std::optional<topic::Bodies> platform;
  std::optional<topic::ArmState> arm;
  std::optional<topic::WinchState> winch;
  std::optional<topic::Mru> second_mru;
  std::optional<topic::ArmCommand> external_arm;  ///< what an external controller wants, if there is one
  std::optional<topic::WinchCommand> external_winch;
};

/// How old a sample's measurement is at time t, in s; -1 before the first.
template <class Sample>
[[nodiscard]] double age_s(const std::optional<Sample>& sample, LabTime t) {
  return sample ? 1e-9 * static_cast<double>(to_ns(t) - sample->t_measured_ns) : -1.0;
}

/// Whether a sample arrived within the last `limit_s`. Nothing is fresh before it was heard.
template <class Sample>
[[nodiscard]] bool fresh(const std::optional<Sample>& sample, LabTime t, double limit_s) {
  return sample && 1e-9 * static_cast<double>(to_ns(t) - sample->t_received_ns) <= limit_s;
}

/// The gateway's own name among those who command.
inline constexpr std::string_view kGatewayRequester = "motionlab-gateway";

/// Gathers everything that a control step depends on, from bus and arm schedule: what is not in here cannot
/// change what the step does, so that a recording of it can be run again. Wait-free; one thread.
class Inputs {
 public:
  Inputs(const GatewayConfig& config, bus::LocalBus& local, ArmSchedule& schedule);

  /// What is new since the last call. Lives until the next. `outputs_crc` is the caller's to fill.
  [[nodiscard]] topic::Snapshot& gather(LabTime t);
  /// Adds what this controller wants to what was gathered; empty: there is none.
  void gather_commands_of(const Text<32>& controller);

 private:
  bus::Reader<topic::Mru> mru_;
  bus::Reader<topic::Bodies> load_;
  bus::Reader<topic::Bodies> platform_;
  bus::Reader<topic::ArmState> arm_;
  bus::Reader<topic::WinchState> winch_;
  bus::Reader<topic::Mru> second_mru_;
  bus::Subscription<topic::ModeRequest> requests_;
  bus::Subscription<topic::Reference> references_;
  ArmSchedule& schedule_;
  const bus::LocalBus& local_;
  Text<32> arm_name_, winch_name_;
  topic::Snapshot inputs_;
};

/// Remembers the newest of each source.
class Newest {
 public:
  /// What is known after these inputs. Lives until the next call.
  const Snapshot& take(const topic::Snapshot& inputs);

 private:
  Snapshot now_;
};

}  // namespace motionlab::service
