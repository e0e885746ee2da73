/// @file  The requests that are still without an answer.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>

#include "drivers/core/time.hpp"
#include "drivers/winch/winch_wire.hpp"

namespace motionlab::winch {

enum class Purpose : std::uint8_t { none, set_up, write_command, read_status, clean_up };

struct Request {
  Purpose purpose = Purpose::none;
  AdsCommand command{};
  std::uint32_t invoke_id = 0;
  LabTime t_sent{};
};

/// A few slots. Answers find their request by invoke id and command; what is never answered expires.
class RequestTable {
 public:
  /// Enters a request and gives it an invoke id; nothing when all slots wait for answers.
  [[nodiscard]] std::optional<std::uint32_t> open(Purpose purpose, AdsCommand command, LabTime t) noexcept {
    const auto slot = find([](const Request& r) { return r.purpose == Purpose::none; });
    if (slot == slots_.end()) return std::nullopt;
    *slot = {purpose, command, ++invoke_id_, t};
    return invoke_id_;
  }

  /// The request that this frame answers, which is closed with that; nothing when we did not ask.
  [[nodiscard]] std::optional<Request> close(const AmsHeader& header) noexcept {
    const auto slot = find([&](const Request& r) {
      return r.purpose != Purpose::none && r.invoke_id == header.invoke_id &&
             static_cast<std::uint16_t>(r.command) == header.command;
    });
    if (slot == slots_.end() || !header.is_response()) return std::nullopt;
    return std::exchange(*slot, Request{});
  }

  /// Takes out one request that is older than the limit, or nothing.
  [[nodiscard]] std::optional<Request> expired(LabTime now, Nanoseconds limit) noexcept {
    const auto slot =
        find([&](const Request& r) { return r.purpose != Purpose::none && now - r.t_sent >= limit; });
    if (slot == slots_.end()) return std::nullopt;
    return std::exchange(*slot, Request{});
  }

  [[nodiscard]] bool waiting_for(Purpose purpose) const noexcept {
    return std::any_of(slots_.begin(), slots_.end(), [&](const Request& r) { return r.purpose == purpose; });
  }
  /// Answers to these no longer matter.
  void forget(Purpose purpose) noexcept {
    for (auto& slot : slots_) {
      if (slot.purpose == purpose) slot = {};
    }
  }
  void clear() noexcept { slots_ = {}; }

 private:
  static constexpr std::size_t kSlots = 8;
  using Slots = std::array<Request, kSlots>;

  template <class Matches>
  Slots::iterator find(Matches matches) noexcept {
    return std::find_if(slots_.begin(), slots_.end(), matches);
  }

  Slots slots_{};
  std::uint32_t invoke_id_ = 0;
};

}  // namespace motionlab::winch
