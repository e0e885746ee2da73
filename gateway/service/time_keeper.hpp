/// @file  How the control thread keeps time, and whose fault it is when a deadline is missed.
#pragma once

#include <optional>

#include "drivers/core/time.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/snapshot.hpp"
#include "gateway/service/time_histogram.hpp"
#include "idl/health.hpp"
#include "idl/timing.hpp"

namespace motionlab::service {

/// Why a control step had not what it needed in time.
enum class MissedDeadline : std::size_t {
  late_wakeup,  ///< the kernel woke the thread a period or more too late
  long_step,    ///< the step itself took longer than a period
  late_sample,  ///< a required sample came after three periods though it was measured in time: network or io
  late_device,  ///< a required sample was not measured within three periods, or was lost
};

/// Counts and attributes. One thread; nothing allocates, and nothing here changes a command.
class TimeKeeper {
 public:
  explicit TimeKeeper(const GatewayConfig& config);

  /// The thread woke up `late` after its beat, having slept through `missed` more.
  void woke(Nanoseconds late, std::uint64_t missed) noexcept;
  /// Of the thread so far, as the kernel counts them.
  void page_faults(std::uint64_t count) noexcept;
  /// One step took so long, on this snapshot. @param age_s  of the sample behind a command; nothing: at rest
  void stepped(const Snapshot& now, double step_us, std::optional<double> age_s) noexcept;

  /// The row "gateway" of `motionlab/health`.
  [[nodiscard]] topic::Health health(LabTime t) const;
  [[nodiscard]] topic::Timing timing(LabTime t) const;

 private:
  /// One source's newest sample.
  struct Source {
    Text<32> device;
    Nanoseconds deadline{};
    std::uint64_t sequence = 0;
    std::int64_t t_measured_ns = 0, t_received_ns = 0;
  };
  template <class Sample>
  void look(Source& source, const std::optional<Sample>& sample) noexcept;
  void missed(MissedDeadline cause, std::uint64_t times = 1) noexcept;

  double period_us_;
  Source mru_, arm_, winch_;
  std::optional<LabTime> t_last_;
  std::uint64_t steps_ = 0;
  std::uint64_t page_faults_ = 0;
  std::optional<std::uint64_t> page_faults_at_start_;
  std::array<std::uint64_t, 4> missed_{};
  Text<200> last_miss_;
  TimeHistogram period_, wakeup_, step_, age_;
};

}  // namespace motionlab::service
