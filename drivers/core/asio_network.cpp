#include "drivers/core/asio_network.hpp"

#include <boost/asio/error.hpp>
#include <string>

#include "drivers/core/asio_detail.hpp"
#include "drivers/core/error.hpp"

namespace motionlab {

AsioNetwork::AsioNetwork(boost::asio::io_context& io, const Clock& clock)
    : io_(io), clock_(clock), next_session_(std::make_shared<SessionId>(1)) {}
AsioNetwork::~AsioNetwork() = default;

std::unique_ptr<DatagramSocket> AsioNetwork::datagram(Endpoint local) {
  return asio_detail::make_datagram_socket(io_, clock_, local);
}

std::unique_ptr<StreamClient> AsioNetwork::client(Endpoint remote, Endpoint local) {
  return asio_detail::make_stream_client(io_, clock_, remote, local);
}

std::unique_ptr<StreamServer> AsioNetwork::server(Endpoint local) {
  return asio_detail::make_stream_server(io_, clock_, local, next_session_);
}

namespace asio_detail {

void throw_bind_error(const char* what, const Endpoint& local, const boost::system::error_code& error) {
  const std::string port = std::to_string(local.port);
  std::string why = error.message();
  if (error == boost::asio::error::address_in_use) {
    why = "port " + port +
          " is in use by another process; stop it (\"ss -lunpt\" shows which) or configure another port";
  } else if (error == boost::system::errc::address_not_available) {
    why = "this machine has no address " + address_to_string(local.address) +
          "; give it to an interface (\"ip address\" shows what there is) or configure one that it has";
  } else if (error == boost::asio::error::access_denied) {
    why = "port " + port + " needs a privilege; configure one above 1023 or grant CAP_NET_BIND_SERVICE";
  }
  throw StartupError(std::string("cannot ") + what + " on " + to_string(local) + ": " + why);
}

}  // namespace asio_detail
}  // namespace motionlab
