// What every Network promises, held against the memory network on stepped time and real sockets on loopback.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <boost/asio/io_context.hpp>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/core/asio_network.hpp"
#include "drivers/core/error.hpp"
#include "drivers/core/memory_network.hpp"
#include "drivers/core/real_clock.hpp"

namespace motionlab {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint32_t kLoopback = 0x7f000001;

/// A network and the way to let its time pass.
class World {
 public:
  virtual ~World() = default;
  virtual Network& network() = 0;
  virtual LabTime now() = 0;
  /// Lets time pass until `done` says so. False when that took longer than any healthy network does.
  virtual bool run_until(const std::function<bool()>& done) = 0;
  /// Lets everything that is under way arrive.
  virtual void settle() = 0;
};

class MemoryWorld final : public World {
 public:
  Network& network() override { return network_; }
  LabTime now() override { return clock_.now(); }
  bool run_until(const std::function<bool()>& done) override {
    for (int i = 0; i < 5000 && !done(); ++i) network_.run_until(clock_.now() + 1ms);
    return done();
  }
  void settle() override { network_.run_until(clock_.now() + 10ms); }

 private:
  SteppedClock clock_;
  MemoryNetwork network_{clock_};
};

class AsioWorld final : public World {
 public:
  Network& network() override { return network_; }
  LabTime now() override { return clock_.now(); }
  bool run_until(const std::function<bool()>& done) override {
    const LabTime end = clock_.now() + 20s;
    while (!done() && clock_.now() < end) {
      io_.restart();
      io_.run_one_for(10ms);
    }
    return done();
  }
  void settle() override {
    io_.restart();
    io_.run_for(50ms);
  }

