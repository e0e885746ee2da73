/// @file  `Client`: one WebSocket that speaks the Foxglove protocol.
#pragma once

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/websocket.hpp>

#include <cstdint>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/core/time.hpp"
#include "gateway/console/board.hpp"
#include "gateway/console/foxglove.hpp"
#include "gateway/console/http.hpp"
#include "gateway/console/outbox.hpp"

namespace motionlab::console {

/// What a client needs of the console.
class ClientHost {
 public:
  virtual ~ClientHost() = default;
  [[nodiscard]] virtual const Board& board() const = 0;
  [[nodiscard]] virtual bool control() const = 0;
  [[nodiscard]] virtual std::string_view session() const = 0;
  [[nodiscard]] virtual bool token_is_right(std::string_view token) const = 0;
  /// @returns a sentence for the client and how bad it is
  virtual std::pair<foxglove::Level, std::string> publish(std::string_view topic, std::string_view json) = 0;
};

/// Everything runs on the thread of the console. Lives as long as an operation of its socket does; `open()`
/// says whether it is of use.
///
/// What cannot be sent at once waits in an `Outbox`. A client that asks for "/?hz=30" gets the newest sample
/// of each instance at most so often, and every event.
class Client : public std::enable_shared_from_this<Client> {
 public:
  Client(boost::beast::tcp_stream&& stream, ClientHost& host);

  /// Takes up the connection, whose upgrade this is.
  void accept(const Request& upgrade);

  /// A sample for those who subscribed to its channel.
  void offer(const Parcel& parcel);
  void channels_changed(const Board::Change& change);
  /// Sends what waits, as far as the socket takes it and the client wants it now; tells what was missed.
  void serve(LabTime now);
  void close();

  [[nodiscard]] bool open() const noexcept { return open_; }

 private:
  using WebSocket = boost::beast::websocket::stream<boost::beast::tcp_stream>;

  struct Published {
    std::string topic, encoding;
  };

  void tell(std::string text);
  void complain(std::string_view sentence) { tell(foxglove::status(foxglove::Level::error, sentence)); }
  void read();
  void pump();
  void tell_missed(LabTime now);

  void understand(const foxglove::Subscribe& subscribe);
  void understand(const foxglove::Unsubscribe& unsubscribe);
  void understand(const foxglove::Advertise& advertise);
  void understand(const foxglove::Unadvertise& unadvertise);
  void understand(const foxglove::Authorize& authorize);
  void understand(const foxglove::ClientMessage& message);

  WebSocket socket_;
  ClientHost& host_;
  bool open_ = true, accepted_ = false, writing_ = false, authorized_ = false;
  boost::beast::flat_buffer input_;
  std::map<std::uint32_t, std::uint32_t> subscription_of_;  ///< by channel
  std::map<std::uint32_t, Published> published_;            ///< the client's own channels
  std::deque<std::string> texts_;
  std::optional<Outbox> outbox_;
  std::optional<Parcel> sending_;
  foxglove::Header header_{};
  Nanoseconds period_{0};
  LabTime next_{}, next_missed_{};
  std::size_t allowed_ =
      std::numeric_limits<std::size_t>::max();  ///< parcels that may still go in this round
};

}  // namespace motionlab::console
