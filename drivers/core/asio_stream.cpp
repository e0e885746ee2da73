#include "drivers/core/asio_stream.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/asio/post.hpp>
#include <utility>

namespace motionlab::asio_detail {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

constexpr std::size_t kReadBufferBytes = std::size_t{1} << 16;

/// A peer that vanished without a word is noticed after about 8 s of silence; a live one costs nothing.
void watch_for_a_vanished_peer(tcp::socket& socket) {
  const auto set = [&](int level, int name, int value) {
    ::setsockopt(socket.native_handle(), level, name, &value, sizeof value);
  };
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 5);   // seconds of silence before the first question
  set(IPPROTO_TCP, TCP_KEEPINTVL, 1);  // seconds between questions
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);    // questions without an answer
}

}  // namespace

std::string_view why_closed(const error_code& error) noexcept {
  namespace errors = boost::asio::error;
  if (error == errors::eof) return close_reason::kClosedByPeer;
  if (error == errors::connection_refused) return close_reason::kRefused;
  if (error == errors::timed_out) return close_reason::kTimedOut;
  if (error == errors::connection_reset || error == errors::broken_pipe) return close_reason::kReset;
  if (error == errors::address_in_use || error == boost::system::errc::address_not_available) {
    return close_reason::kLocalAddress;
  }
  if (error == errors::host_unreachable || error == errors::network_unreachable ||
      error == errors::network_down) {
    return close_reason::kUnreachable;
  }
  return "the connection failed";
}

AsioStream::AsioStream(tcp::socket socket, Owner& owner)
    : socket_(std::move(socket)), owner_(&owner), read_buffer_(kReadBufferBytes) {
  error_code ignored;
  socket_.non_blocking(true, ignored);
  socket_.set_option(tcp::no_delay(true), ignored);
  watch_for_a_vanished_peer(socket_);
}

void AsioStream::start() {
  read();
}

void AsioStream::read() {
  socket_.async_read_some(boost::asio::buffer(read_buffer_),
                          [self = shared_from_this()](const error_code& error, std::size_t n) {
                            if (!self->owner_) return;
                            if (error) return self->break_off(why_closed(error));
                            self->owner_->bytes_arrived(Bytes{self->read_buffer_}.first(n));
                            if (self->owner_) self->read();
                          });
}

Status AsioStream::send(Bytes bytes) {
  if (!owner_) return Fault{Reason::transport, "the stream is closed"};
  if (queued() + bytes.size() > kStreamQueueBytesMax) {
    return Fault{Reason::transport, "the peer does not take its bytes; close and open again"};
  }
  const bool idle = queued() == 0;
  if (queue_written_ > queue_.size() / 2) {
    queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(queue_written_));
    queue_written_ = 0;
  }
  queue_.insert(queue_.end(), bytes.begin(), bytes.end());
  if (!idle) return Done{};  // somebody waits already until the socket is writable
  if (!flush()) {
    boost::asio::post(socket_.get_executor(),
                      [self = shared_from_this()] { self->break_off(close_reason::kReset); });
    return Fault{Reason::transport, "the connection is broken"};
  }
  if (queued() > 0) wait_until_writable();
  return Done{};
}

bool AsioStream::flush() {
  while (queued() > 0) {
    error_code error;
    queue_written_ +=
        socket_.write_some(boost::asio::buffer(queue_.data() + queue_written_, queued()), error);
    if (error == boost::asio::error::would_block) return true;
    if (error) return false;
  }
  queue_.clear();
  queue_written_ = 0;
  return true;
}

void AsioStream::wait_until_writable() {
  socket_.async_wait(tcp::socket::wait_write, [self = shared_from_this()](const error_code& error) {
    if (!self->owner_) return;
    if (error || !self->flush()) return self->break_off(close_reason::kReset);
    if (self->queued() > 0) self->wait_until_writable();
  });
}

void AsioStream::break_off(std::string_view why) {
  Owner* const owner = owner_;
  close();
  if (owner) owner->stream_broke(why);
}

void AsioStream::close() {
  owner_ = nullptr;
  error_code ignored;
  socket_.shutdown(tcp::socket::shutdown_both, ignored);
  socket_.close(ignored);
}

}  // namespace motionlab::asio_detail
