/// @file  One direction of a faulty wire: datagrams go in, what is left of them comes out.
#pragma once

#include <cstddef>
#include <deque>
#include <functional>
#include <optional>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/random.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"
#include "simulators/faults/wire_faults.hpp"

namespace motionlab::faults {

/// Passes datagrams on at once and uncopied while no fault is on. Deterministic: the same seed and the same
/// datagrams give the same dice.
class DatagramPath {
 public:
  /// Hands a datagram on. `foreign`: it has to come from an address that is not the sender's.
  using Exit = std::function<Status(Bytes datagram, Endpoint peer, LabTime t, bool foreign)>;

  /// `faults` is looked at for every datagram and outlives this.
  DatagramPath(const WireFaults& faults, Random random, Exit exit)
      : faults_(faults), random_(random), exit_(std::move(exit)) {}

  /// @returns what the exit said, or success when the wire has it
  Status take(Bytes datagram, Endpoint peer, LabTime now);
  /// Hands on what is due.
  void step(LabTime now);

 private:
  struct Parcel {
    LabTime due{};
    Endpoint peer{};
    bool foreign = false;
    ByteBuffer bytes;
  };

  [[nodiscard]] bool is_lost();
  void flip_one_bit(ByteBuffer& bytes);
  void queue(Parcel parcel, LabTime due);

  const WireFaults& faults_;
  Random random_;
  Exit exit_;
  std::deque<Parcel> waiting_;       ///< in the order of leaving
  std::optional<Parcel> overtaken_;  ///< leaves behind the next one
  std::size_t still_to_lose_ = 0;    ///< of a burst
};

}  // namespace motionlab::faults
