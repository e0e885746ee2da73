/// @file  A device's cable, with faults that have names.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/core/network.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"

namespace motionlab::faults {

/// Makes a device's sockets on a network, and does to whatever passes them, both ways, what the faults that
/// are on say (WireFaults). While none is on, everything passes at once, untouched and uncopied.
///
/// What is held back passes at the next `step`; its arrival stamp is the time of that step. A stream that is
/// cut keeps all that was sent into it and hands it on, in order, when it is whole again, as TCP does;
/// datagrams in a cut wire are gone. Deterministic: the same seed, traffic and steps give the same faults.
class FaultyWire {
 public:
  /// Told how far the device's own clock is to be wrong from now on; 0: right again.
  using ClockHook = std::function<void(Nanoseconds jump)>;

  /// `name` makes the dice its own. Without a hook the device's bytes carry no clock. The network outlives
  /// the wire, and the wire its sockets.
  FaultyWire(Network& network, std::uint64_t seed, std::string name, ClockHook clock = {});
  ~FaultyWire();
  FaultyWire(const FaultyWire&) = delete;
  FaultyWire& operator=(const FaultyWire&) = delete;

  /// @throws StartupError as the network does
  std::unique_ptr<DatagramSocket> datagram(Endpoint local);
  std::unique_ptr<StreamServer> server(Endpoint local);

  /// Switches a fault of WireFaults.
  /// @returns refused, with the names or the reason: a name that is not known, a fault that TCP hides on a
  ///          wire without datagrams, a clock that is not there, no second address for `foreign`
  Status set_fault(std::string_view name, bool active, double value = 0);

  /// Hands on what is due. About every millisecond.
  void step(LabTime now);

 private:
  struct State;
  class Socket;
  class Server;
  std::unique_ptr<State> state_;
};

}  // namespace motionlab::faults
