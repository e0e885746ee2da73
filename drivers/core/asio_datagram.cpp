#include <netinet/in.h>
#include <sys/socket.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/ip/udp.hpp>
#include <cerrno>
#include <cstring>
#include <optional>
#include <utility>

#include "drivers/core/asio_detail.hpp"

namespace motionlab::asio_detail {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

/// Enough for 2 s of the laboratory's fastest sender, should this thread be held up. The kernel may grant
/// less.
constexpr int kReceiveBufferBytes = 1 << 20;
/// After so many datagrams the other sockets get their turn.
constexpr int kDatagramsPerTurn = 256;

/// The datagram's age since the kernel stamped it, both in CLOCK_REALTIME; 0 when it has no stamp, as the
/// first ones of a kernel that has stamped for nobody before. Should that clock step forward in between, what
/// waits looks older than it is: the safe side.
Nanoseconds age_of(msghdr& message) noexcept {
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp{};
    std::memcpy(&stamp, CMSG_DATA(header), sizeof stamp);
    timespec now{};
    clock_gettime(CLOCK_REALTIME, &now);
    const Nanoseconds age =
        std::chrono::seconds{now.tv_sec - stamp.tv_sec} + Nanoseconds{now.tv_nsec - stamp.tv_nsec};
    return std::max(age, Nanoseconds{0});
  }
  return 0ns;
}

/// The part that lives until the last pending operation has ended.
class Port : public std::enable_shared_from_this<Port> {
 public:
  Port(boost::asio::io_context& io, const Clock& clock) : clock_(clock), socket_(io) {}

  void bind(const Endpoint& local) {
    error_code error;
    socket_.open(udp::v4(), error);
    if (!error) socket_.bind(to_asio<udp>(local), error);
    if (!error) socket_.non_blocking(true, error);
    if (error) throw_bind_error("receive datagrams", local, error);
    error_code ignored;
    socket_.set_option(boost::asio::socket_base::receive_buffer_size(kReceiveBufferBytes), ignored);
    const int on = 1;
    ::setsockopt(socket_.native_handle(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
    local_ = from_asio(socket_.local_endpoint());
    wait();
  }

  void close() {
    handler_.reset();
    error_code ignored;
    socket_.close(ignored);
  }

  Status send(const Endpoint& to, Bytes datagram) {
    if (datagram.size() > kDatagramBytesMax) {
      return Fault{Reason::too_long, "a datagram carries at most 65507 bytes; send less"};
    }
    error_code error;
    socket_.send_to(boost::asio::buffer(datagram.data(), datagram.size()), to_asio<udp>(to), 0, error);
    if (!error) return Done{};
    if (error == boost::asio::error::connection_refused) {
      return Fault{Reason::transport,
                   "nobody listens at the destination; start the device or correct its address"};
    }
    if (error == boost::asio::error::would_block || error == boost::asio::error::no_buffer_space) {
      return Fault{Reason::transport, "the network does not take more datagrams now; send less often"};
    }
    return Fault{Reason::transport, "the destination cannot be reached; check cable, address and route"};
  }

  void on_datagram(DatagramHandler handler) {
    handler_ = handler ? std::make_shared<DatagramHandler>(std::move(handler)) : nullptr;
  }
  [[nodiscard]] Endpoint local() const { return local_; }

 private:
  void wait() {
    socket_.async_wait(udp::socket::wait_read, [self = shared_from_this()](const error_code&) {
      self->drain();
      if (self->socket_.is_open()) self->wait();
    });
  }

  /// Hands out what waits, in the order of the kernel.
  void drain() {
    for (int i = 0; i < kDatagramsPerTurn && socket_.is_open(); ++i) {
      sockaddr_in from{};
      alignas(cmsghdr) std::array<char, 128> control;
      iovec part{buffer_.data(), buffer_.size()};
      msghdr message{};
      message.msg_name = &from;
      message.msg_namelen = sizeof from;
      message.msg_iov = &part;
      message.msg_iovlen = 1;
      message.msg_control = control.data();
      message.msg_controllen = control.size();
      const ssize_t length = ::recvmsg(socket_.native_handle(), &message, 0);
      if (length < 0) {
        if (errno == EAGAIN || errno == EWOULDBLOCK) return;
        continue;  // an earlier datagram of ours was refused somewhere: no fault of this socket
      }
      last_ = std::max(last_, clock_.now() - age_of(message));
      if (const auto handler = handler_) {
        (*handler)({buffer_.data(), static_cast<std::size_t>(length)},
                   {ntohl(from.sin_addr.s_addr), ntohs(from.sin_port)}, last_);
      }
    }
  }

  const Clock& clock_;
  udp::socket socket_;
  Endpoint local_;
  LabTime last_{};                            ///< arrival of the newest, so that stamps do not go backwards
  std::shared_ptr<DatagramHandler> handler_;  ///< kept while it runs, so that it may replace itself
  std::array<std::uint8_t, std::size_t{1} << 16> buffer_{};
};

class AsioDatagramSocket final : public DatagramSocket {
 public:
  AsioDatagramSocket(boost::asio::io_context& io, const Clock& clock, Endpoint local)
      : port_(std::make_shared<Port>(io, clock)) {
    port_->bind(local);
  }
  ~AsioDatagramSocket() override { port_->close(); }

  Status send(Endpoint to, Bytes datagram) override { return port_->send(to, datagram); }
  void on_datagram(DatagramHandler handler) override { port_->on_datagram(std::move(handler)); }
  [[nodiscard]] Endpoint local() const override { return port_->local(); }

 private:
  std::shared_ptr<Port> port_;
};

}  // namespace

std::unique_ptr<DatagramSocket> make_datagram_socket(boost::asio::io_context& io, const Clock& clock,
                                                     Endpoint local) {
  return std::make_unique<AsioDatagramSocket>(io, clock, local);
}

}  // namespace motionlab::asio_detail
