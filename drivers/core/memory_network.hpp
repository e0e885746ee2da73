/// @file  A network inside one process, on stepped time: lockstep runs and pair tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>

#include "drivers/core/network.hpp"

namespace motionlab {

/// What happens to datagrams on their way to one destination. Probabilities lie in [0, 1].
struct DatagramFault {
  double loss = 0.0;       ///< never arrives
  double duplicate = 0.0;  ///< arrives twice
  double corrupt = 0.0;    ///< arrives with one byte changed
  double reorder = 0.0;    ///< is held back by `reorder_by`, so that later ones overtake it
  Nanoseconds reorder_by{10ms};
  Nanoseconds delay{0};   ///< added to the network's latency
  Nanoseconds jitter{0};  ///< added, uniform in [0, jitter); keeps the order
  bool silent = false;    ///< nothing arrives any more
};

/// What happens to the connections of one server, in both directions.
struct StreamFault {
  bool refuse = false;          ///< new connections are refused; those that exist live on
  bool silent = false;          ///< nothing passes and nobody is told (a pulled cable); connecting times out
  std::size_t chunk_bytes = 0;  ///< bytes arrive in pieces of at most this size; 0: as they were sent
  Nanoseconds delay{0};         ///< added to the network's latency
};

/// Endpoints of one process that exchange datagrams and streams on a stepped clock.
///
/// Whatever is sent waits in one queue, ordered by the time it is due and then by the order of sending, until
/// `run_until` or `deliver_due` hands it out; its arrival stamp is the time it was due. What a handler sends
/// is under way for at least 1 ns, so that two ends which answer each other cannot hold the time still.
///
/// Every address is on this machine. A socket bound to address 0 receives for every address and sends from
/// 127.0.0.1. A destroyed socket drops, a destroyed server closes its sessions and refuses, as real ones do.
/// With one seed the run is reproducible to the bit. In the steady state nothing is allocated.
class MemoryNetwork final : public Network {
 public:
  struct Config {
    Nanoseconds latency{0};  ///< from sending to arrival; with 0 it arrives at the next delivery
    std::uint64_t seed = 1;  ///< of the faults
  };

  explicit MemoryNetwork(SteppedClock& clock);
  MemoryNetwork(SteppedClock& clock, Config config);
  ~MemoryNetwork() override;

  std::unique_ptr<DatagramSocket> datagram(Endpoint local) override;
  std::unique_ptr<StreamClient> client(Endpoint remote, Endpoint local = {}) override;
  std::unique_ptr<StreamServer> server(Endpoint local) override;

  /// Moves the clock to `t`, stopping at every delivery on the way: its handler sees the time of its arrival.
  void run_until(LabTime t);
  /// Hands out what is due at or before `now` and leaves the clock alone.
  void deliver_due(LabTime now);
  /// When the next delivery is due; nothing when the network is quiet.
  [[nodiscard]] std::optional<LabTime> next_due() const;

  /// Replaces the faults on the way to `to`, for datagrams sent from now on. Address 0: whatever the address.
  void set_datagram_fault(Endpoint to, DatagramFault fault);
  /// Replaces the faults of the connections to `server`, those that exist included. Address 0 likewise.
  void set_stream_fault(Endpoint server, StreamFault fault);
  /// Shows every datagram as it is sent, before any fault of its way; nothing: nobody looks. The viewer must
  /// not send.
  using DatagramViewer = std::function<void(Endpoint from, Endpoint to, Bytes datagram, LabTime t_sent)>;
  void on_sent(DatagramViewer viewer);
  /// Breaks every connection of `server`: both ends learn that it was reset.
  void reset_streams(Endpoint server);

 private:
  struct State;
  class Socket;
  class Client;
  class Server;
  std::shared_ptr<State> state_;
};

}  // namespace motionlab
