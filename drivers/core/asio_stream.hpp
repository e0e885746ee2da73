/// @file  Inside the Asio network only: one connected byte stream, the same for a client and for a session.
#pragma once

#include <boost/asio/ip/tcp.hpp>
#include <cstdint>
#include <memory>
#include <string_view>

#include "drivers/core/bytes.hpp"
#include "drivers/core/network.hpp"

namespace motionlab::asio_detail {

/// The words of `close_reason` for an error of a socket.
[[nodiscard]] std::string_view why_closed(const boost::system::error_code& error) noexcept;

/// Reads, writes and notices the end. Lives until its last pending operation has ended, but speaks to its
/// owner only until `close`. The owner may destroy itself in any of its handlers.
class AsioStream : public std::enable_shared_from_this<AsioStream> {
 public:
  class Owner {
   public:
    virtual ~Owner() = default;
    virtual void bytes_arrived(Bytes bytes) = 0;
    virtual void stream_broke(std::string_view why) = 0;
  };

  AsioStream(boost::asio::ip::tcp::socket socket, Owner& owner);

  /// Begins to read. Once.
  void start();
  /// Sends at once what the socket takes and queues the rest.
  Status send(Bytes bytes);
  /// Says no more to the owner. Bytes that the kernel has taken still go out.
  void close();

 private:
  void read();
  void wait_until_writable();
  /// Writes from the queue what the socket takes. False when the connection is broken.
  bool flush();
  void break_off(std::string_view why);
  [[nodiscard]] std::size_t queued() const { return queue_.size() - queue_written_; }

  boost::asio::ip::tcp::socket socket_;
  Owner* owner_;
  ByteBuffer read_buffer_;
  ByteBuffer queue_;
  std::size_t queue_written_ = 0;  ///< how much of the queue's front the socket has taken
};

}  // namespace motionlab::asio_detail
