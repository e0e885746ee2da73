/// @file  Real sockets, on Boost.Asio.
#pragma once

#include <memory>

#include "drivers/core/network.hpp"
#include "drivers/core/time.hpp"

namespace boost::asio {
class io_context;
}  // namespace boost::asio

namespace motionlab {

/// UDP and TCP of this machine. Everything happens on the one thread that runs the io_context.
///
/// A datagram's arrival is when the kernel took it from the wire, not when this thread came to read it; bytes
/// of a stream are stamped when they are read. A flood on one socket does not starve the others. Every
/// transport must be destroyed before the io_context; it may be destroyed at any other time, inside its own
/// handlers too.
class AsioNetwork final : public Network {
 public:
  /// @param io, clock  outlive the network and its transports
  AsioNetwork(boost::asio::io_context& io, const Clock& clock);
  ~AsioNetwork() override;

  std::unique_ptr<DatagramSocket> datagram(Endpoint local) override;
  std::unique_ptr<StreamClient> client(Endpoint remote, Endpoint local = {}) override;
  std::unique_ptr<StreamServer> server(Endpoint local) override;

 private:
  boost::asio::io_context& io_;
  const Clock& clock_;
  std::shared_ptr<SessionId> next_session_;
};

}  // namespace motionlab
