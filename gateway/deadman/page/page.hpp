/// @file  The one page of memory that gateway and deadman share.
#pragma once

#include <atomic>
#include <cstdint>

#include "drivers/comau/comau_wire.hpp"
#include "drivers/core/latest.hpp"

namespace motionlab::deadman {

/// What the gateway is about.
enum class Phase : std::uint32_t {
  serving,  ///< it beats; if it does not, or is gone, arm and winch are brought to rest
  leaving,  ///< it ends without having seen arm and winch at rest: no beats are asked for, its end is watched
  ended,    ///< arm and winch are at rest, nobody is needed any more
};

/// The last datagram that really left for the robot computer.
struct LastSent {
  std::int64_t t_monotonic_ns = 0;  ///< CLOCK_MONOTONIC, the same in both processes
  comau::Command command{};
};

/// Every field has one writer; nobody waits. A writer may die at any instruction: the newest whole value
/// stays.
struct Page {
  Latest<LastSent> sent;                        ///< by the io thread, with each datagram
  std::atomic<std::uint64_t> io_beats{0};       ///< by the io thread, with each step of the drivers
  std::atomic<std::uint64_t> control_beats{0};  ///< by the control thread, with each step
  std::atomic<Phase> phase{Phase::serving};     ///< by the house thread
  std::atomic<std::uint64_t> deadman_ticks{0};  ///< by the deadman, with each look
};

static_assert(std::atomic<std::uint64_t>::is_always_lock_free && std::atomic<Phase>::is_always_lock_free,
              "a lock cannot be shared with a process that may die while it holds it");

}  // namespace motionlab::deadman