 private:
  RealClock clock_;
  boost::asio::io_context io_;
  AsioNetwork network_{io_, clock_};
};

struct Kind {
  const char* name;
  std::function<std::unique_ptr<World>()> make;
};

class NetworkContract : public testing::TestWithParam<Kind> {
 protected:
  std::unique_ptr<World> world_ = GetParam().make();
  Network& network_ = world_->network();
};

INSTANTIATE_TEST_SUITE_P(Every, NetworkContract,
                         testing::Values(Kind{"Memory", [] { return std::make_unique<MemoryWorld>(); }},
                                         Kind{"Asio", [] { return std::make_unique<AsioWorld>(); }}),
                         [](const auto& kind) { return kind.param.name; });

/// Writes down what happens to a client.
struct ClientDiary final : StreamEvents {
  void on_open(LabTime) override {
    events.emplace_back("open");
    if (then) then();
  }
  void on_bytes(Bytes bytes, LabTime) override {
    received += as_text(bytes);
    if (then) then();
  }
  void on_closed(std::string_view why, LabTime) override {
    events.push_back("closed: " + std::string(why));
    if (then) then();
  }
  std::vector<std::string> events;
  std::string received;
  std::function<void()> then;
};

struct ServerDiary final : ServerEvents {
  void on_accepted(SessionId session, Endpoint from, LabTime) override {
    events.emplace_back("accepted");
    sessions.push_back(session);
    peers.push_back(from);
    if (then) then();
  }
  void on_bytes(SessionId, Bytes bytes, LabTime) override {
    received += as_text(bytes);
    if (then) then();
  }
  void on_closed(SessionId session, LabTime) override {
    events.emplace_back("closed");
    closed.push_back(session);
    if (then) then();
  }
  std::vector<std::string> events;
  std::vector<SessionId> sessions;
  std::vector<SessionId> closed;
  std::vector<Endpoint> peers;
  std::string received;
  std::function<void()> then;
};

/// A client that is connected to a server, and both their diaries.
struct Connected {
  explicit Connected(World& world) : server(world.network().server({kLoopback, 0})) {
    server->on_event(&at_server);
    client = world.network().client(server->local());
    client->on_event(&at_client);
    client->open();
    ok = world.run_until([this] { return !at_client.events.empty() && !at_server.events.empty(); });
  }
  ServerDiary at_server;
  ClientDiary at_client;
  std::unique_ptr<StreamServer> server;
  std::unique_ptr<StreamClient> client;
  bool ok = false;
};

TEST_P(NetworkContract, DeliversADatagramWithItsSenderAndItsArrival) {
  const auto a = network_.datagram({kLoopback, 0});
  const auto b = network_.datagram({kLoopback, 0});
  ASSERT_NE(a->local().port, 0);
  std::string text;
  Endpoint sender;
  LabTime arrival{};
  b->on_datagram([&](Bytes bytes, Endpoint from, LabTime t) {
    text = as_text(bytes);
    sender = from;
    arrival = t;
  });
  const LabTime before = world_->now();
  ASSERT_TRUE(a->send(b->local(), as_bytes("ahoy")).ok());
  EXPECT_TRUE(text.empty()) << "delivered from inside send";
  ASSERT_TRUE(world_->run_until([&] { return !text.empty(); }));
  EXPECT_EQ(text, "ahoy");
  EXPECT_EQ(sender, a->local());
  EXPECT_GE(arrival, before);
  EXPECT_LE(arrival, world_->now());
}

TEST_P(NetworkContract, KeepsTheOrderOfManyDatagramsOfOneSender) {
  const auto a = network_.datagram({kLoopback, 0});
  const auto b = network_.datagram({kLoopback, 0});
  std::vector<int> seen;
  std::vector<LabTime> arrivals;
  b->on_datagram([&](Bytes bytes, Endpoint, LabTime t) {
    seen.push_back(load<std::uint16_t, std::endian::little>(bytes));
    arrivals.push_back(t);
  });
  constexpr int kMany = 150;  // fits the receive buffer of a machine that grants no more than its default
  for (int i = 0; i < kMany; ++i) {
    std::array<std::uint8_t, 2> bytes{};
    store<std::endian::little>(bytes, static_cast<std::uint16_t>(i));
    ASSERT_TRUE(a->send(b->local(), bytes).ok());
  }
  ASSERT_TRUE(world_->run_until([&] { return seen.size() == kMany; }));
  for (int i = 0; i < kMany; ++i) EXPECT_EQ(seen[static_cast<std::size_t>(i)], i);
  EXPECT_TRUE(std::is_sorted(arrivals.begin(), arrivals.end()));
}

TEST_P(NetworkContract, ASocketOnAnyAddressSendsFromLoopback) {
  const auto any = network_.datagram({0, 0});
  const auto b = network_.datagram({kLoopback, 0});
  Endpoint sender;
  std::string echoed;
  b->on_datagram([&](Bytes bytes, Endpoint from, LabTime) {
    sender = from;
    (void)b->send(from, bytes);
  });
  any->on_datagram([&](Bytes bytes, Endpoint, LabTime) { echoed = as_text(bytes); });
  ASSERT_TRUE(any->send(b->local(), as_bytes("x")).ok());
  ASSERT_TRUE(world_->run_until([&] { return !echoed.empty(); }));
  EXPECT_EQ(sender, (Endpoint{kLoopback, any->local().port}));
}

TEST_P(NetworkContract, DeliversAnEmptyDatagramAndTheLongestOne) {
  const auto a = network_.datagram({kLoopback, 0});
  const auto b = network_.datagram({kLoopback, 0});
  std::vector<std::size_t> sizes;
  b->on_datagram([&](Bytes bytes, Endpoint, LabTime) { sizes.push_back(bytes.size()); });
  const ByteBuffer longest(kDatagramBytesMax, 7);
  ASSERT_TRUE(a->send(b->local(), {}).ok());
  ASSERT_TRUE(a->send(b->local(), longest).ok());
  ASSERT_TRUE(world_->run_until([&] { return sizes.size() == 2; }));
  EXPECT_THAT(sizes, ElementsAre(0u, kDatagramBytesMax));
}

TEST_P(NetworkContract, RefusesADatagramThatIsTooLong) {
  const auto a = network_.datagram({kLoopback, 0});
  const ByteBuffer too_long(kDatagramBytesMax + 1, 7);
  const Status status = a->send({kLoopback, 9}, too_long);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.fault().reason, Reason::too_long);
}

TEST_P(NetworkContract, APortInUseIsAStartUpErrorThatNamesIt) {
  const auto a = network_.datagram({kLoopback, 0});
  try {
    const auto b = network_.datagram(a->local());
    FAIL() << "bound twice";
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr(to_string(a->local())));
    EXPECT_THAT(error.what(), HasSubstr("in use"));
  }
  const auto server = network_.server({kLoopback, 0});
  try {
    const auto second = network_.server(server->local());
    FAIL() << "listens twice";
  } catch (const StartupError& error) {
    EXPECT_THAT(error.what(), HasSubstr(to_string(server->local())));
    EXPECT_THAT(error.what(), HasSubstr("in use"));
  }
}

