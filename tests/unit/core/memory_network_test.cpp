#include "drivers/core/memory_network.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace motionlab {
namespace {

using testing::ElementsAre;

constexpr Endpoint kA{0x7f000001, 1001};
constexpr Endpoint kB{0x7f000001, 1002};

/// A sender, a receiver and what the receiver saw.
class MemoryDatagrams : public testing::Test {
 protected:
  void listen() {
    b_->on_datagram([this](Bytes bytes, Endpoint, LabTime t) {
      seen_.emplace_back(as_text(bytes));
      arrivals_.push_back(t);
    });
  }
  void send(int count) {
    for (int i = 0; i < count; ++i) {
      (void)a_->send(kB, as_bytes(std::to_string(i)));
      network_.run_until(clock_.now() + 1ms);
    }
    network_.run_until(clock_.now() + 1s);
  }

  SteppedClock clock_;
  MemoryNetwork network_{clock_, {.latency = 250us, .seed = 7}};
  std::unique_ptr<DatagramSocket> a_ = network_.datagram(kA);
  std::unique_ptr<DatagramSocket> b_ = network_.datagram(kB);
  std::vector<std::string> seen_;
  std::vector<LabTime> arrivals_;
};

TEST_F(MemoryDatagrams, ArriveAfterTheLatencyAndAreStampedWithIt) {
  listen();
  ASSERT_TRUE(a_->send(kB, as_bytes("x")).ok());
  EXPECT_EQ(network_.next_due(), LabTime{250us});
  network_.run_until(LabTime{249us});
  EXPECT_TRUE(seen_.empty());
  network_.run_until(LabTime{10ms});
  EXPECT_THAT(arrivals_, ElementsAre(LabTime{250us}));
  EXPECT_EQ(clock_.now(), LabTime{10ms});
  EXPECT_EQ(network_.next_due(), std::nullopt);
}

TEST_F(MemoryDatagrams, AreShownAsTheyAreSentWhateverBecomesOfThem) {
  listen();
  network_.set_datagram_fault(kB, {.silent = true});
  network_.on_sent([this](Endpoint from, Endpoint to, Bytes bytes, LabTime t) {
    EXPECT_EQ(from, kA);
    EXPECT_EQ(to, kB);
    seen_.emplace_back(as_text(bytes));
    arrivals_.push_back(t);
  });
  send(2);
  EXPECT_THAT(seen_, ElementsAre("0", "1"));
  EXPECT_THAT(arrivals_, ElementsAre(LabTime{0ms}, LabTime{1ms}));
  network_.on_sent({});
  send(1);
  EXPECT_EQ(seen_.size(), 2u);
}

TEST_F(MemoryDatagrams, AHandlerSeesTheTimeOfTheArrival) {
  LabTime seen_at{};
  b_->on_datagram([&](Bytes, Endpoint, LabTime) { seen_at = clock_.now(); });
  ASSERT_TRUE(a_->send(kB, {}).ok());
  network_.run_until(LabTime{10ms});
  EXPECT_EQ(seen_at, LabTime{250us});
}

TEST_F(MemoryDatagrams, DeliverDueLeavesTheClockAlone) {
  listen();
  ASSERT_TRUE(a_->send(kB, as_bytes("x")).ok());
  network_.deliver_due(LabTime{1ms});
  EXPECT_THAT(arrivals_, ElementsAre(LabTime{250us}));
  EXPECT_EQ(clock_.now(), LabTime{});
}

TEST_F(MemoryDatagrams, AreDroppedWithoutAHandlerOrASocket) {
  ASSERT_TRUE(a_->send(kB, as_bytes("x")).ok());
  network_.run_until(LabTime{1ms});
  listen();
  ASSERT_TRUE(a_->send(kB, as_bytes("x")).ok());
  b_.reset();
  network_.run_until(LabTime{2ms});
  b_ = network_.datagram(kB);
  EXPECT_TRUE(seen_.empty());
}

TEST_F(MemoryDatagrams, SilenceDropsAllUntilItIsTakenBack) {
  listen();
  network_.set_datagram_fault(kB, {.silent = true});
  send(10);
  EXPECT_TRUE(seen_.empty());
  network_.set_datagram_fault(kB, {});
  send(10);
  EXPECT_EQ(seen_.size(), 10u);
}

TEST_F(MemoryDatagrams, AFaultWithoutAnAddressHoldsForEveryAddressOfThePort) {
  listen();
  network_.set_datagram_fault({0, kB.port}, {.silent = true});
  send(3);
  EXPECT_TRUE(seen_.empty());
}

TEST_F(MemoryDatagrams, AreLostWithTheWantedProbability) {
  listen();
  network_.set_datagram_fault(kB, {.loss = 0.25});
  send(4000);
  EXPECT_NEAR(static_cast<double>(seen_.size()), 3000.0, 120.0);
}

TEST_F(MemoryDatagrams, AreDuplicated) {
  listen();
  network_.set_datagram_fault(kB, {.duplicate = 1.0});
  send(2);
  EXPECT_THAT(seen_, ElementsAre("0", "0", "1", "1"));
}

TEST_F(MemoryDatagrams, AreDelayedAndJitteredWithoutLosingTheirOrder) {
  listen();
  network_.set_datagram_fault(kB, {.delay = 5ms, .jitter = 20ms});
  send(200);
  ASSERT_EQ(seen_.size(), 200u);
  double latency_max_s = 0.0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    EXPECT_EQ(seen_[i], std::to_string(i));
    const double latency_s = seconds(arrivals_[i] - LabTime{i * 1ms});
    EXPECT_GE(latency_s, 5.25e-3);
    latency_max_s = std::max(latency_max_s, latency_s);
  }
  EXPECT_GT(latency_max_s, 20e-3);
  EXPECT_LT(latency_max_s, 25.3e-3);
}

