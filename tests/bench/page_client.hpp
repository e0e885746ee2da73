/// @file  `PageClient`: hears of a console what its page hears, and only counts.
#pragma once

#include <atomic>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

namespace motionlab::test {

/// Subscribes to every channel at thirty samples a second, as the page does, from birth to death.
class PageClient {
 public:
  explicit PageClient(std::uint16_t port) {
    namespace http = boost::beast::http;
    boost::asio::ip::tcp::endpoint there(boost::asio::ip::make_address("127.0.0.1"), port);
    boost::beast::get_lowest_layer(socket_).connect(there);
    socket_.set_option(boost::beast::websocket::stream_base::decorator(
        [](auto& request) { request.set(http::field::sec_websocket_protocol, "foxglove.websocket.v1"); }));
    socket_.handshake("127.0.0.1:" + std::to_string(port), "/?hz=30");
    thread_ = std::thread([this] { listen(); });
  }
  ~PageClient() {
    ending_ = true;
    boost::beast::error_code ignored;  // it may have gone first
    boost::beast::get_lowest_layer(socket_).socket().shutdown(boost::asio::ip::tcp::socket::shutdown_both,
                                                              ignored);
    thread_.join();
  }
  PageClient(const PageClient&) = delete;
  PageClient& operator=(const PageClient&) = delete;

  [[nodiscard]] std::uint64_t samples() const { return samples_.load(); }
  /// It is alive, or was told to end.
  [[nodiscard]] bool well() const { return ending_ || !broken_; }

 private:
  void listen() {
    boost::beast::error_code error;
    for (boost::beast::flat_buffer message;; message.clear()) {
      socket_.read(message, error);
      if (error) break;
      if (socket_.got_binary()) {
        ++samples_;
      } else {
        answer(nlohmann::json::parse(boost::beast::buffers_to_string(message.data())), error);
      }
    }
    broken_ = true;
  }
  void answer(const nlohmann::json& said, boost::beast::error_code& error) {
    if (said.at("op") != "advertise") return;
    nlohmann::json wanted = nlohmann::json::array();
    for (const auto& channel : said.at("channels"))
      wanted.push_back({{"id", ++subscriptions_}, {"channelId", channel.at("id")}});
    socket_.text(true);
    const std::string text = nlohmann::json{{"op", "subscribe"}, {"subscriptions", wanted}}.dump();
    socket_.write(boost::asio::buffer(text), error);
  }

  boost::asio::io_context io_;
  boost::beast::websocket::stream<boost::beast::tcp_stream> socket_{io_};
  int subscriptions_ = 0;
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<bool> ending_{false}, broken_{false};
  std::thread thread_;
};

}  // namespace motionlab::test
