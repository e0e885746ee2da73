#include "drivers/core/memory_network.hpp"

#include <algorithm>
#include <cassert>
#include <deque>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/core/error.hpp"
#include "drivers/core/random.hpp"

namespace motionlab {
namespace {

constexpr std::uint32_t kLoopback = 0x7f000001;
constexpr std::uint16_t kFirstEphemeralPort = 49152;

bool covers(const Endpoint& rule, const Endpoint& endpoint) {
  return rule.port == endpoint.port && (rule.address == 0 || rule.address == endpoint.address);
}

template <class Fault>
using Faults = std::vector<std::pair<Endpoint, Fault>>;

template <class Fault>
Fault* find_fault(Faults<Fault>& faults, const Endpoint& endpoint) {
  for (auto& [rule, fault] : faults) {
    if (covers(rule, endpoint)) return &fault;
  }
  return nullptr;
}

template <class Fault, class Value>
void set_fault(Faults<Fault>& faults, const Endpoint& endpoint, Value value) {
  for (auto& [rule, fault] : faults) {
    if (rule == endpoint) {
      fault = Fault{std::move(value)};
      return;
    }
  }
  faults.emplace_back(endpoint, Fault{std::move(value)});
}

/// The faults of one destination, and what they need to remember.
struct DatagramPath {
  DatagramFault fault{};
  LabTime last_due{};
};

enum class Kind : std::uint8_t {
  datagram,
  connect,     ///< client to server
  opened,      ///< server to client
  to_server,   ///< bytes
  to_client,   ///< bytes
  end_server,  ///< the server's side of the connection ends
  end_client,  ///< the client's side of the connection ends
};

enum class Phase : std::uint8_t { connecting, open, closed };

}  // namespace

struct MemoryNetwork::State {
  struct Connection {
    Endpoint client;
    Endpoint server;
    Client* client_end = nullptr;  ///< null once the client let go
    Server* server_end = nullptr;  ///< null until accepted and once the server let go
    Phase phase = Phase::connecting;
    SessionId session = 0;
    LabTime opened_at{};
    LabTime due_at_server{};
    LabTime due_at_client{};
    std::size_t waiting_at_server = 0;  ///< bytes under way to the server
    std::size_t waiting_at_client = 0;
    bool torn = false;  ///< something vanished: the stream can never be whole again
  };

  struct Parcel {
    Kind kind{};
    Endpoint from;
    Endpoint to;
    std::shared_ptr<Connection> connection;
    std::string_view why;
    ByteBuffer bytes;
  };

  /// One element of the heap; the earliest is on top.
  struct Due {
    LabTime at;
    std::uint64_t order;
    std::uint32_t parcel;
    bool operator<(const Due& other) const noexcept {
      return at != other.at ? at > other.at : order > other.order;
    }
  };

  State(SteppedClock& c, Config configured) : clock(c), config(configured), random(configured.seed) {}

  /// When something that is sent now leaves.
  LabTime sent_at() const {
    return handing_out ? std::max(clock.now(), *handing_out) + Nanoseconds{1} : clock.now();
  }

  Parcel& queue(LabTime due, Kind kind) {
    std::uint32_t index = 0;
    if (free.empty()) {
      index = static_cast<std::uint32_t>(parcels.size());
      parcels.emplace_back();
    } else {
      index = free.back();
      free.pop_back();
    }
    heap.push_back({due, next_order++, index});
    std::push_heap(heap.begin(), heap.end());
    parcels[index].kind = kind;
    return parcels[index];
  }

  void send_datagram(Endpoint from, Endpoint to, Bytes bytes);
  void queue_datagram(LabTime due, Endpoint from, Endpoint to, Bytes bytes, bool corrupt);

  void queue_stream(const std::shared_ptr<Connection>& connection, Kind kind, std::string_view why = {},
                    Bytes bytes = {});
  Status send_stream(const std::shared_ptr<Connection>& connection, Kind kind, Bytes bytes);

