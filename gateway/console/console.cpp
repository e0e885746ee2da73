#include "gateway/console/console.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>

#include <algorithm>
#include <csignal>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include "drivers/core/error.hpp"
#include "gateway/bus/dds_tap.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/console/board.hpp"
#include "gateway/console/client.hpp"
#include "gateway/console/hands.hpp"
#include "gateway/console/token.hpp"

namespace motionlab::console {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using asio::ip::tcp;

constexpr Nanoseconds kRound = 10ms;        // from taking to taking
constexpr Nanoseconds kLookAround = 250ms;  // which topics have writers; the console's own state
constexpr std::size_t kMostClients = 64;
constexpr std::size_t kMostVisits = 256;  // HTTP connections at one time
constexpr std::size_t kLargestHeader = 16 << 10, kLargestBody = 4 << 10;
constexpr auto kPatience = std::chrono::seconds{30};  // with a request

bool speaks_foxglove(const Request& request) {
  for (const auto& offered : http::token_list{request[http::field::sec_websocket_protocol]}) {
    if (offered == beast::string_view{foxglove::kSubprotocol.data(), foxglove::kSubprotocol.size()})
      return true;
  }
  return false;
}

}  // namespace

struct Console::Impl final : ClientHost {
  Impl(ConsoleConfig wanted, Assets&& page, RealClock& lab_clock)
      : config(std::move(wanted)),
        assets(std::move(page)),
        clock(lab_clock),
        acceptor(io),
        timer(io),
        signals(io, SIGINT, SIGTERM),
        tap(config.dds),
        hands(config.dds, clock, config.requester),
        session_(std::to_string(to_ns(clock.now()))) {
    const tcp::endpoint where{asio::ip::address_v4{config.listen.address}, config.listen.port};
    try {
      acceptor.open(where.protocol());
      acceptor.set_option(asio::socket_base::reuse_address(true));
      acceptor.bind(where);
      acceptor.listen();
    } catch (const boost::system::system_error& error) {
      throw StartupError{"cannot listen on " + to_string(config.listen) + ": " + error.code().message() +
                         "; is another console running there? --listen chooses another address or port"};
    }
  }

  // --- for clients

  [[nodiscard]] const Board& board() const override { return board_; }
  [[nodiscard]] bool control() const override { return config.control; }
  [[nodiscard]] std::string_view session() const override { return session_; }
  [[nodiscard]] bool token_is_right(std::string_view token) const override {
    return same_token(token, config.token);
  }
  std::pair<foxglove::Level, std::string> publish(std::string_view topic, std::string_view json) override {
    using foxglove::Level;
    if (!Hands::may_publish(topic)) return {Level::error, std::string{topic} + " is not published from here"};
    try {
      hands.publish(topic, json);
    } catch (const std::invalid_argument& wrong) {
      return {Level::error, std::string{"refused: "} + wrong.what()};
    }
    if (gateway_heard()) return {Level::info, "asked of the gateway"};
    return {Level::error, "no gateway is heard: it was asked, but nobody is known to have heard it"};
  }

  [[nodiscard]] bool gateway_heard() const { return tap.writers(bus::topic_index<topic::Mode>()) > 0; }

  // --- the rounds

  void accept();

  void round() {
    const LabTime now = clock.now();
    taken += tap.take([&](const bus::TappedSample& sample) {
      auto bytes = std::make_shared<const std::vector<std::byte>>(sample.cdr.begin(), sample.cdr.end());
      hand_out(board_.accept(sample.topic, sample.instance, now, std::move(bytes)));
    });
    hands.run(now);
    if (now >= next_look) {
      next_look = now + kLookAround;
      look_around(now);
    }
    for (const auto& client : clients) client->serve(now);
    std::erase_if(clients, [](const auto& client) { return !client->open(); });
    timer.expires_after(kRound);
    timer.async_wait([this](beast::error_code stopped) {
      if (!stopped) round();
    });
  }

  void hand_out(const Parcel& parcel) {
    for (const auto& client : clients) client->offer(parcel);
  }

  void look_around(LabTime now) {
    std::vector<bool> written;
    for (std::size_t topic = 0; topic < bus::kTopicList.size(); ++topic)
      written.push_back(tap.writers(topic) > 0);
    const Board::Change change = board_.look(now, written);
    if (!change.come.empty() || !change.gone.empty()) {
      for (const auto& client : clients) client->channels_changed(change);
    }
    const std::string text =
        "{\"t_ns\":\"" + std::to_string(to_ns(now)) + "\",\"clients\":" + std::to_string(clients.size()) +
        ",\"taken\":" + std::to_string(taken) + ",\"refused\":" + std::to_string(tap.refused()) +
        ",\"gateway_heard\":" + (gateway_heard() ? "true" : "false") + "}";
    const auto* const begin = reinterpret_cast<const std::byte*>(text.data());
    hand_out({kOwnChannel, ~std::uint32_t{0}, to_ns(now), false,
              std::make_shared<const std::vector<std::byte>>(begin, begin + text.size())});
    if (now < next_alive) return;
    next_alive = now + 1s;
    clock.discipline();
    alive(std::to_string(clients.size()) + " watching, gateway " + (gateway_heard() ? "heard" : "not heard"));
  }

