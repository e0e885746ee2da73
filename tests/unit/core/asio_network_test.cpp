// What only real sockets do; everything else is in network_contract_test.cpp.
#include "drivers/core/asio_network.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <string>
#include <thread>

#include "drivers/core/error.hpp"
#include "drivers/core/real_clock.hpp"

namespace motionlab {
namespace {

using testing::HasSubstr;

constexpr std::uint32_t kLoopback = 0x7f000001;

class AsioNetworkTest : public testing::Test {
 protected:
  RealClock clock_;
  boost::asio::io_context io_;
  AsioNetwork network_{io_, clock_};
};

TEST_F(AsioNetworkTest, AnAddressOfAnotherMachineIsAStartUpErrorThatSaysSo) {
  for (const bool stream : {false, true}) {
    try {
      const Endpoint elsewhere = Endpoint::parse("192.0.2.1:5000");  // reserved for documentation
      if (stream) {
        (void)network_.server(elsewhere);
      } else {
        (void)network_.datagram(elsewhere);
      }
      ADD_FAILURE() << "bound";
    } catch (const StartupError& error) {
      EXPECT_THAT(error.what(), HasSubstr("192.0.2.1:5000"));
      EXPECT_THAT(error.what(), HasSubstr("this machine has no address 192.0.2.1"));
      EXPECT_THAT(error.what(), HasSubstr("configure one that it has"));
    }
  }
}

TEST_F(AsioNetworkTest, ADatagramIsStampedWhenItArrivesAndNotWhenItIsRead) {
  const auto a = network_.datagram({kLoopback, 0});
  const auto b = network_.datagram({kLoopback, 0});
  LabTime arrival{};
  b->on_datagram([&](Bytes, Endpoint, LabTime t) { arrival = t; });
  // A kernel that stamped for nobody yet begins a moment after it is asked to: the first ones may come
  // without.
  bool stamped_on_arrival = false;
  for (int i = 0; i < 20 && !stamped_on_arrival; ++i) {
    arrival = {};
    const LabTime before = clock_.now();
    ASSERT_TRUE(a->send(b->local(), as_bytes("x")).ok());
    const LabTime after = clock_.now();
    std::this_thread::sleep_for(50ms);  // the thread is held up
    const LabTime read = clock_.now();
    while (arrival == LabTime{}) io_.run_one();
    EXPECT_GE(arrival, before - 1ms);
    EXPECT_LE(arrival, clock_.now());
    stamped_on_arrival = arrival - after < (read - after) / 2;
  }
  EXPECT_TRUE(stamped_on_arrival);
}

TEST_F(AsioNetworkTest, AFloodOnOneSocketDoesNotStarveAnother) {
  const auto flooder = network_.datagram({kLoopback, 0});
  const auto flooded = network_.datagram({kLoopback, 0});
  const auto quiet = network_.datagram({kLoopback, 0});
  bool heard = false;
  std::size_t flood = 0;
  flooded->on_datagram([&](Bytes, Endpoint, LabTime) {
    ++flood;
    (void)flooder->send(flooded->local(), as_bytes("again"));  // never ends
  });
  quiet->on_datagram([&](Bytes, Endpoint, LabTime) { heard = true; });
  ASSERT_TRUE(flooder->send(flooded->local(), as_bytes("first")).ok());
  ASSERT_TRUE(flooder->send(quiet->local(), as_bytes("hello")).ok());
  for (int i = 0; i < 100 && !heard; ++i) io_.run_one();
  EXPECT_TRUE(heard);
  for (int i = 0; i < 20; ++i) io_.run_one();
  EXPECT_GT(flood, 1000u) << "the flood goes on being read";
}

struct Outcome final : StreamEvents {
  void on_open(LabTime) override { open = true; }
  void on_bytes(Bytes, LabTime) override {}
  void on_closed(std::string_view reason, LabTime) override { why = reason; }
  bool open = false;
  std::string why;
};

TEST_F(AsioNetworkTest, ALocalAddressThatIsNotHereIsAReasonAndNoException) {
  const auto server = network_.server({kLoopback, 0});
  const auto client = network_.client(server->local(), {Endpoint::parse_address("192.0.2.1"), 0});
  Outcome outcome;
  client->on_event(&outcome);
  client->open();
  EXPECT_TRUE(outcome.why.empty()) << "called from inside open";
  io_.run_for(100ms);
  EXPECT_EQ(outcome.why, close_reason::kLocalAddress);
}

TEST_F(AsioNetworkTest, EverythingMayBeDestroyedWhileOperationsArePending) {
  auto socket = network_.datagram({kLoopback, 0});
  auto server = network_.server({kLoopback, 0});
  auto client = network_.client(server->local());
  auto half_open = network_.client(server->local());
  client->open();
  io_.run_for(20ms);
  ASSERT_TRUE(client->send(ByteBuffer(100000)).ok());
  half_open->open();
  socket.reset();
  client.reset();
  half_open.reset();
  server.reset();
  io_.restart();
  EXPECT_GE(io_.run(), 1u) << "the pending operations end, and then nothing is left to do";
}

TEST_F(AsioNetworkTest, AServerThatIsRestartedGetsItsPortBackAtOnce) {
  auto server = network_.server({kLoopback, 0});
  const Endpoint local = server->local();
  const auto client = network_.client(local);
  Outcome outcome;
  client->on_event(&outcome);
  client->open();
  while (!outcome.open) io_.run_one();
  server.reset();  // its side closes first and would wait in TIME_WAIT
  EXPECT_NO_THROW(server = network_.server(local));
}

TEST_F(AsioNetworkTest, AClientNeverConnectsToItself) {
  const Endpoint own = [&] { return network_.server({kLoopback, 0})->local(); }();
  const auto client = network_.client(own, own);  // what the kernel does by chance, on purpose
  Outcome outcome;
  client->on_event(&outcome);
  client->open();
  for (int i = 0; i < 10 && outcome.why.empty() && !outcome.open; ++i) io_.run_one_for(100ms);
  EXPECT_FALSE(outcome.open);
  EXPECT_EQ(outcome.why, close_reason::kRefused);
}

}  // namespace
}  // namespace motionlab