  void hand_out_top();
  void deliver(Parcel& parcel, LabTime t);
  void deliver_stream(Parcel& parcel, LabTime t);
  void accept(const std::shared_ptr<Connection>& connection, LabTime t);

  Socket* find_socket(const Endpoint& to) const;
  Server* find_server(const Endpoint& to) const;
  std::uint16_t ephemeral_port() {
    const std::uint16_t port = next_port++;
    if (next_port == 0) next_port = kFirstEphemeralPort;
    return port;
  }
  template <class Bound>
  Endpoint bind(Endpoint wanted, const std::vector<Bound*>& others, const char* what);

  SteppedClock& clock;
  Config config;
  Random random;
  std::optional<LabTime> handing_out;
  std::vector<Due> heap;
  std::deque<Parcel> parcels;
  std::vector<std::uint32_t> free;
  std::uint64_t next_order = 0;
  SessionId next_session = 1;
  std::uint16_t next_port = kFirstEphemeralPort;
  std::vector<Socket*> sockets;
  std::vector<Server*> servers;
  DatagramViewer viewer;
  Faults<DatagramPath> datagram_faults;
  Faults<StreamFault> stream_faults;
  std::vector<std::weak_ptr<Connection>> connections;  ///< for `reset_streams`
};

class MemoryNetwork::Socket final : public DatagramSocket {
 public:
  Socket(std::shared_ptr<State> state, Endpoint bound) : state_(std::move(state)), local_(bound) {
    state_->sockets.push_back(this);
  }
  ~Socket() override { std::erase(state_->sockets, this); }

  Status send(Endpoint to, Bytes datagram) override {
    if (datagram.size() > kDatagramBytesMax) {
      return Fault{Reason::too_long, "a datagram carries at most 65507 bytes; send less"};
    }
    state_->send_datagram({local_.address == 0 ? kLoopback : local_.address, local_.port}, to, datagram);
    return Done{};
  }
  void on_datagram(DatagramHandler handler) override {
    handler_ = handler ? std::make_shared<DatagramHandler>(std::move(handler)) : nullptr;
  }
  [[nodiscard]] Endpoint local() const override { return local_; }

  /// Kept by whoever calls it, so that a handler may replace itself or destroy the socket.
  [[nodiscard]] std::shared_ptr<DatagramHandler> handler() const { return handler_; }

 private:
  std::shared_ptr<State> state_;
  Endpoint local_;
  std::shared_ptr<DatagramHandler> handler_;
};

class MemoryNetwork::Client final : public StreamClient {
 public:
  Client(std::shared_ptr<State> state, Endpoint remote, Endpoint local)
      : state_(std::move(state)), remote_(remote), local_(local) {
    if (local_.address == 0) local_.address = kLoopback;
  }
  ~Client() override { close(); }

  void open() override {
    close();
    connection_ = std::make_shared<State::Connection>();
    connection_->client = local_;
    if (local_.port == 0) connection_->client.port = state_->ephemeral_port();
    connection_->server = remote_;
    connection_->client_end = this;
    connection_->opened_at = state_->sent_at();
    std::erase_if(state_->connections, [](const auto& weak) { return weak.expired(); });
    state_->connections.push_back(connection_);
    state_->queue_stream(connection_, Kind::connect);
  }
  Status send(Bytes bytes) override {
    if (!connection_ || connection_->phase != Phase::open) {
      return Fault{Reason::transport, "the stream is not open; wait for on_open"};
    }
    return state_->send_stream(connection_, Kind::to_server, bytes);
  }
  void close() override {
    if (!connection_) return;
    connection_->client_end = nullptr;
    state_->queue_stream(connection_, Kind::end_server);
    connection_.reset();
  }
  void on_event(StreamEvents* events) override { events_ = events; }

  void opened(LabTime t) {
    connection_->phase = Phase::open;
    if (events_) events_->on_open(t);
  }
  void bytes(Bytes arrived, LabTime t) {
    if (events_) events_->on_bytes(arrived, t);
  }
  void ended(std::string_view why, LabTime t) {
    connection_->client_end = nullptr;
    connection_.reset();
    if (events_) events_->on_closed(why, t);
  }

