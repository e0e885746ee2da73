#include <boost/asio/error.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <utility>

#include "drivers/core/asio_detail.hpp"
#include "drivers/core/asio_stream.hpp"

namespace motionlab::asio_detail {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

/// One attempt to connect. Says exactly once how it went, unless it is abandoned.
class Attempt : public std::enable_shared_from_this<Attempt> {
 public:
  class Owner {
   public:
    virtual ~Owner() = default;
    virtual void connected(tcp::socket socket) = 0;
    virtual void not_connected(std::string_view why) = 0;
  };

  Attempt(boost::asio::io_context& io, Owner& owner) : socket_(io), timer_(io), owner_(&owner) {}

  void start(const Endpoint& remote, const Endpoint& local) {
    error_code error;
    socket_.open(tcp::v4(), error);
    if (!error && local != Endpoint{}) socket_.bind(to_asio<tcp>(local), error);
    if (error) {
      boost::asio::post(socket_.get_executor(), [self = shared_from_this(), error] { self->finish(error); });
      return;
    }
    timer_.expires_after(kConnectTimeout);
    timer_.async_wait([self = shared_from_this()](const error_code& cancelled) {
      if (!cancelled) self->finish(boost::asio::error::timed_out);
    });
    socket_.async_connect(to_asio<tcp>(remote),
                          [self = shared_from_this()](const error_code& result) { self->finish(result); });
  }

  void abandon() {
    owner_ = nullptr;
    error_code ignored;
    socket_.close(ignored);
    timer_.cancel();
  }

 private:
  void finish(error_code error) {
    Owner* const owner = std::exchange(owner_, nullptr);
    if (!owner) return;
    timer_.cancel();
    if (!error && connected_to_itself()) error = boost::asio::error::connection_refused;
    if (!error) return owner->connected(std::move(socket_));
    error_code ignored;
    socket_.close(ignored);
    owner->not_connected(why_closed(error));
  }

  /// When nobody listens on a port of this machine from which the kernel takes ports for outgoing
  /// connections, it may by chance pick that very port, and TCP then connects the socket to itself.
  [[nodiscard]] bool connected_to_itself() const {
    error_code ignored;
    return socket_.local_endpoint(ignored) == socket_.remote_endpoint(ignored);
  }

  tcp::socket socket_;
  boost::asio::steady_timer timer_;
  Owner* owner_;
};

class AsioClient final : public StreamClient, public Attempt::Owner, public AsioStream::Owner {
 public:
  AsioClient(boost::asio::io_context& io, const Clock& clock, Endpoint remote, Endpoint local)
      : io_(io), clock_(clock), remote_(remote), local_(local) {}
  ~AsioClient() override { close(); }

  void open() override {
    close();
    attempt_ = std::make_shared<Attempt>(io_, *this);
    attempt_->start(remote_, local_);
  }

  Status send(Bytes bytes) override {
    if (!stream_) return Fault{Reason::transport, "the stream is not open; wait for on_open"};
    return stream_->send(bytes);
  }

  void close() override {
    if (const auto attempt = std::exchange(attempt_, nullptr)) attempt->abandon();
    if (const auto stream = std::exchange(stream_, nullptr)) stream->close();
  }

  void on_event(StreamEvents* events) override { events_ = events; }

 private:
  void connected(tcp::socket socket) override {
    attempt_.reset();
    stream_ = std::make_shared<AsioStream>(std::move(socket), *this);
    stream_->start();
    if (events_) events_->on_open(clock_.now());
  }
  void not_connected(std::string_view why) override {
    attempt_.reset();
    if (events_) events_->on_closed(why, clock_.now());
  }
  void bytes_arrived(Bytes bytes) override {
    if (events_) events_->on_bytes(bytes, clock_.now());
  }
  void stream_broke(std::string_view why) override {
    stream_.reset();
    if (events_) events_->on_closed(why, clock_.now());
  }

  boost::asio::io_context& io_;
  const Clock& clock_;
  Endpoint remote_;
  Endpoint local_;
  std::shared_ptr<Attempt> attempt_;
  std::shared_ptr<AsioStream> stream_;
  StreamEvents* events_ = nullptr;
};

}  // namespace

std::unique_ptr<StreamClient> make_stream_client(boost::asio::io_context& io, const Clock& clock,
                                                 Endpoint remote, Endpoint local) {
  return std::make_unique<AsioClient>(io, clock, remote, local);
}

}  // namespace motionlab::asio_detail
