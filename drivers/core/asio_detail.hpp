/// @file  Inside the Asio network only: the factories of its parts, and addresses and errors in Asio's terms.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address_v4.hpp>
#include <boost/system/error_code.hpp>
#include <memory>

#include "drivers/core/network.hpp"
#include "drivers/core/time.hpp"

namespace motionlab::asio_detail {

std::unique_ptr<DatagramSocket> make_datagram_socket(boost::asio::io_context& io, const Clock& clock,
                                                     Endpoint local);
std::unique_ptr<StreamClient> make_stream_client(boost::asio::io_context& io, const Clock& clock,
                                                 Endpoint remote, Endpoint local);
/// @param next_session  the number of the next session of any server of the network
std::unique_ptr<StreamServer> make_stream_server(boost::asio::io_context& io, const Clock& clock,
                                                 Endpoint local, std::shared_ptr<SessionId> next_session);

template <class Protocol>
typename Protocol::endpoint to_asio(const Endpoint& endpoint) {
  return {boost::asio::ip::address_v4{endpoint.address}, endpoint.port};
}

template <class AsioEndpoint>
Endpoint from_asio(const AsioEndpoint& endpoint) {
  return {endpoint.address().is_v4() ? endpoint.address().to_v4().to_uint() : 0, endpoint.port()};
}

/// Why `local` could not be bound, and what to do. @param what  "receive datagrams" or "listen for
/// connections"
[[noreturn]] void throw_bind_error(const char* what, const Endpoint& local,
                                   const boost::system::error_code& error);

}  // namespace motionlab::asio_detail