TEST_P(NetworkContract, ASocketSurvivesAPeerThatIsNotThere) {
  const auto a = network_.datagram({kLoopback, 0});
  const auto b = network_.datagram({kLoopback, 0});
  const Endpoint nobody = [&] { return network_.datagram({kLoopback, 0})->local(); }();
  int received = 0;
  a->on_datagram([&](Bytes, Endpoint, LabTime) { ++received; });
  for (int i = 0; i < 5; ++i) {
    (void)a->send(nobody, as_bytes("anybody?"));
    world_->settle();
  }
  ASSERT_TRUE(b->send(a->local(), as_bytes("here")).ok());
  EXPECT_TRUE(world_->run_until([&] { return received == 1; }));
}

TEST_P(NetworkContract, ADatagramSocketMayBeDestroyedInItsOwnHandler) {
  const auto a = network_.datagram({kLoopback, 0});
  auto b = network_.datagram({kLoopback, 0});
  int received = 0;
  std::string kept = "the captures live until the handler returns";
  b->on_datagram([&received, &b, kept](Bytes, Endpoint, LabTime) {
    b.reset();
    received += kept.empty() ? 100 : 1;
  });
  const Endpoint to = b->local();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(a->send(to, as_bytes("x")).ok());
  ASSERT_TRUE(world_->run_until([&] { return received > 0; }));
  world_->settle();
  EXPECT_EQ(received, 1);
}

TEST_P(NetworkContract, AHandlerMayReplaceItself) {
  const auto a = network_.datagram({kLoopback, 0});
  const auto b = network_.datagram({kLoopback, 0});
  std::string order;
  b->on_datagram([&](Bytes, Endpoint, LabTime) {
    b->on_datagram([&](Bytes, Endpoint, LabTime) { order += '2'; });
    order += '1';
  });
  ASSERT_TRUE(a->send(b->local(), as_bytes("x")).ok());
  ASSERT_TRUE(a->send(b->local(), as_bytes("x")).ok());
  ASSERT_TRUE(world_->run_until([&] { return order.size() == 2; }));
  EXPECT_EQ(order, "12");
}

TEST_P(NetworkContract, AStreamCarriesBytesBothWaysInOrder) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  EXPECT_EQ(pair.at_server.peers.at(0).address, kLoopback);
  ASSERT_TRUE(pair.client->send(as_bytes("how ")).ok());
  ASSERT_TRUE(pair.client->send(as_bytes("deep?")).ok());
  EXPECT_TRUE(pair.at_server.received.empty()) << "delivered from inside send";
  ASSERT_TRUE(world_->run_until([&] { return pair.at_server.received == "how deep?"; }));
  ASSERT_TRUE(pair.server->send(pair.at_server.sessions.at(0), as_bytes("by the mark, twain")).ok());
  EXPECT_TRUE(world_->run_until([&] { return pair.at_client.received == "by the mark, twain"; }));
}

TEST_P(NetworkContract, AStreamCarriesMoreThanASocketBufferHolds) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  std::string sent;
  for (int i = 0; i < 64; ++i) {
    const std::string piece(50000, static_cast<char>('a' + i % 26));
    while (!pair.client->send(as_bytes(piece)).ok()) world_->settle();
    sent += piece;
  }
  ASSERT_TRUE(world_->run_until([&] { return pair.at_server.received.size() >= sent.size(); }));
  EXPECT_TRUE(pair.at_server.received == sent);
}

TEST_P(NetworkContract, AStreamRefusesMoreThanItsQueueHolds) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  const ByteBuffer piece(kStreamQueueBytesMax / 4, 1);
  Status status = Done{};
  for (int i = 0; i < 200 && status.ok(); ++i) status = pair.client->send(piece);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.fault().reason, Reason::transport);
  status = Done{};
  for (int i = 0; i < 200 && status.ok(); ++i) {
    status = pair.server->send(pair.at_server.sessions.at(0), piece);
  }
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.fault().reason, Reason::transport);
}

