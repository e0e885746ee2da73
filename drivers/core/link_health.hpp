/// @file  What a driver counts about its link. Plain numbers; the service turns them into `motionlab/health`.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"

namespace motionlab {

/// How far a link has come. `stale` is not kept here: it follows from the age and the reader's limit.
enum class LinkPhase : std::uint8_t { down, connecting, up };

/// Counts samples, losses and rejects of one device's link. Owned by its driver, one thread.
class LinkHealth {
 public:
  /// A sample was accepted.
  void accepted(LabTime t_measured, LabTime t_received) noexcept {
    if (!window_start_ || t_received - *window_start_ >= 1s) {
      if (window_start_) rate_hz_ = in_window_ / seconds(t_received - *window_start_);
      window_start_ = t_received;
      in_window_ = 0;
    }
    in_window_ += 1;
    if (t_measured_) age_max_ = std::max(age_max_, t_received - *t_measured_);
    t_measured_ = t_measured;
    t_received_ = t_received;
    ++received_;
  }
  /// A datagram, frame or answer was refused. The last fault is kept for the advice on `motionlab/health`.
  void rejected(Fault fault) noexcept {
    ++rejected_[static_cast<std::size_t>(fault.reason)];
    last_fault_ = fault;
  }
  void lost(std::uint64_t n) noexcept { lost_ += n; }
  void reconnected() noexcept { ++reconnects_; }
  void phase(LinkPhase phase) noexcept { phase_ = phase; }
  /// One sentence for people: what is wrong now and what to do. Empty when nothing is.
  void advice(std::string_view literal) noexcept { advice_ = literal; }

  [[nodiscard]] LinkPhase phase() const noexcept { return phase_; }
  [[nodiscard]] std::string_view advice() const noexcept { return advice_; }
  /// When the newest accepted sample was measured; nothing before the first.
  [[nodiscard]] std::optional<LabTime> t_measured() const noexcept { return t_measured_; }
  [[nodiscard]] std::optional<LabTime> t_received() const noexcept { return t_received_; }
  /// Accepted samples per second over the last whole second; 0 when none came for 1.5 s.
  [[nodiscard]] double rate_hz(LabTime now) const noexcept {
    return t_received_ && now - *t_received_ < 1500ms ? rate_hz_ : 0.0;
  }
  /// The greatest age that a sample reached before its successor arrived.
  [[nodiscard]] Nanoseconds age_max() const noexcept { return age_max_; }
  [[nodiscard]] std::uint64_t received() const noexcept { return received_; }
  [[nodiscard]] std::uint64_t lost() const noexcept { return lost_; }
  [[nodiscard]] std::uint64_t reconnects() const noexcept { return reconnects_; }
  [[nodiscard]] std::uint64_t rejected(Reason reason) const noexcept {
    return rejected_[static_cast<std::size_t>(reason)];
  }
  [[nodiscard]] std::uint64_t rejected_total() const noexcept {
    std::uint64_t total = 0;
    for (const auto n : rejected_) total += n;
    return total;
  }
  [[nodiscard]] std::optional<Fault> last_fault() const noexcept { return last_fault_; }

 private:
  std::array<std::uint64_t, kReasonCount> rejected_{};
  std::uint64_t received_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t reconnects_ = 0;
  std::optional<LabTime> t_measured_;
  std::optional<LabTime> t_received_;
  std::optional<LabTime> window_start_;
  std::optional<Fault> last_fault_;
  double in_window_ = 0;
  double rate_hz_ = 0;
  Nanoseconds age_max_{0};
  LinkPhase phase_ = LinkPhase::down;
  std::string_view advice_{};
};

}  // namespace motionlab
