#include "simulators/faults/faulty_wire.hpp"

#include <algorithm>
#include <deque>
#include <utility>
#include <vector>

#include "drivers/core/error.hpp"
#include "drivers/core/random.hpp"
#include "simulators/faults/datagram_path.hpp"
#include "simulators/faults/wire_faults.hpp"

namespace motionlab::faults {

struct FaultyWire::State {
  State(Network& network_, std::uint64_t seed_, std::string name_, ClockHook clock_)
      : network(network_), seed(seed_), name(std::move(name_)), clock(std::move(clock_)) {}

  /// A stream of dice for each direction of each socket.
  Random dice(std::string_view direction) {
    return {seed, name + "/" + std::string(direction) + std::to_string(++drawn)};
  }

  Network& network;
  std::uint64_t seed;
  std::string name;
  ClockHook clock;
  WireFaults faults;
  LabTime now{};
  unsigned drawn = 0;
  std::vector<Socket*> sockets;
  std::vector<Server*> servers;
};

class FaultyWire::Socket final : public DatagramSocket {
 public:
  Socket(State& wire, Endpoint local)
      : wire_(wire),
        inner_(wire.network.datagram(local)),
        out_(wire.faults, wire.dice("out"),
             [this](Bytes datagram, Endpoint to, LabTime, bool foreign) {
               return (foreign && stranger_ ? stranger_ : inner_)->send(to, datagram);
             }),
        in_(wire.faults, wire.dice("in"), [this](Bytes datagram, Endpoint from, LabTime t, bool foreign) {
          // The handler may replace itself.
          if (const auto handler = handler_) (*handler)(datagram, foreign ? other(from) : from, t);
          return Status{Done{}};
        }) {
    wire_.sockets.push_back(this);
  }
  ~Socket() override { std::erase(wire_.sockets, this); }

  Status send(Endpoint to, Bytes datagram) override { return out_.take(datagram, to, wire_.now); }
  void on_datagram(DatagramHandler handler) override {
    handler_ = handler ? std::make_shared<DatagramHandler>(std::move(handler)) : nullptr;
    if (!handler_) return inner_->on_datagram({});
    inner_->on_datagram([this](Bytes datagram, Endpoint from, LabTime t) {
      wire_.now = std::max(wire_.now, t);
      (void)in_.take(datagram, from, t);
    });
  }
  [[nodiscard]] Endpoint local() const override { return inner_->local(); }

  void step(LabTime now) {
    in_.step(now);
    out_.step(now);
  }
  /// Opens the address that foreign datagrams come from. @throws StartupError when the machine has no other
  void let_strangers_in() {
    if (!stranger_) stranger_ = wire_.network.datagram({other(inner_->local()).address, 0});
  }

 private:
  /// Somebody else than this: the next address of the loopback's 2^24, or the same host from another port.
  static Endpoint other(Endpoint endpoint) {
    constexpr std::uint32_t kLoopback = 0x7f000001;
    const std::uint32_t address = endpoint.address == 0 ? kLoopback : endpoint.address;
    if (address >> 24 == kLoopback >> 24) return {address + 1, endpoint.port};
    return {address, static_cast<std::uint16_t>(endpoint.port + 1)};
  }

  State& wire_;
  std::unique_ptr<DatagramSocket> inner_;
  std::unique_ptr<DatagramSocket> stranger_;
  std::shared_ptr<DatagramHandler> handler_;
  DatagramPath out_;
  DatagramPath in_;
};

/// Both directions of every session in two queues: what waits lets nothing overtake.
class FaultyWire::Server final : public StreamServer, public ServerEvents {
 public:
  Server(State& wire, Endpoint local)
      : wire_(wire), inner_(wire.network.server(local)), random_(wire.dice("stream")) {
    wire_.servers.push_back(this);
  }
  ~Server() override {
    inner_->on_event(nullptr);
    std::erase(wire_.servers, this);
  }

  void on_event(ServerEvents* events) override {
    events_ = events;
    inner_->on_event(events == nullptr ? nullptr : this);
  }
  [[nodiscard]] Endpoint local() const override { return inner_->local(); }

  Status send(SessionId session, Bytes bytes) override {
    if (passes(out_)) return inner_->send(session, bytes);
    if (waiting_bytes(out_, session) + bytes.size() > kStreamQueueBytesMax) {
      return Fault{Reason::transport, "the peer has not taken the last MiB; send less"};
    }
    push(out_, {Kind::bytes, session, {}, {}, {bytes.begin(), bytes.end()}});
    return Done{};
  }
  void close(SessionId session) override {
    std::erase_if(in_, [session](const Parcel& parcel) { return parcel.session == session; });
    if (passes(out_)) return inner_->close(session);
    closing_.push_back(session);
    push(out_, {Kind::closed, session, {}, {}, {}});
  }

