/// @file  The newest samples at one time, each with its age: asynchrony ends here.
#pragma once

#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/service/gateway_config.hpp"
#include "idl/topics.hpp"

namespace motionlab::service {

struct Snapshot {
  LabTime t{};
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

/// Takes snapshots from the bus. Wait-free; one thread.
class Snapshots {
 public:
  Snapshots(const GatewayConfig& config, bus::LocalBus& local);
  /// @param controller  whose commands are taken up; empty: nobody's
  [[nodiscard]] Snapshot at(LabTime t, const Text<32>& controller);

 private:
  /// Keeps the last sample for the moment in which a reader is overtaken by its writer.
  template <class T>
  struct Source {
    bus::Reader<T> reader;
    std::optional<T> last;
    const std::optional<T>& newest() {
      if (auto sample = reader.newer()) last = *sample;
      return last;
    }
  };

  Source<topic::Mru> mru_;
  Source<topic::Bodies> load_;
  Source<topic::Bodies> platform_;
  Source<topic::ArmState> arm_;
  Source<topic::WinchState> winch_;
  Source<topic::Mru> second_mru_;
  const bus::LocalBus& local_;
  Text<32> arm_name_, winch_name_;
};

}  // namespace motionlab::service