TEST_P(NetworkContract, ConnectingToNobodyIsRefused) {
  const Endpoint nobody = [&] { return network_.server({kLoopback, 0})->local(); }();
  ClientDiary diary;
  const auto client = network_.client(nobody);
  client->on_event(&diary);
  client->open();
  EXPECT_TRUE(diary.events.empty()) << "called from inside open";
  ASSERT_TRUE(world_->run_until([&] { return !diary.events.empty(); }));
  EXPECT_THAT(diary.events, ElementsAre("closed: connection refused"));
}

TEST_P(NetworkContract, SendingOnAClosedStreamIsAFault) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  const SessionId session = pair.at_server.sessions.at(0);
  pair.client->close();
  EXPECT_FALSE(pair.client->send(as_bytes("x")).ok());
  ASSERT_TRUE(world_->run_until([&] { return !pair.at_server.closed.empty(); }));
  EXPECT_THAT(pair.at_server.closed, ElementsAre(session));
  EXPECT_FALSE(pair.server->send(session, as_bytes("x")).ok());
  EXPECT_FALSE(pair.server->send(session + 77, as_bytes("x")).ok());
  EXPECT_THAT(pair.at_client.events, ElementsAre("open")) << "closing is silent at the side that closes";
}

TEST_P(NetworkContract, BytesSentBeforeClosingStillArrive) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  ASSERT_TRUE(pair.client->send(as_bytes("last words")).ok());
  pair.client->close();
  ASSERT_TRUE(world_->run_until([&] { return !pair.at_server.closed.empty(); }));
  EXPECT_EQ(pair.at_server.received, "last words");
}

TEST_P(NetworkContract, AClientLearnsThatTheServerClosedItsSession) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  pair.server->close(pair.at_server.sessions.at(0));
  ASSERT_TRUE(world_->run_until([&] { return pair.at_client.events.size() == 2; }));
  EXPECT_THAT(pair.at_client.events, ElementsAre("open", "closed: closed by the peer"));
  world_->settle();
  EXPECT_THAT(pair.at_server.events, ElementsAre("accepted"));
}

TEST_P(NetworkContract, AClientLearnsThatTheServerDiedAndReconnectsWhenItReturns) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  const Endpoint address = pair.server->local();
  pair.server.reset();
  ASSERT_TRUE(world_->run_until([&] { return pair.at_client.events.size() == 2; }));
  pair.client->open();
  ASSERT_TRUE(world_->run_until([&] { return pair.at_client.events.size() == 3; }));
  EXPECT_EQ(pair.at_client.events.back(), "closed: connection refused");

  pair.server = network_.server(address);
  pair.server->on_event(&pair.at_server);
  pair.client->open();
  ASSERT_TRUE(world_->run_until([&] { return pair.at_client.events.size() == 4; }));
  EXPECT_EQ(pair.at_client.events.back(), "open");
  ASSERT_TRUE(world_->run_until([&] { return pair.at_server.sessions.size() == 2; }));
  EXPECT_NE(pair.at_server.sessions[0], pair.at_server.sessions[1]) << "a session number was used twice";
}

TEST_P(NetworkContract, OpeningAgainClosesTheOldConnectionSilently) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  pair.client->open();
  ASSERT_TRUE(world_->run_until(
      [&] { return pair.at_server.sessions.size() == 2 && pair.at_client.events.size() == 2; }));
  ASSERT_TRUE(world_->run_until([&] { return !pair.at_server.closed.empty(); }));
  EXPECT_THAT(pair.at_client.events, ElementsAre("open", "open"));
  EXPECT_THAT(pair.at_server.closed, ElementsAre(pair.at_server.sessions.at(0)));
  ASSERT_TRUE(pair.client->send(as_bytes("second")).ok());
  EXPECT_TRUE(world_->run_until([&] { return pair.at_server.received == "second"; }));
}

TEST_P(NetworkContract, ClosingWhileConnectingSaysNothing) {
  const auto server = network_.server({kLoopback, 0});
  ClientDiary diary;
  const auto client = network_.client(server->local());
  client->on_event(&diary);
  client->open();
  client->close();
  world_->settle();
  EXPECT_TRUE(diary.events.empty());
}