  void on_accepted(SessionId session, Endpoint from, LabTime t) override {
    hear({Kind::accepted, session, from, {}, {}}, t);
  }
  void on_bytes(SessionId session, Bytes bytes, LabTime t) override {
    if (passes(in_) && !is_closing(session)) {
      wire_.now = std::max(wire_.now, t);
      if (events_ != nullptr) events_->on_bytes(session, bytes, t);
      return;
    }
    if (waiting_bytes(in_, session) + bytes.size() > kStreamQueueBytesMax) {
      inner_->close(session);  // no kernel would have taken it either
      return hear({Kind::closed, session, {}, {}, {}}, t);
    }
    hear({Kind::bytes, session, {}, {}, {bytes.begin(), bytes.end()}}, t);
  }
  void on_closed(SessionId session, LabTime t) override { hear({Kind::closed, session, {}, {}, {}}, t); }

  void step(LabTime now) {
    while (const auto parcel = take(in_, now)) tell(*parcel, now);
    while (const auto parcel = take(out_, now)) {
      if (parcel->kind == Kind::bytes) {
        (void)inner_->send(parcel->session, parcel->bytes);
      } else {
        inner_->close(parcel->session);
        std::erase(closing_, parcel->session);
      }
    }
  }

 private:
  enum class Kind : std::uint8_t { accepted, bytes, closed };
  struct Parcel {
    Kind kind{};
    SessionId session = 0;
    Endpoint from{};
    LabTime due{};
    ByteBuffer bytes;
  };
  using Queue = std::deque<Parcel>;

  [[nodiscard]] bool passes(const Queue& queue) const {
    return wire_.faults.spare_streams() && queue.empty();
  }
  [[nodiscard]] bool is_closing(SessionId session) const {
    return std::find(closing_.begin(), closing_.end(), session) != closing_.end();
  }
  static std::size_t waiting_bytes(const Queue& queue, SessionId session) {
    std::size_t sum = 0;
    for (const Parcel& parcel : queue) sum += parcel.session == session ? parcel.bytes.size() : 0;
    return sum;
  }
  void push(Queue& queue, Parcel parcel) {
    parcel.due = wire_.now + Nanoseconds{static_cast<std::int64_t>(
                                 static_cast<double>(wire_.faults.jitter.count()) * random_.uniform())};
    if (!queue.empty()) parcel.due = std::max(parcel.due, queue.back().due);
    queue.push_back(std::move(parcel));
  }
  std::optional<Parcel> take(Queue& queue, LabTime now) {
    if (wire_.faults.cut || queue.empty() || queue.front().due > now) return std::nullopt;
    Parcel parcel = std::move(queue.front());
    queue.pop_front();
    return parcel;
  }
  void hear(Parcel parcel, LabTime t) {
    wire_.now = std::max(wire_.now, t);
    if (is_closing(parcel.session)) return;  // the device has closed it already
    if (passes(in_)) return tell(parcel, t);
    push(in_, std::move(parcel));
  }
  void tell(const Parcel& parcel, LabTime t) {
    if (events_ == nullptr) return;
    switch (parcel.kind) {
      case Kind::accepted:
        return events_->on_accepted(parcel.session, parcel.from, t);
      case Kind::bytes:
        return events_->on_bytes(parcel.session, parcel.bytes, t);
      case Kind::closed:
        return events_->on_closed(parcel.session, t);
    }
  }

  State& wire_;
  std::unique_ptr<StreamServer> inner_;
  Random random_;
  ServerEvents* events_ = nullptr;
  Queue in_, out_;
  std::vector<SessionId> closing_;  ///< by the device, and the peer does not know yet
};

FaultyWire::FaultyWire(Network& network, std::uint64_t seed, std::string name, ClockHook clock)
    : state_(std::make_unique<State>(network, seed, std::move(name), std::move(clock))) {}
FaultyWire::~FaultyWire() = default;

std::unique_ptr<DatagramSocket> FaultyWire::datagram(Endpoint local) {
  return std::make_unique<Socket>(*state_, local);
}
std::unique_ptr<StreamServer> FaultyWire::server(Endpoint local) {
  return std::make_unique<Server>(*state_, local);
}

Status FaultyWire::set_fault(std::string_view name, bool active, double value) {
  if (!WireFaults::knows(name)) {
    return Fault{
        Reason::refused,
        "unknown fault; a wire knows: cut loss burst jitter reorder duplicate corrupt truncate foreign "
        "clock-jump"};
  }
  if (name == "clock-jump" && !state_->clock) {
    return Fault{Reason::refused, "no clock-jump here: what this device says carries no clock"};
  }
  if (state_->sockets.empty() && !WireFaults::passes_tcp(name)) {
    return Fault{Reason::refused,
                 "not on a TCP connection, which repeats what is lost, drops what is damaged or foreign and "
                 "puts in order what overtook; it knows: cut jitter clock-jump"};
  }
  if (name == "foreign" && active) {
    try {
      for (Socket* const socket : state_->sockets) socket->let_strangers_in();
    } catch (const StartupError&) {
      return Fault{Reason::refused, "no foreign datagrams: this machine has no second address to send from"};
    }
  }
  state_->faults.set(name, active, value);
  if (name == "clock-jump") state_->clock(state_->faults.clock_jump);
  return Done{};
}

void FaultyWire::step(LabTime now) {
  state_->now = std::max(state_->now, now);
  for (Socket* const socket : state_->sockets) socket->step(now);
  for (Server* const server : state_->servers) server->step(now);
}

}  // namespace motionlab::faults