TEST_F(MemoryDatagrams, AreReordered) {
  listen();
  network_.set_datagram_fault(kB, {.reorder = 0.2, .reorder_by = 3ms});
  send(100);
  ASSERT_EQ(seen_.size(), 100u);
  std::size_t overtaken = 0;
  for (std::size_t i = 1; i < seen_.size(); ++i) overtaken += std::stoi(seen_[i]) < std::stoi(seen_[i - 1]);
  EXPECT_GT(overtaken, 5u);
}

TEST_F(MemoryDatagrams, AreCorruptedInExactlyOneByte) {
  std::size_t wrong = 0;
  b_->on_datagram([&](Bytes bytes, Endpoint, LabTime) {
    ASSERT_EQ(bytes.size(), 8u);
    std::size_t changed = 0;
    for (const auto byte : bytes) changed += byte != 'a';
    EXPECT_EQ(changed, 1u);
    ++wrong;
  });
  network_.set_datagram_fault(kB, {.corrupt = 1.0});
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(a_->send(kB, as_bytes("aaaaaaaa")).ok());
  network_.run_until(LabTime{1s});
  EXPECT_EQ(wrong, 100u);
}

TEST(MemoryNetwork, GivesTheSameRunForTheSameSeed) {
  const auto run = [](std::uint64_t seed) {
    SteppedClock clock;
    MemoryNetwork network(clock, {.latency = 1ms, .seed = seed});
    const auto a = network.datagram(kA);
    const auto b = network.datagram(kB);
    std::vector<std::int64_t> arrivals;
    b->on_datagram([&](Bytes bytes, Endpoint, LabTime t) { arrivals.push_back(to_ns(t) + bytes[0]); });
    network.set_datagram_fault(
        kB, {.loss = 0.1, .duplicate = 0.1, .corrupt = 0.3, .reorder = 0.1, .jitter = 3ms});
    for (int i = 0; i < 500; ++i) {
      (void)a->send(kB, as_bytes("x"));
      network.run_until(clock.now() + 1ms);
    }
    return arrivals;
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(MemoryNetwork, ReusesItsBuffersInTheSteadyState) {
  SteppedClock clock;
  MemoryNetwork network(clock);
  const auto a = network.datagram(kA);
  const auto b = network.datagram(kB);
  std::set<const std::uint8_t*> buffers;
  b->on_datagram([&](Bytes bytes, Endpoint, LabTime) { buffers.insert(bytes.data()); });
  const ByteBuffer datagram(100);
  for (int i = 0; i < 1000; ++i) {
    for (int burst = 0; burst < 3; ++burst) ASSERT_TRUE(a->send(kB, datagram).ok());
    network.run_until(clock.now() + 1ms);
  }
  EXPECT_LE(buffers.size(), 4u);
}

TEST(MemoryNetwork, TwoEndsThatAnswerEachOtherCannotHoldTheTimeStill) {
  SteppedClock clock;
  MemoryNetwork network(clock);
  const auto a = network.datagram(kA);
  const auto b = network.datagram(kB);
  int rallies = 0;
  a->on_datagram([&](Bytes bytes, Endpoint from, LabTime) { (void)a->send(from, bytes), ++rallies; });
  b->on_datagram([&](Bytes bytes, Endpoint from, LabTime) { (void)b->send(from, bytes); });
  ASSERT_TRUE(a->send(kB, as_bytes("ping")).ok());
  network.deliver_due(clock.now());
  EXPECT_EQ(rallies, 0) << "the answer waits for a later delivery";
  network.run_until(LabTime{1us});
  EXPECT_EQ(rallies, 500);
  EXPECT_EQ(clock.now(), LabTime{1us});
}

TEST(MemoryNetwork, ASocketOnAnyAddressReceivesForEveryAddress) {
  SteppedClock clock;
  MemoryNetwork network(clock);
  const auto any = network.datagram({0, 2000});
  const auto a = network.datagram(kA);
  int received = 0;
  any->on_datagram([&](Bytes, Endpoint, LabTime) { ++received; });
  ASSERT_TRUE(a->send(Endpoint::parse("192.168.90.13:2000"), {}).ok());
  ASSERT_TRUE(a->send(Endpoint::parse("127.0.0.1:2000"), {}).ok());
  ASSERT_TRUE(a->send(Endpoint::parse("127.0.0.1:2001"), {}).ok());
  network.run_until(LabTime{1ms});
  EXPECT_EQ(received, 2);
}

/// A client and a server, connected, with their last words.
class MemoryStreams : public testing::Test, public StreamEvents, public ServerEvents {
 protected:
  void on_open(LabTime) override { open_ = true; }
  void on_bytes(Bytes bytes, LabTime) override { at_client_.emplace_back(as_text(bytes)); }
  void on_closed(std::string_view why, LabTime t) override {
    open_ = false;
    why_ = why;
    closed_at_ = t;
  }
  void on_accepted(SessionId session, Endpoint, LabTime) override { session_ = session; }
  void on_bytes(SessionId, Bytes bytes, LabTime) override { at_server_.emplace_back(as_text(bytes)); }
  void on_closed(SessionId, LabTime) override { session_ = 0; }

  void SetUp() override {
    server_->on_event(this);
    client_->on_event(this);
  }
  void run(Nanoseconds span) { network_.run_until(clock_.now() + span); }
  void connect() {
    client_->open();
    run(10ms);
    ASSERT_TRUE(open_);
    ASSERT_NE(session_, 0u);
  }

  SteppedClock clock_;
  MemoryNetwork network_{clock_, {.latency = 1ms}};
  std::unique_ptr<StreamServer> server_ = network_.server(kA);
  std::unique_ptr<StreamClient> client_ = network_.client(kA);
  std::vector<std::string> at_client_;
  std::vector<std::string> at_server_;
  std::string why_;
  LabTime closed_at_{};
  SessionId session_ = 0;
  bool open_ = false;
};

TEST_F(MemoryStreams, AreChoppedToTestReassembly) {
  network_.set_stream_fault(kA, {.chunk_bytes = 3});
  connect();
  ASSERT_TRUE(client_->send(as_bytes("abcdefgh")).ok());
  ASSERT_TRUE(server_->send(session_, as_bytes("1234")).ok());
  run(10ms);
  EXPECT_THAT(at_server_, ElementsAre("abc", "def", "gh"));
  EXPECT_THAT(at_client_, ElementsAre("123", "4"));
}

TEST_F(MemoryStreams, AreRefusedOnDemandWhileOpenOnesLiveOn) {
  connect();
  network_.set_stream_fault(kA, {.refuse = true});
  ASSERT_TRUE(client_->send(as_bytes("still here")).ok());
  run(10ms);
  EXPECT_THAT(at_server_, ElementsAre("still here"));
  client_->open();
  run(10ms);
  EXPECT_EQ(why_, close_reason::kRefused);
}

TEST_F(MemoryStreams, ConnectingIntoSilenceTimesOutAfterTwoSeconds) {
  network_.set_stream_fault(kA, {.silent = true});
  client_->open();
  run(1999ms);
  EXPECT_TRUE(why_.empty());
  run(10ms);
  EXPECT_EQ(why_, close_reason::kTimedOut);
  EXPECT_EQ(closed_at_, LabTime{2s});
}

TEST_F(MemoryStreams, HalfOpenNobodyIsToldAndThePeerAnswersWithAResetAfterwards) {
  connect();
  network_.set_stream_fault(kA, {.silent = true});
  ASSERT_TRUE(client_->send(as_bytes("lost")).ok());
  ASSERT_TRUE(server_->send(session_, as_bytes("lost")).ok());
  run(10s);
  EXPECT_TRUE(at_server_.empty());
  EXPECT_TRUE(at_client_.empty());
  EXPECT_TRUE(open_);
  network_.set_stream_fault(kA, {});
  ASSERT_TRUE(client_->send(as_bytes("anybody?")).ok());
  run(10ms);
  EXPECT_FALSE(open_);
  EXPECT_EQ(why_, close_reason::kReset);
  EXPECT_TRUE(at_server_.empty());
}

TEST_F(MemoryStreams, AHalfOpenPeerFillsTheQueue) {
  connect();
  network_.set_stream_fault(kA, {.silent = true});
  const ByteBuffer piece(kStreamQueueBytesMax / 2, 1);
  EXPECT_TRUE(client_->send(piece).ok());
  run(1s);
  EXPECT_TRUE(client_->send(piece).ok());
  run(1s);
  EXPECT_FALSE(client_->send(piece).ok());
}

TEST_F(MemoryStreams, AResetReachesBothEnds) {
  connect();
  network_.reset_streams(kA);
  run(10ms);
  EXPECT_EQ(why_, close_reason::kReset);
  EXPECT_EQ(session_, 0u);
}

TEST_F(MemoryStreams, AreDelayedByTheirFault) {
  network_.set_stream_fault(kA, {.delay = 100ms});
  client_->open();
  run(201ms);
  EXPECT_FALSE(open_);
  run(10ms);
  EXPECT_TRUE(open_);
}

}  // namespace
}  // namespace motionlab
