#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <map>
#include <utility>

#include "drivers/core/asio_detail.hpp"
#include "drivers/core/asio_stream.hpp"

namespace motionlab::asio_detail {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

/// A pause when accepting fails (no file descriptors left), so that it does not spin.
constexpr auto kAcceptPause = 100ms;

/// The listening socket. Lives until its last pending operation has ended.
class Listener : public std::enable_shared_from_this<Listener> {
 public:
  class Owner {
   public:
    virtual ~Owner() = default;
    virtual void accepted(tcp::socket socket, Endpoint from) = 0;
  };

  Listener(boost::asio::io_context& io, Owner& owner) : acceptor_(io), pause_(io), owner_(&owner) {}

  void bind(const Endpoint& local) {
    error_code error;
    acceptor_.open(tcp::v4(), error);
    if (!error) acceptor_.set_option(tcp::acceptor::reuse_address(true), error);
    if (!error) acceptor_.bind(to_asio<tcp>(local), error);
    if (!error) acceptor_.listen(boost::asio::socket_base::max_listen_connections, error);
    if (error) throw_bind_error("listen for connections", local, error);
  }

  [[nodiscard]] Endpoint local() const { return from_asio(acceptor_.local_endpoint()); }

  void accept() {
    acceptor_.async_accept(peer_, [self = shared_from_this()](const error_code& error, tcp::socket socket) {
      if (!self->owner_) return;
      if (error) return self->accept_after_a_pause();
      self->owner_->accepted(std::move(socket), from_asio(self->peer_));
      if (self->owner_) self->accept();
    });
  }

  void close() {
    owner_ = nullptr;
    error_code ignored;
    acceptor_.close(ignored);
    pause_.cancel();
  }

 private:
  void accept_after_a_pause() {
    pause_.expires_after(kAcceptPause);
    pause_.async_wait([self = shared_from_this()](const error_code&) {
      if (self->owner_) self->accept();
    });
  }

  tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  tcp::endpoint peer_;
  Owner* owner_;
};

class AsioServer final : public StreamServer, public Listener::Owner {
 public:
  AsioServer(boost::asio::io_context& io, const Clock& clock, Endpoint local,
             std::shared_ptr<SessionId> next_session)
      : clock_(clock),
        next_session_(std::move(next_session)),
        listener_(std::make_shared<Listener>(io, *this)) {
    listener_->bind(local);
    listener_->accept();
  }
  ~AsioServer() override { listener_->close(); }

  Status send(SessionId session, Bytes bytes) override {
    const auto found = sessions_.find(session);
    if (found == sessions_.end()) return Fault{Reason::transport, "the session is gone"};
    return found->second->send(bytes);
  }
  void close(SessionId session) override { sessions_.erase(session); }
  void on_event(ServerEvents* events) override { events_ = events; }
  [[nodiscard]] Endpoint local() const override { return listener_->local(); }

 private:
  class Session final : public AsioStream::Owner {
   public:
    Session(AsioServer& server, SessionId id, tcp::socket socket)
        : server_(server), id_(id), stream_(std::make_shared<AsioStream>(std::move(socket), *this)) {}
    ~Session() override { stream_->close(); }

    void start() { stream_->start(); }
    Status send(Bytes bytes) { return stream_->send(bytes); }

   private:
    void bytes_arrived(Bytes bytes) override { server_.bytes_arrived(id_, bytes); }
    void stream_broke(std::string_view) override { server_.session_broke(id_); }

    AsioServer& server_;
    SessionId id_;
    std::shared_ptr<AsioStream> stream_;
  };

  void accepted(tcp::socket socket, Endpoint from) override {
    const SessionId id = (*next_session_)++;
    const auto [session, inserted] =
        sessions_.emplace(id, std::make_unique<Session>(*this, id, std::move(socket)));
    session->second->start();
    if (events_) events_->on_accepted(id, from, clock_.now());
  }
  void bytes_arrived(SessionId id, Bytes bytes) {
    if (events_) events_->on_bytes(id, bytes, clock_.now());
  }
  /// Ends the session that calls it.
  void session_broke(SessionId id) {
    sessions_.erase(id);
    if (events_) events_->on_closed(id, clock_.now());
  }

  const Clock& clock_;
  std::shared_ptr<SessionId> next_session_;
  std::shared_ptr<Listener> listener_;
  std::map<SessionId, std::unique_ptr<Session>> sessions_;
  ServerEvents* events_ = nullptr;
};

}  // namespace

std::unique_ptr<StreamServer> make_stream_server(boost::asio::io_context& io, const Clock& clock,
                                                 Endpoint local, std::shared_ptr<SessionId> next_session) {
  return std::make_unique<AsioServer>(io, clock, local, std::move(next_session));
}

}  // namespace motionlab::asio_detail
