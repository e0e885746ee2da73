#include "gateway/console/client.hpp"

#include <boost/asio/buffer.hpp>
#include <boost/beast/core/buffers_to_string.hpp>

#include <algorithm>
#include <array>
#include <charconv>
#include <utility>

namespace motionlab::console {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
namespace http = beast::http;

constexpr std::size_t kOutboxBytes = 1 << 20;
constexpr std::size_t kMostTexts = 64;            // answers that wait for a client that does not read
constexpr std::size_t kLargestMessage = 1 << 16;  // from a client
constexpr std::size_t kMostChannels = 16;         // of a client's own
constexpr int kSendBuffer = 1 << 17;              // of the kernel, so that a slow client is noticed here

/// "/?hz=30" → 1/30 s; zero when every sample is wanted.
Nanoseconds period_of(beast::string_view target) {
  const std::string_view text{target.data(), target.size()};
  const auto at = text.find("hz=");
  unsigned hz = 0;
  if (at == text.npos) return Nanoseconds{0};
  std::from_chars(text.data() + at + 3, text.data() + text.size(), hz);
  return hz == 0 ? Nanoseconds{0} : Nanoseconds{1'000'000'000 / std::clamp(hz, 1U, 1000U)};
}

/// The token of "Authorization: Bearer TOKEN".
std::string_view bearer_of(const Request& request) {
  const auto field = request[http::field::authorization];
  const std::string_view text{field.data(), field.size()};
  constexpr std::string_view kScheme = "Bearer ";
  return text.starts_with(kScheme) ? text.substr(kScheme.size()) : std::string_view{};
}

}  // namespace

Client::Client(beast::tcp_stream&& stream, ClientHost& host) : socket_(std::move(stream)), host_(host) {}

void Client::accept(const Request& upgrade) {
  period_ = period_of(upgrade.target());
  outbox_.emplace(kOutboxBytes, period_ > Nanoseconds{0});
  authorized_ = host_.control() && host_.token_is_right(bearer_of(upgrade));
  beast::error_code ignored;
  auto& socket = beast::get_lowest_layer(socket_).socket();
  socket.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
  socket.set_option(boost::asio::socket_base::send_buffer_size(kSendBuffer), ignored);
  beast::get_lowest_layer(socket_).expires_never();  // the WebSocket has a timer of its own
  socket_.set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  socket_.set_option(websocket::stream_base::decorator([](websocket::response_type& response) {
    response.set(http::field::server, "motionlab-console");
    response.set(http::field::sec_websocket_protocol,
                 beast::string_view{foxglove::kSubprotocol.data(), foxglove::kSubprotocol.size()});
  }));
  socket_.read_message_max(kLargestMessage);
  socket_.auto_fragment(false);
  socket_.async_accept(upgrade, [self = shared_from_this()](beast::error_code failed) {
    if (failed) return self->close();
    self->accepted_ = true;
    self->tell(foxglove::server_info(self->host_.control(), self->host_.session()));
    self->tell(foxglove::advertise(self->host_.board().channels()));
    if (self->authorized_) self->tell(foxglove::authorized(true));
    self->read();
  });
}

void Client::offer(const Parcel& parcel) {
  if (accepted_ && open_ && subscription_of_.contains(parcel.channel)) outbox_->push(parcel);
}

void Client::channels_changed(const Board::Change& change) {
  if (!accepted_) return;
  for (const std::uint32_t channel : change.gone) {
    subscription_of_.erase(channel);
    outbox_->forget(channel);
  }
  if (!change.gone.empty()) tell(foxglove::unadvertise(change.gone));
  if (!change.come.empty()) tell(foxglove::advertise(change.come));
}

void Client::serve(LabTime now) {
  if (!accepted_ || !open_) return;
  tell_missed(now);
  if (period_ > Nanoseconds{0}) {
    if (now < next_) return;
    next_ = std::max(next_ + period_, now - period_);
    allowed_ = outbox_->size();
  }
  pump();
}

void Client::close() {
  open_ = false;
  beast::error_code ignored;
  beast::get_lowest_layer(socket_).socket().close(ignored);
}

void Client::tell(std::string text) {
  if (texts_.size() >= kMostTexts) return close();
  texts_.push_back(std::move(text));
  pump();
}

void Client::tell_missed(LabTime now) {
  if (now < next_missed_ || !texts_.empty()) return;
  next_missed_ = now + 1s;
  const auto missed = outbox_->newly_missed();
  if (missed.empty()) return;
  std::string sentence = "this client is too slow; left out were";
  for (const auto& [channel, count] : missed) {
    sentence += " " + std::to_string(count) + " of " +
                (channel == kOwnChannel ? std::string{"console/state"}
                                        : std::string{bus::kTopicList[channel - 1].name});
  }
  tell(foxglove::missed_status(sentence, outbox_->missed()));
}

void Client::pump() {
  if (writing_ || !open_) return;
  const auto sent = [self = shared_from_this()](beast::error_code failed, std::size_t) {
    self->writing_ = false;
    if (failed) return self->close();
    if (self->sending_) {
      self->sending_.reset();
    } else {
      self->texts_.pop_front();
    }
    self->pump();
  };
  if (!texts_.empty()) {
    writing_ = true;
    socket_.text(true);
    socket_.async_write(boost::asio::buffer(texts_.front()), sent);
    return;
  }
  if (allowed_ == 0 || !(sending_ = outbox_->pop())) return;
  if (period_ > Nanoseconds{0}) --allowed_;
  writing_ = true;
  header_ = foxglove::message_header(subscription_of_.at(sending_->channel), sending_->t_ns);
  socket_.binary(true);
  const std::array<boost::asio::const_buffer, 2> buffers{boost::asio::buffer(header_),
                                                         boost::asio::buffer(*sending_->payload)};
  socket_.async_write(buffers, sent);
}

void Client::read() {
  socket_.async_read(input_, [self = shared_from_this()](beast::error_code failed, std::size_t) {
    if (failed || !self->open_) return self->close();
    const std::string bytes = beast::buffers_to_string(self->input_.data());
    self->input_.consume(self->input_.size());
    if (self->socket_.got_text()) {
      const auto understood = foxglove::read_text(bytes);
      if (const auto* const wrong = std::get_if<std::string>(&understood)) {
        self->complain(*wrong);
      } else {
        std::visit([&](const auto& meant) { self->understand(meant); },
                   std::get<foxglove::ClientText>(understood));
      }
    } else {
      const auto understood = foxglove::read_binary(bytes);
      if (const auto* const wrong = std::get_if<std::string>(&understood)) {
        self->complain(*wrong);
      } else {
        self->understand(std::get<foxglove::ClientMessage>(understood));
      }
    }
    if (self->open_) self->read();
  });
}

void Client::understand(const foxglove::Subscribe& subscribe) {
  for (const auto& [subscription, channel] : subscribe.all) {
    if (!host_.board().open(channel)) {
      complain("there is no channel " + std::to_string(channel));
    } else if (!subscription_of_.try_emplace(channel, subscription).second) {
      complain("channel " + std::to_string(channel) + " is subscribed to already");
    } else {
      for (const Parcel& parcel : host_.board().remembered(channel)) outbox_->push(parcel);
    }
  }
  pump();
}

void Client::understand(const foxglove::Unsubscribe& unsubscribe) {
  for (const std::uint32_t subscription : unsubscribe.subscriptions) {
    const auto found =
        std::ranges::find(subscription_of_, subscription, [](const auto& entry) { return entry.second; });
    if (found == subscription_of_.end()) {
      complain("there is no subscription " + std::to_string(subscription));
    } else {
      outbox_->forget(found->first);
      subscription_of_.erase(found);
    }
  }
}

void Client::understand(const foxglove::Advertise& advertise) {
  for (const auto& channel : advertise.all) {
    if (published_.size() >= kMostChannels) return complain("a client has at most 16 channels of its own");
    published_[channel.channel] = {channel.topic, channel.encoding};
  }
}

void Client::understand(const foxglove::Unadvertise& unadvertise) {
  for (const std::uint32_t channel : unadvertise.channels) published_.erase(channel);
}

void Client::understand(const foxglove::Authorize& authorize) {
  authorized_ = host_.control() && host_.token_is_right(authorize.token);
  tell(foxglove::authorized(authorized_));
}

void Client::understand(const foxglove::ClientMessage& message) {
  const auto channel = published_.find(message.channel);
  if (channel == published_.end()) return complain("the client has not advertised this channel");
  if (!host_.control()) return complain("refused: this console only shows; start it with --control");
  if (!authorized_)
    return complain("refused: show the token first, which the console printed when it was started");
  if (channel->second.encoding != "json") return complain("refused: messages to the console are JSON");
  const auto [level, sentence] = host_.publish(channel->second.topic, message.payload);
  tell(foxglove::status(level, sentence));
}

}  // namespace motionlab::console