TEST_P(NetworkContract, TheServerSeesTheSourceAddressOfItsClient) {
  constexpr std::uint32_t kOther = 0x7f000002;
  const auto server = network_.server({kLoopback, 0});
  ServerDiary diary;
  server->on_event(&diary);
  const auto client = network_.client(server->local(), {kOther, 0});
  client->open();
  ASSERT_TRUE(world_->run_until([&] { return !diary.peers.empty(); }));
  EXPECT_EQ(diary.peers[0].address, kOther);
  EXPECT_NE(diary.peers[0].port, 0);
}

TEST_P(NetworkContract, ServesSeveralSessionsAtOnce) {
  Connected first(*world_);
  ASSERT_TRUE(first.ok);
  ClientDiary second_diary;
  const auto second = network_.client(first.server->local());
  second->on_event(&second_diary);
  second->open();
  ASSERT_TRUE(world_->run_until([&] { return first.at_server.sessions.size() == 2; }));
  ASSERT_TRUE(first.server->send(first.at_server.sessions[1], as_bytes("two")).ok());
  ASSERT_TRUE(first.server->send(first.at_server.sessions[0], as_bytes("one")).ok());
  ASSERT_TRUE(
      world_->run_until([&] { return !first.at_client.received.empty() && !second_diary.received.empty(); }));
  EXPECT_EQ(first.at_client.received, "one");
  EXPECT_EQ(second_diary.received, "two");
}

TEST_P(NetworkContract, AClientMayBeDestroyedInItsOwnHandlers) {
  for (const int at_event : {1, 2, 3}) {  // opened, bytes, closed
    Connected pair(*world_);
    ASSERT_TRUE(pair.ok);
    ClientDiary diary;
    auto victim = network_.client(pair.server->local());
    victim->on_event(&diary);
    int events = 0;
    diary.then = [&] {
      if (++events == at_event) victim.reset();
    };
    victim->open();
    ASSERT_TRUE(world_->run_until([&] { return pair.at_server.sessions.size() == 2; }));
    const SessionId session = pair.at_server.sessions[1];
    (void)pair.server->send(session, as_bytes("x"));
    ASSERT_TRUE(world_->run_until([&] { return at_event == 1 ? events == 1 : events == 2; }));
    pair.server->close(session);
    ASSERT_TRUE(world_->run_until([&] { return victim == nullptr; }));
    world_->settle();
    EXPECT_EQ(events, at_event);
  }
}

TEST_P(NetworkContract, AServerMayBeDestroyedInItsOwnHandlers) {
  for (const int at_event : {1, 2, 3}) {  // accepted, bytes, closed
    auto server = network_.server({kLoopback, 0});
    ServerDiary diary;
    server->on_event(&diary);
    int events = 0;
    diary.then = [&] {
      if (++events == at_event) server.reset();
    };
    ClientDiary client_diary;
    const auto client = network_.client(server->local());
    client->on_event(&client_diary);
    client->open();
    ASSERT_TRUE(world_->run_until([&] { return !client_diary.events.empty(); }));
    (void)client->send(as_bytes("x"));
    ASSERT_TRUE(world_->run_until([&] { return at_event == 1 ? events == 1 : events == 2; }));
    client->close();
    ASSERT_TRUE(world_->run_until([&] { return server == nullptr; }));
    world_->settle();
    EXPECT_EQ(events, at_event);
  }
}

TEST_P(NetworkContract, AServerMayCloseASessionFromItsHandler) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  pair.at_server.then = [&] { pair.server->close(pair.at_server.sessions.at(0)); };
  ASSERT_TRUE(pair.client->send(as_bytes("go away")).ok());
  ASSERT_TRUE(world_->run_until([&] { return pair.at_client.events.size() == 2; }));
  EXPECT_EQ(pair.at_client.events.back(), "closed: closed by the peer");
}

TEST_P(NetworkContract, AClientMayReopenFromItsClosedHandler) {
  Connected pair(*world_);
  ASSERT_TRUE(pair.ok);
  pair.at_client.then = [&] {
    if (pair.at_client.events.back() != "open") pair.client->open();
  };
  pair.server->close(pair.at_server.sessions.at(0));
  ASSERT_TRUE(world_->run_until([&] { return pair.at_server.sessions.size() == 2; }));
  ASSERT_TRUE(world_->run_until([&] { return pair.at_client.events.size() == 3; }));
  EXPECT_EQ(pair.at_client.events.back(), "open");
}

}  // namespace
}  // namespace motionlab
