/// @file  The right to command: one at a time, handed over by moving, lost by silence.
#pragma once

#include <optional>
#include <utility>

#include "drivers/core/text.hpp"
#include "drivers/core/time.hpp"

namespace motionlab::controller {

/// Without a command of its holder for so long a lease ends.
inline constexpr Nanoseconds kLeaseDuration = 100ms;

/// Says who may command until when. Cannot be copied: whoever has it is the only one, and the guard lets
/// nothing move without one.
class Lease {
 public:
  Lease(Lease&& other) noexcept
      : taken_(std::exchange(other.taken_, nullptr)),
        owner_(other.owner_),
        external_(other.external_),
        expires_(other.expires_) {}
  Lease& operator=(Lease&& other) noexcept {
    std::swap(taken_, other.taken_);
    std::swap(owner_, other.owner_);
    std::swap(external_, other.external_);
    std::swap(expires_, other.expires_);
    return *this;
  }
  ~Lease() {
    if (taken_) *taken_ = false;
  }

  /// The holder gave a command at time t. An older one changes nothing, and what has expired stays so.
  void renew(LabTime t) noexcept {
    if (t < expires_ && t + kLeaseDuration > expires_) expires_ = t + kLeaseDuration;
  }
  [[nodiscard]] bool valid(LabTime t) const noexcept { return taken_ && t < expires_; }
  [[nodiscard]] LabTime expires() const noexcept { return expires_; }
  [[nodiscard]] const Text<32>& owner() const noexcept { return owner_; }
  /// Whether the owner commands himself; else the gateway's own controller does it for him.
  [[nodiscard]] bool external() const noexcept { return external_; }

 private:
  friend class LeaseDesk;
  Lease(bool& taken, const Text<32>& owner, bool external, LabTime t) noexcept
      : taken_(&taken), owner_(owner), external_(external), expires_(t + kLeaseDuration) {
    taken = true;
  }

  bool* taken_;
  Text<32> owner_;
  bool external_;
  LabTime expires_;
};

/// Gives out one lease at a time. Must outlive it, and stays where it is.
class LeaseDesk {
 public:
  LeaseDesk() = default;
  LeaseDesk(const LeaseDesk&) = delete;
  LeaseDesk& operator=(const LeaseDesk&) = delete;

  /// Nothing while somebody has one, expired or not, or for an owner without a name.
  [[nodiscard]] std::optional<Lease> grant(const Text<32>& owner, bool external, LabTime t) noexcept {
    if (taken_ || owner.empty()) return std::nullopt;
    return Lease(taken_, owner, external, t);
  }

 private:
  bool taken_ = false;
};

}  // namespace motionlab::controller
