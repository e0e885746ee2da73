/// @file  A network in whose handlers the heap is watched: what drivers take from it, without what the
/// network takes.
#pragma once

#include <memory>
#include <string_view>
#include <utility>

#include "drivers/core/network.hpp"
#include "tests/support/allocation_count.hpp"

namespace motionlab::integration {

/// Does what it is given, and forgets what that took from the heap.
template <class Work>
auto uncounted(const Work& work) {
  const std::size_t before = test::allocations;
  auto result = work();
  test::allocations = before;
  return result;
}

/// Lies between the drivers and a network. What the drivers take from the heap while they are handed bytes is
/// added up.
class CountedNetwork final : public Network {
 public:
  explicit CountedNetwork(Network& inner) : inner_(inner) {}

  [[nodiscard]] std::size_t taken() const { return taken_; }
  /// Adds what `work` takes.
  template <class Work>
  void count(const Work& work) {
    const std::size_t before = test::allocations;
    work();
    taken_ += test::allocations - before;
  }

  std::unique_ptr<DatagramSocket> datagram(Endpoint local) override {
    return std::make_unique<Datagrams>(*this, inner_.datagram(local));
  }
  std::unique_ptr<StreamClient> client(Endpoint remote, Endpoint local) override {
    return std::make_unique<Client>(*this, inner_.client(remote, local));
  }
  std::unique_ptr<StreamServer> server(Endpoint local) override { return inner_.server(local); }

 private:
  class Datagrams final : public DatagramSocket {
   public:
    Datagrams(CountedNetwork& network, std::unique_ptr<DatagramSocket> inner)
        : network_(network), inner_(std::move(inner)) {}
    Status send(Endpoint to, Bytes datagram) override {
      return uncounted([&] { return inner_->send(to, datagram); });
    }
    void on_datagram(DatagramHandler handler) override {
      inner_->on_datagram([this, handler = std::move(handler)](Bytes datagram, Endpoint from, LabTime t) {
        network_.count([&] { handler(datagram, from, t); });
      });
    }
    [[nodiscard]] Endpoint local() const override { return inner_->local(); }

   private:
    CountedNetwork& network_;
    std::unique_ptr<DatagramSocket> inner_;
  };

  class Client final : public StreamClient, private StreamEvents {
   public:
    Client(CountedNetwork& network, std::unique_ptr<StreamClient> inner)
        : network_(network), inner_(std::move(inner)) {}
    void open() override {
      uncounted([&] {
        inner_->open();
        return 0;
      });
    }
    Status send(Bytes bytes) override {
      return uncounted([&] { return inner_->send(bytes); });
    }
    void close() override { inner_->close(); }
    void on_event(StreamEvents* events) override {
      events_ = events;
      inner_->on_event(events != nullptr ? this : nullptr);
    }

   private:
    void on_open(LabTime t) override {
      events_->on_open(t);
    }  // a connection is made anew, and may take what it needs
    void on_bytes(Bytes bytes, LabTime t) override {
      network_.count([&] { events_->on_bytes(bytes, t); });
    }
    void on_closed(std::string_view why, LabTime t) override { events_->on_closed(why, t); }

    CountedNetwork& network_;
    std::unique_ptr<StreamClient> inner_;
    StreamEvents* events_ = nullptr;
  };

  Network& inner_;
  std::size_t taken_ = 0;
};

}  // namespace motionlab::integration