  const ConsoleConfig config;
  const Assets assets;
  RealClock& clock;
  asio::io_context io{1};
  tcp::acceptor acceptor;
  asio::steady_timer timer;
  asio::signal_set signals;
  bus::DdsTap tap;
  Hands hands;
  Board board_;
  const std::string session_;
  std::vector<std::shared_ptr<Client>> clients;
  std::size_t visits = 0;
  std::uint64_t taken = 0;
  LabTime next_look{}, next_alive{};
  std::function<void(const std::string&)> alive;
};

namespace {

/// One HTTP connection: request, answer, request, answer …, or an upgrade.
template <class Host>
class VisitOf : public std::enable_shared_from_this<VisitOf<Host>> {
 public:
  VisitOf(tcp::socket&& socket, Host& host) : stream_(std::move(socket)), host_(host) { ++host_.visits; }
  ~VisitOf() { --host_.visits; }
  VisitOf(const VisitOf&) = delete;
  VisitOf& operator=(const VisitOf&) = delete;

  void read() {
    parser_.emplace();
    parser_->header_limit(kLargestHeader);
    parser_->body_limit(kLargestBody);
    stream_.expires_after(kPatience);
    http::async_read(stream_, buffer_, *parser_,
                     [self = this->shared_from_this()](beast::error_code failed, std::size_t) {
                       if (!failed) self->handle();
                     });
  }

 private:
  void handle() {
    const Request request = parser_->release();
    if (websocket::is_upgrade(request)) return upgrade(request);
    Kind kind{};
    Response response = answer(request, host_.assets, host_.config.neighbours, kind);
    if (kind == Kind::settle) {
      host_.hands.settle();
      response = settle_answer(request, host_.gateway_heard() ? 1 : 0);
    }
    send(std::move(response));
  }

  void upgrade(const Request& request) {
    const auto view = [](beast::string_view text) { return std::string_view{text.data(), text.size()}; };
    const std::string_view host = view(request[http::field::host]);
    if (!host_.config.neighbours.host_is_ours(host)) {
      return send(refusal(request, http::status::misdirected_request, "this is no name of the console"));
    }
    if (!host_.config.neighbours.origin_may(view(request[http::field::origin]), host)) {
      return send(refusal(request, http::status::forbidden,
                          "a page from elsewhere may not look on: start the console with --allow-origin"));
    }
    if (!speaks_foxglove(request)) {
      return send(refusal(request, http::status::bad_request, "speak foxglove.websocket.v1"));
    }
    if (host_.clients.size() >= kMostClients) {
      return send(refusal(request, http::status::service_unavailable, "64 are watching already"));
    }
    host_.clients.push_back(std::make_shared<Client>(std::move(stream_), host_));
    host_.clients.back()->accept(request);
  }

  void send(Response response) {
    response_.emplace(std::move(response));
    stream_.expires_after(kPatience);
    http::async_write(stream_, *response_,
                      [self = this->shared_from_this()](beast::error_code failed, std::size_t) {
                        if (failed || !self->response_->keep_alive()) {
                          beast::error_code ignored;
                          self->stream_.socket().shutdown(tcp::socket::shutdown_send, ignored);
                        } else {
                          self->read();
                        }
                      });
  }

  beast::tcp_stream stream_;
  Host& host_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  std::optional<Response> response_;
};

}  // namespace

void Console::Impl::accept() {
  acceptor.async_accept([this](beast::error_code failed, tcp::socket socket) {
    if (failed == asio::error::operation_aborted) return;
    if (!failed && visits < kMostVisits) std::make_shared<VisitOf<Impl>>(std::move(socket), *this)->read();
    accept();
  });
}

Console::Console(ConsoleConfig config, Assets assets, RealClock& clock)
    : impl_(std::make_unique<Impl>(std::move(config), std::move(assets), clock)) {}

Console::~Console() = default;

Endpoint Console::endpoint() const {
  return {impl_->config.listen.address, impl_->acceptor.local_endpoint().port()};
}

void Console::run(const std::function<void(const std::string&)>& alive) {
  impl_->alive = alive;
  impl_->signals.async_wait([this](beast::error_code, int) { impl_->io.stop(); });
  impl_->accept();
  impl_->round();
  impl_->io.run();
}

}  // namespace motionlab::console