 private:
  std::shared_ptr<State> state_;
  Endpoint remote_;
  Endpoint local_;
  std::shared_ptr<State::Connection> connection_;
  StreamEvents* events_ = nullptr;
};

class MemoryNetwork::Server final : public StreamServer {
 public:
  Server(std::shared_ptr<State> state, Endpoint bound) : state_(std::move(state)), local_(bound) {
    state_->servers.push_back(this);
  }
  ~Server() override {
    std::erase(state_->servers, this);
    while (!sessions_.empty()) close(sessions_.begin()->first);
  }

  Status send(SessionId session, Bytes bytes) override {
    const auto found = sessions_.find(session);
    if (found == sessions_.end()) return Fault{Reason::transport, "the session is gone"};
    return state_->send_stream(found->second, Kind::to_client, bytes);
  }
  void close(SessionId session) override {
    const auto found = sessions_.find(session);
    if (found == sessions_.end()) return;
    const auto connection = std::move(found->second);
    sessions_.erase(found);
    connection->server_end = nullptr;
    state_->queue_stream(connection, Kind::end_client, close_reason::kClosedByPeer);
  }
  void on_event(ServerEvents* events) override { events_ = events; }
  [[nodiscard]] Endpoint local() const override { return local_; }

  void accepted(const std::shared_ptr<State::Connection>& connection, LabTime t) {
    connection->server_end = this;
    sessions_.emplace(connection->session, connection);
    if (events_) events_->on_accepted(connection->session, connection->client, t);
  }
  void bytes(SessionId session, Bytes arrived, LabTime t) {
    if (events_) events_->on_bytes(session, arrived, t);
  }
  void ended(SessionId session, LabTime t) {
    sessions_.erase(session);
    if (events_) events_->on_closed(session, t);
  }

