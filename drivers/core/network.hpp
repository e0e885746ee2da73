/// @file  Transports behind one interface: the Boost.Asio network (real sockets) and the memory network
/// (lockstep, pair tests) are interchangeable. Who feeds bytes to a driver or a device is decided by the
/// assembly alone.
///
/// Everything here is used from one thread, the one that runs the network. Handlers are called on that
/// thread, never from inside `send`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/endpoint.hpp"
#include "drivers/core/result.hpp"
#include "drivers/core/time.hpp"

namespace motionlab {

/// No datagram over IPv4 is longer.
inline constexpr std::size_t kDatagramBytesMax = 65507;
/// What a stream queues for a peer that does not take it; a `send` beyond is refused whole.
inline constexpr std::size_t kStreamQueueBytesMax = std::size_t{1} << 20;
/// After this a peer that does not answer has not been reached.
inline constexpr Nanoseconds kConnectTimeout = 2s;

/// Why a stream closed, in the words of `StreamEvents::on_closed`. Every network uses the same.
namespace close_reason {
inline constexpr std::string_view kRefused = "connection refused";
inline constexpr std::string_view kTimedOut = "timed out";
inline constexpr std::string_view kClosedByPeer = "closed by the peer";
inline constexpr std::string_view kReset = "connection reset";
inline constexpr std::string_view kUnreachable = "host unreachable";
inline constexpr std::string_view kLocalAddress = "the local address is in use or not on this machine";
}  // namespace close_reason

/// Where datagrams go. What a driver or a device that speaks UDP is given.
class DatagramOut {
 public:
  virtual ~DatagramOut() = default;
  /// Sends one datagram, whole or not at all. A fault is counted by the caller; nothing is queued or
  /// repeated.
  virtual Status send(Endpoint to, Bytes datagram) = 0;
};

using DatagramHandler = std::function<void(Bytes datagram, Endpoint from, LabTime t_received)>;

/// A bound UDP port.
class DatagramSocket : public DatagramOut {
 public:
  /// Sets who gets the datagrams. Before this is called they are dropped.
  virtual void on_datagram(DatagramHandler handler) = 0;
  /// The address it is really bound to (a configured port 0 has become a real one).
  [[nodiscard]] virtual Endpoint local() const = 0;
};

/// A client's byte stream, as its driver sees it. The driver decides when to (re)connect.
class StreamOut {
 public:
  virtual ~StreamOut() = default;
  /// Begins to connect; `on_open` or `on_closed` follows. A stream that is already open is closed first,
  /// silently.
  virtual void open() = 0;
  /// Queues bytes behind those not yet sent. A fault when not open, or when the peer has not taken the last 1
  /// MiB.
  virtual Status send(Bytes bytes) = 0;
  /// Closes. No further handler is called until the next `open`.
  virtual void close() = 0;
};

/// What happens on a client's stream.
class StreamEvents {
 public:
  virtual ~StreamEvents() = default;
  virtual void on_open(LabTime t) = 0;
  virtual void on_bytes(Bytes bytes, LabTime t_received) = 0;
  /// Connecting failed, the peer closed, or the connection broke. `why` is a short sentence.
  virtual void on_closed(std::string_view why, LabTime t) = 0;
};

class StreamClient : public StreamOut {
 public:
  virtual void on_event(StreamEvents* events) = 0;
};

/// One accepted connection of a server; numbers are never used twice in a run.
using SessionId = std::uint32_t;

/// How a server's device answers.
class ServerOut {
 public:
  virtual ~ServerOut() = default;
  /// Queues bytes for one session. A fault when it is gone, or when the peer has not taken the last 1 MiB.
  virtual Status send(SessionId session, Bytes bytes) = 0;
  /// Closes one session; `on_closed` is not called for it.
  virtual void close(SessionId session) = 0;
};

/// What happens on a server's sessions.
class ServerEvents {
 public:
  virtual ~ServerEvents() = default;
  virtual void on_accepted(SessionId session, Endpoint from, LabTime t) = 0;
  virtual void on_bytes(SessionId session, Bytes bytes, LabTime t_received) = 0;
  virtual void on_closed(SessionId session, LabTime t) = 0;
};

class StreamServer : public ServerOut {
 public:
  virtual void on_event(ServerEvents* events) = 0;
  [[nodiscard]] virtual Endpoint local() const = 0;
};

/// Makes transports. Handlers must outlive the transport, or be reset first.
class Network {
 public:
  virtual ~Network() = default;
  /// Binds a UDP port. @throws StartupError naming the address and what to do (port in use, no such address).
  virtual std::unique_ptr<DatagramSocket> datagram(Endpoint local) = 0;
  /// A TCP client of `remote`, from `local` (address 0: any). Opens nothing yet.
  virtual std::unique_ptr<StreamClient> client(Endpoint remote, Endpoint local = {}) = 0;
  /// Listens. @throws StartupError likewise.
  virtual std::unique_ptr<StreamServer> server(Endpoint local) = 0;
};

}  // namespace motionlab