 private:
  std::shared_ptr<State> state_;
  Endpoint local_;
  std::map<SessionId, std::shared_ptr<State::Connection>> sessions_;
  ServerEvents* events_ = nullptr;
};

MemoryNetwork::Socket* MemoryNetwork::State::find_socket(const Endpoint& to) const {
  for (Socket* socket : sockets) {
    if (covers(socket->local(), to)) return socket;
  }
  return nullptr;
}

MemoryNetwork::Server* MemoryNetwork::State::find_server(const Endpoint& to) const {
  for (Server* server : servers) {
    if (covers(server->local(), to)) return server;
  }
  return nullptr;
}

template <class Bound>
Endpoint MemoryNetwork::State::bind(Endpoint wanted, const std::vector<Bound*>& others, const char* what) {
  const auto taken = [&](const Endpoint& endpoint) {
    return std::any_of(others.begin(), others.end(), [&](const Bound* other) {
      return covers(other->local(), endpoint) || covers(endpoint, other->local());
    });
  };
  if (wanted.port == 0) {
    do {
      wanted.port = ephemeral_port();
    } while (taken(wanted));
  } else if (taken(wanted)) {
    throw StartupError(std::string("cannot ") + what + " on " + to_string(wanted) +
                       ": the port is in use; configure another one");
  }
  return wanted;
}

void MemoryNetwork::State::send_datagram(Endpoint from, Endpoint to, Bytes bytes) {
  if (to.address == 0) to.address = kLoopback;
  if (viewer) viewer(from, to, bytes, sent_at());
  const LabTime due = sent_at() + config.latency;
  DatagramPath* path = find_fault(datagram_faults, to);
  if (!path) return queue_datagram(due, from, to, bytes, false);

  const DatagramFault& fault = path->fault;
  if (fault.silent || random.chance(fault.loss)) return;
  const int copies = random.chance(fault.duplicate) ? 2 : 1;
  for (int i = 0; i < copies; ++i) {
    LabTime at = due + fault.delay;
    if (fault.jitter > 0ns) at += from_seconds(random.uniform() * seconds(fault.jitter));
    at = std::max(at, path->last_due);
    if (random.chance(fault.reorder)) {
      at += fault.reorder_by;
    } else {
      path->last_due = at;
    }
    queue_datagram(at, from, to, bytes, random.chance(fault.corrupt));
  }
}

void MemoryNetwork::State::queue_datagram(LabTime due, Endpoint from, Endpoint to, Bytes bytes,
                                          bool corrupt) {
  Parcel& parcel = queue(due, Kind::datagram);
  parcel.from = from;
  parcel.to = to;
  parcel.bytes.assign(bytes.begin(), bytes.end());
  if (corrupt && !bytes.empty()) {
    auto& byte = parcel.bytes[random.below(static_cast<std::uint32_t>(bytes.size()))];
    byte = static_cast<std::uint8_t>(byte ^ (1 + random.below(255)));
  }
}

void MemoryNetwork::State::queue_stream(const std::shared_ptr<Connection>& connection, Kind kind,
                                        std::string_view why, Bytes bytes) {
  const bool to_client = kind == Kind::opened || kind == Kind::to_client || kind == Kind::end_client;
  LabTime& last = to_client ? connection->due_at_client : connection->due_at_server;
  const StreamFault* fault = find_fault(stream_faults, connection->server);
  last = std::max(last, sent_at() + config.latency + (fault ? fault->delay : 0ns));
  Parcel& parcel = queue(last, kind);
  parcel.connection = connection;
  parcel.why = why;
  parcel.bytes.assign(bytes.begin(), bytes.end());
}

Status MemoryNetwork::State::send_stream(const std::shared_ptr<Connection>& connection, Kind kind,
                                         Bytes bytes) {
  std::size_t& waiting =
      kind == Kind::to_client ? connection->waiting_at_client : connection->waiting_at_server;
  if (waiting + bytes.size() > kStreamQueueBytesMax) {
    return Fault{Reason::transport, "the peer does not take its bytes; close and open again"};
  }
  waiting += bytes.size();
  const StreamFault* fault = find_fault(stream_faults, connection->server);
  const std::size_t chunk = fault && fault->chunk_bytes > 0 ? fault->chunk_bytes : bytes.size();
  while (!bytes.empty()) {
    const std::size_t n = std::min(chunk, bytes.size());
    queue_stream(connection, kind, {}, bytes.first(n));
    bytes = bytes.subspan(n);
  }
  return Done{};
}

void MemoryNetwork::State::hand_out_top() {
  assert(!handing_out && "a handler must not run the network");
  const Due due = heap.front();
  std::pop_heap(heap.begin(), heap.end());
  heap.pop_back();
  Parcel& parcel = parcels[due.parcel];
  handing_out = due.at;
  deliver(parcel, due.at);
  handing_out.reset();
  parcel.connection.reset();
  free.push_back(due.parcel);
}

void MemoryNetwork::State::deliver(Parcel& parcel, LabTime t) {
  if (parcel.kind != Kind::datagram) return deliver_stream(parcel, t);
  const Socket* socket = find_socket(parcel.to);
  if (!socket) return;
  if (const auto handler = socket->handler()) (*handler)(parcel.bytes, parcel.from, t);
}

void MemoryNetwork::State::deliver_stream(Parcel& parcel, LabTime t) {
  const auto& connection = parcel.connection;
  const bool from_client =
      parcel.kind == Kind::connect || parcel.kind == Kind::to_server || parcel.kind == Kind::end_server;
  const StreamFault* fault = find_fault(stream_faults, connection->server);

  if (fault && fault->silent && parcel.why != close_reason::kTimedOut) {
    if (connection->phase == Phase::connecting && !connection->torn) {
      Parcel& timeout = queue(connection->opened_at + kConnectTimeout, Kind::end_client);
      timeout.connection = connection;
      timeout.why = close_reason::kTimedOut;
    }
    connection->torn = true;
    return;
  }
  if (connection->torn && parcel.why != close_reason::kTimedOut && parcel.why != close_reason::kReset) {
    // The cable is back, but the peer knows nothing of these bytes: it answers with a reset.
    queue_stream(connection, from_client ? Kind::end_client : Kind::end_server, close_reason::kReset);
    return;
  }

  switch (parcel.kind) {
    case Kind::connect:
      return accept(connection, t);
    case Kind::opened:
      if (connection->client_end) connection->client_end->opened(t);
      return;
    case Kind::to_server:
      connection->waiting_at_server -= parcel.bytes.size();
      if (connection->server_end) connection->server_end->bytes(connection->session, parcel.bytes, t);
      return;
    case Kind::to_client:
      connection->waiting_at_client -= parcel.bytes.size();
      if (connection->client_end) connection->client_end->bytes(parcel.bytes, t);
      return;
    case Kind::end_server:
      connection->phase = Phase::closed;
      if (Server* server = std::exchange(connection->server_end, nullptr)) {
        server->ended(connection->session, t);
      }
      return;
    case Kind::end_client:
      connection->phase = Phase::closed;
      if (connection->client_end) connection->client_end->ended(parcel.why, t);
      return;
    case Kind::datagram:
      return;
  }
}

void MemoryNetwork::State::accept(const std::shared_ptr<Connection>& connection, LabTime t) {
  if (!connection->client_end) return;
  Server* server = find_server(connection->server);
  const StreamFault* fault = find_fault(stream_faults, connection->server);
  if (!server || (fault && fault->refuse)) {
    return queue_stream(connection, Kind::end_client, close_reason::kRefused);
  }
  connection->session = next_session++;
  queue_stream(connection, Kind::opened);
  server->accepted(connection, t);
}

MemoryNetwork::MemoryNetwork(SteppedClock& clock) : MemoryNetwork(clock, Config{}) {}
MemoryNetwork::MemoryNetwork(SteppedClock& clock, Config config)
    : state_(std::make_shared<State>(clock, config)) {}
MemoryNetwork::~MemoryNetwork() = default;

std::unique_ptr<DatagramSocket> MemoryNetwork::datagram(Endpoint local) {
  return std::make_unique<Socket>(state_, state_->bind(local, state_->sockets, "receive datagrams"));
}

std::unique_ptr<StreamClient> MemoryNetwork::client(Endpoint remote, Endpoint local) {
  return std::make_unique<Client>(state_, remote, local);
}

std::unique_ptr<StreamServer> MemoryNetwork::server(Endpoint local) {
  return std::make_unique<Server>(state_, state_->bind(local, state_->servers, "listen"));
}

void MemoryNetwork::run_until(LabTime t) {
  while (!state_->heap.empty() && state_->heap.front().at <= t) {
    state_->clock.set(std::max(state_->clock.now(), state_->heap.front().at));
    state_->hand_out_top();
  }
  state_->clock.set(std::max(state_->clock.now(), t));
}

void MemoryNetwork::deliver_due(LabTime now) {
  while (!state_->heap.empty() && state_->heap.front().at <= now) state_->hand_out_top();
}

std::optional<LabTime> MemoryNetwork::next_due() const {
  if (state_->heap.empty()) return std::nullopt;
  return state_->heap.front().at;
}

void MemoryNetwork::set_datagram_fault(Endpoint to, DatagramFault fault) {
  set_fault(state_->datagram_faults, to, fault);
}

void MemoryNetwork::on_sent(DatagramViewer viewer) {
  state_->viewer = std::move(viewer);
}

void MemoryNetwork::set_stream_fault(Endpoint server, StreamFault fault) {
  set_fault(state_->stream_faults, server, fault);
}

void MemoryNetwork::reset_streams(Endpoint server) {
  for (const auto& weak : state_->connections) {
    const auto connection = weak.lock();
    if (!connection || !covers(server, connection->server)) continue;
    state_->queue_stream(connection, Kind::end_client, close_reason::kReset);
    state_->queue_stream(connection, Kind::end_server, close_reason::kReset);
  }
}

}  // namespace motionlab
