// What each fault of a wire does to what passes it, on a memory network between a device and a peer.
#include "simulators/faults/faulty_wire.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/core/memory_network.hpp"
#include "simulators/faults/wire_faults.hpp"

namespace motionlab::faults {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

struct Arrival {
  ByteBuffer bytes;
  Endpoint from;
  LabTime t;
  bool operator==(const Arrival&) const = default;
};

std::vector<ByteBuffer> bytes_of(const std::vector<Arrival>& arrivals) {
  std::vector<ByteBuffer> all;
  for (const auto& arrival : arrivals) all.push_back(arrival.bytes);
  return all;
}

ByteBuffer numbered(std::uint8_t number) {
  return {number, 0x55, 0xaa, number};
}

std::vector<ByteBuffer> counted(int from, int to) {
  std::vector<ByteBuffer> all;
  for (int n = from; n <= to; ++n) all.push_back(numbered(static_cast<std::uint8_t>(n)));
  return all;
}

/// Bits in which two texts of one length differ.
int distance(const ByteBuffer& a, const ByteBuffer& b) {
  int bits = 0;
  for (std::size_t i = 0; i < a.size(); ++i) bits += std::popcount(static_cast<unsigned>(a[i] ^ b[i]));
  return bits;
}

// Datagrams

/// A device behind the faulty wire and a peer before it; each sends a numbered datagram every millisecond.
class DatagramWire : public testing::Test {
 protected:
  DatagramWire() { build(1); }

  void build(std::uint64_t seed) {
    device_.reset();
    peer_.reset();
    wire_ = std::make_unique<FaultyWire>(network_, seed, "device");
    device_ = wire_->datagram(device_at_);
    peer_ = network_.datagram(peer_at_);
    listen(*device_, at_device_);
    listen(*peer_, at_peer_);
  }
  static void listen(DatagramSocket& socket, std::vector<Arrival>& to) {
    socket.on_datagram([&to](Bytes bytes, Endpoint from, LabTime t) {
      to.push_back({{bytes.begin(), bytes.end()}, from, t});
    });
  }
  void fault(std::string_view name, bool active = true, double value = 0) {
    const Status done = wire_->set_fault(name, active, value);
    ASSERT_TRUE(done) << done.fault().text;
  }
  /// Both send the numbers `from` to `to`.
  void exchange(int from, int to) {
    for (int n = from; n <= to; ++n) {
      network_.run_until(clock_.now() + 1ms);
      wire_->step(clock_.now());
      (void)device_->send(peer_at_, numbered(static_cast<std::uint8_t>(n)));
      (void)peer_->send(device_at_, numbered(static_cast<std::uint8_t>(n)));
    }
    settle(0ms);
  }
  void settle(Nanoseconds duration) {
    const LabTime end = clock_.now() + duration;
    do {
      network_.run_until(std::min(end, clock_.now() + 1ms));
      wire_->step(clock_.now());
      network_.deliver_due(clock_.now());
    } while (clock_.now() < end);
  }
  void expect_well_again() {
    settle(100ms);
    at_peer_.clear();
    at_device_.clear();
    exchange(1, 100);
    EXPECT_EQ(bytes_of(at_peer_), counted(1, 100));
    EXPECT_EQ(bytes_of(at_device_), counted(1, 100));
  }

  const Endpoint device_at_ = Endpoint::parse("127.0.0.1:50032");
  const Endpoint peer_at_ = Endpoint::parse("127.0.0.1:50042");
  SteppedClock clock_;
  MemoryNetwork network_{clock_};
  std::unique_ptr<FaultyWire> wire_;
  std::unique_ptr<DatagramSocket> device_, peer_;
  std::vector<Arrival> at_device_, at_peer_;
};

TEST_F(DatagramWire, WithoutAFaultPassesEverythingAtOnceWithItsSenderAndItsTime) {
  exchange(1, 100);
  EXPECT_EQ(bytes_of(at_peer_), counted(1, 100));
  EXPECT_EQ(bytes_of(at_device_), counted(1, 100));
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(at_device_[i].from, peer_at_);
    EXPECT_EQ(at_peer_[i].from, device_at_);
    EXPECT_EQ(at_device_[i].t, at_peer_[i].t);
  }
  EXPECT_EQ(device_->local(), device_at_);
}

TEST_F(DatagramWire, CutPassesNothingEitherWayAndKeepsNothingForLater) {
  exchange(1, 10);
  fault("cut");
  exchange(11, 50);
  fault("cut", false);
  exchange(51, 60);
  auto expected = counted(1, 10);
  const auto rest = counted(51, 60);
  expected.insert(expected.end(), rest.begin(), rest.end());
  EXPECT_EQ(bytes_of(at_peer_), expected);
  EXPECT_EQ(bytes_of(at_device_), expected);
}

TEST_F(DatagramWire, LossLosesItsShareBothWaysAndKeepsOrder) {
  fault("loss", true, 0.3);
  for (int i = 0; i < 20; ++i) exchange(0, 99);
  EXPECT_NEAR(static_cast<double>(at_peer_.size()), 1400, 80);  // 4 sigma
  EXPECT_NEAR(static_cast<double>(at_device_.size()), 1400, 80);
  fault("loss", false);
  expect_well_again();
}

TEST_F(DatagramWire, BurstLosesATenthInRunsOfTheGivenLength) {
  fault("burst", true, 20);
  std::vector<bool> arrived;
  for (int i = 0; i < 200; ++i) {
    at_peer_.clear();
    exchange(0, 99);
    std::vector<bool> block(100, false);
    for (const auto& arrival : at_peer_) block[arrival.bytes[0]] = true;
    arrived.insert(arrived.end(), block.begin(), block.end());
  }
  EXPECT_NEAR(static_cast<double>(std::count(arrived.begin(), arrived.end(), false)), 2000, 800);
  std::size_t run = 0;
  for (const bool here : arrived) {
    if (here) {
      EXPECT_EQ(run % 20, 0U);  // two runs may follow each other
      run = 0;
    } else {
      ++run;
    }
  }
  fault("burst", false);
}

TEST_F(DatagramWire, JitterDelaysWithinItsBoundAndLetsNothingOvertake) {
  fault("jitter", true, 0.02);
  exchange(1, 200);
  settle(30ms);
  EXPECT_EQ(bytes_of(at_peer_), counted(1, 200));
  EXPECT_EQ(bytes_of(at_device_), counted(1, 200));
  Nanoseconds latest{0};
  for (std::size_t i = 0; i < at_peer_.size(); ++i) {
    const Nanoseconds delay = at_peer_[i].t - (LabTime{} + 1ms * static_cast<int>(i + 1));
    EXPECT_GE(delay, 0ms);
    EXPECT_LE(delay, 21ms);  // and one step
    latest = std::max(latest, delay);
  }
  EXPECT_GE(latest, 15ms);
  fault("jitter", false);
  expect_well_again();
}

TEST_F(DatagramWire, WhatWaitsWhenJitterEndsIsNotOvertakenByWhatIsSentThen) {
  fault("jitter", true, 1.0);
  exchange(1, 20);
  fault("jitter", false);
  exchange(21, 40);
  settle(1s);
  EXPECT_EQ(bytes_of(at_peer_), counted(1, 40));
  EXPECT_EQ(bytes_of(at_device_), counted(1, 40));
}

TEST_F(DatagramWire, ReorderSwapsNeighboursAndLosesNothing) {
  fault("reorder", true, 1.0);
  exchange(1, 100);
  std::vector<ByteBuffer> swapped;
  for (int n = 1; n <= 100; n += 2) {
    swapped.push_back(numbered(static_cast<std::uint8_t>(n + 1)));
    swapped.push_back(numbered(static_cast<std::uint8_t>(n)));
  }
  EXPECT_EQ(bytes_of(at_peer_), swapped);
  EXPECT_EQ(bytes_of(at_device_), swapped);
  fault("reorder", false);
  expect_well_again();
}

TEST_F(DatagramWire, TheDatagramThatIsHeldForReorderingLeavesWhenTheFaultEnds) {
  fault("reorder", true, 1.0);
  exchange(1, 1);
  EXPECT_THAT(at_peer_, IsEmpty());
  fault("reorder", false);
  settle(1ms);
  EXPECT_EQ(bytes_of(at_peer_), counted(1, 1));
}

TEST_F(DatagramWire, DuplicateSendsTheSameBytesTwice) {
  fault("duplicate", true, 1.0);
  exchange(1, 50);
  ASSERT_EQ(at_peer_.size(), 100U);
  for (std::size_t i = 0; i < 100; i += 2) EXPECT_EQ(at_peer_[i], at_peer_[i + 1]);
  EXPECT_EQ(at_device_.size(), 100U);
  fault("duplicate", false);
  expect_well_again();
}

TEST_F(DatagramWire, CorruptFlipsExactlyOneBit) {
  fault("corrupt", true, 1.0);
  exchange(1, 100);
  const auto sent = counted(1, 100);
  ASSERT_EQ(at_peer_.size(), 100U);
  ASSERT_EQ(at_device_.size(), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    EXPECT_EQ(distance(at_peer_[i].bytes, sent[i]), 1);
    EXPECT_EQ(distance(at_device_[i].bytes, sent[i]), 1);
  }
  fault("corrupt", false);
  expect_well_again();
}

TEST_F(DatagramWire, TruncateLeavesAPrefix) {
  fault("truncate", true, 1.0);
  exchange(1, 100);
  const auto sent = counted(1, 100);
  ASSERT_EQ(at_peer_.size(), 100U);
  std::array<int, 4> lengths{};
  for (std::size_t i = 0; i < 100; ++i) {
    const ByteBuffer& got = at_peer_[i].bytes;
    ASSERT_LT(got.size(), sent[i].size());
    EXPECT_TRUE(std::equal(got.begin(), got.end(), sent[i].begin()));
    ++lengths[got.size()];
  }
  EXPECT_THAT(lengths, Each(testing::Gt(0)));  // every length, the empty datagram too
  fault("truncate", false);
  expect_well_again();
}

TEST_F(DatagramWire, ForeignAddsAChangedCopyFromAnotherAddressBothWays) {
  fault("foreign", true, 1.0);
  exchange(1, 20);
  const auto sent = counted(1, 20);
  for (const auto* const arrivals : {&at_peer_, &at_device_}) {
    ASSERT_EQ(arrivals->size(), 40U);
    const Endpoint right = arrivals == &at_peer_ ? device_at_ : peer_at_;
    for (std::size_t i = 0; i < 40; i += 2) {
      EXPECT_EQ((*arrivals)[i].bytes, sent[i / 2]);
      EXPECT_EQ((*arrivals)[i].from, right);
      EXPECT_EQ(distance((*arrivals)[i + 1].bytes, sent[i / 2]), 1);
      EXPECT_NE((*arrivals)[i + 1].from.address, right.address);
    }
  }
  fault("foreign", false);
  expect_well_again();
}

TEST_F(DatagramWire, AShareOfATenthIsTheDefault) {
  for (const std::string name : {"loss", "duplicate"}) {
    at_peer_.clear();
    fault(name);
    for (int i = 0; i < 20; ++i) exchange(0, 99);
    fault(name, false);
    EXPECT_NEAR(static_cast<double>(at_peer_.size()), name == "loss" ? 1800 : 2200, 60) << name;
  }
}

TEST_F(DatagramWire, TheSameSeedGivesTheSameFaultsAndAnotherSeedOthers) {
  const auto run = [this](std::uint64_t seed) {
    build(seed);
    at_peer_.clear();
    for (const char* const name :
         {"loss", "jitter", "reorder", "duplicate", "corrupt", "truncate", "foreign"}) {
      fault(name, true, name == std::string("jitter") ? 0.005 : 0.2);
    }
    const LabTime start = clock_.now();
    exchange(1, 200);
    for (auto& arrival : at_peer_) {
      arrival.t = LabTime{} + (arrival.t - start);
      arrival.from.port = arrival.from == device_at_ ? arrival.from.port : std::uint16_t{0};  // drawn anew
    }
    return at_peer_;
  };
  const auto first = run(7);
  EXPECT_GT(first.size(), 100U);
  EXPECT_EQ(first, run(7));
  EXPECT_NE(first, run(8));
}

TEST_F(DatagramWire, RefusesAnUnknownFaultWithTheNamesThatThereAre) {
  const Status refused = wire_->set_fault("gremlins", true);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.fault().reason, Reason::refused);
  for (const char* const name : {"cut", "loss", "burst", "jitter", "reorder", "duplicate", "corrupt",
                                 "truncate", "foreign", "clock-jump"}) {
    EXPECT_THAT(std::string(refused.fault().text), HasSubstr(name));
    EXPECT_THAT(std::string(WireFaults::kNames), HasSubstr(name));
    EXPECT_TRUE(WireFaults::knows(name));
  }
}

TEST_F(DatagramWire, RefusesAClockJumpOfADeviceWithoutAClock) {
  const Status refused = wire_->set_fault("clock-jump", true, 5);
  ASSERT_FALSE(refused);
  EXPECT_THAT(std::string(refused.fault().text), HasSubstr("no clock"));
}

TEST(ClockJump, IsToldToTheDeviceAndTakenBack) {
  SteppedClock clock;
  MemoryNetwork network(clock);
  std::vector<Nanoseconds> told;
  FaultyWire wire(network, 1, "device", [&](Nanoseconds jump) { told.push_back(jump); });
  EXPECT_TRUE(wire.set_fault("clock-jump", true, -2.5));
  EXPECT_TRUE(wire.set_fault("clock-jump", false));
  EXPECT_TRUE(wire.set_fault("clock-jump", true));
  EXPECT_THAT(told, ElementsAre(-2500ms, 0ms, 1s));
}

// Streams

/// A device's server behind the faulty wire, and a client.
class StreamWire : public testing::Test, protected ServerEvents, protected StreamEvents {
 protected:
  StreamWire() {
    server_->on_event(this);
    client_->on_event(this);
    client_->open();
    settle(10ms);
    EXPECT_TRUE(open_);
    EXPECT_TRUE(session_);
  }
  ~StreamWire() override {
    client_->on_event(nullptr);
    server_->on_event(nullptr);
  }

  void settle(Nanoseconds duration) {
    for (const LabTime end = clock_.now() + duration; clock_.now() < end;) {
      network_.run_until(clock_.now() + 1ms);
      wire_.step(clock_.now());
      network_.deliver_due(clock_.now());
    }
  }
  /// Both send one more letter every millisecond.
  void talk(std::string_view text) {
    for (const char c : text) {
      const ByteBuffer letter{static_cast<std::uint8_t>(c)};
      (void)client_->send(letter);
      (void)server_->send(session_.value_or(0), letter);
      settle(1ms);
    }
  }
  void fault(std::string_view name, bool active, double value = 0) {
    ASSERT_TRUE(wire_.set_fault(name, active, value));
  }

  void on_accepted(SessionId session, Endpoint, LabTime) override { session_ = session; }
  void on_bytes(SessionId, Bytes bytes, LabTime) override { at_server_.append(bytes.begin(), bytes.end()); }
  void on_closed(SessionId, LabTime) override { session_.reset(); }
  void on_open(LabTime) override { open_ = true; }
  void on_bytes(Bytes bytes, LabTime) override { at_client_.append(bytes.begin(), bytes.end()); }
  void on_closed(std::string_view, LabTime) override { open_ = false; }

  SteppedClock clock_;
  MemoryNetwork network_{clock_};
  FaultyWire wire_{network_, 1, "device"};
  std::unique_ptr<StreamServer> server_ = wire_.server(Endpoint::parse("127.0.0.1:48898"));
  std::unique_ptr<StreamClient> client_ = network_.client(Endpoint::parse("127.0.0.1:48898"));
  std::optional<SessionId> session_;
  std::string at_server_, at_client_;
  bool open_ = false;
};

TEST_F(StreamWire, CutNeitherSpeaksNorClosesAndLosesNothingWhenItIsWholeAgain) {
  talk("abc");
  fault("cut", true);
  talk("defg");
  EXPECT_EQ(at_server_, "abc");
  EXPECT_EQ(at_client_, "abc");
  EXPECT_TRUE(open_);
  EXPECT_TRUE(session_);
  fault("cut", false);
  talk("hi");
  settle(5ms);
  EXPECT_EQ(at_server_, "abcdefghi");
  EXPECT_EQ(at_client_, "abcdefghi");
}

TEST_F(StreamWire, AConnectionThatBeginsInACutWireIsNotSeenBeforeItIsWhole) {
  client_->close();
  settle(5ms);
  EXPECT_FALSE(session_);
  fault("cut", true);
  client_->open();
  settle(50ms);
  (void)client_->send(ByteBuffer{'x'});
  settle(50ms);
  EXPECT_FALSE(session_);
  fault("cut", false);
  settle(5ms);
  EXPECT_TRUE(session_);
  EXPECT_EQ(at_server_, "x");
}

TEST_F(StreamWire, TheDeviceLearnsThatItsPeerHasGoneOnlyWhenTheWireIsWhole) {
  fault("cut", true);
  client_->close();
  settle(50ms);
  EXPECT_TRUE(session_);
  fault("cut", false);
  settle(5ms);
  EXPECT_FALSE(session_);
}

TEST_F(StreamWire, ACloseByTheDeviceLeavesBehindWhatItSaidBefore) {
  fault("cut", true);
  (void)server_->send(*session_, ByteBuffer{'l', 'a', 's', 't'});
  server_->close(*session_);
  (void)client_->send(ByteBuffer{'n', 'o'});
  settle(50ms);
  EXPECT_TRUE(open_);
  fault("cut", false);
  settle(5ms);
  EXPECT_EQ(at_client_, "last");
  EXPECT_FALSE(open_);
  EXPECT_EQ(at_server_, "");
}

TEST_F(StreamWire, JitterKeepsEveryByteInItsPlace) {
  fault("jitter", true, 0.02);
  const std::string text = "the quick brown fox jumps over the lazy dog";
  talk(text);
  EXPECT_LT(at_client_.size(), text.size());
  settle(25ms);
  EXPECT_EQ(at_client_, text);
  EXPECT_EQ(at_server_, text);
  fault("jitter", false);
}

TEST_F(StreamWire, ACutWireTakesNoMoreThanAKernelWould) {
  fault("cut", true);
  const ByteBuffer block(1 << 18, 'x');
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(server_->send(*session_, block));
  EXPECT_FALSE(server_->send(*session_, block));
}

TEST_F(StreamWire, RefusesWhatTcpHidesAndSaysWhy) {
  for (const char* const name : {"loss", "burst", "reorder", "duplicate", "corrupt", "truncate", "foreign"}) {
    const Status refused = wire_.set_fault(name, true);
    ASSERT_FALSE(refused) << name;
    EXPECT_EQ(refused.fault().reason, Reason::refused);
    EXPECT_THAT(std::string(refused.fault().text), HasSubstr("TCP")) << name;
  }
  talk("all is well");
  EXPECT_EQ(at_client_, "all is well");
}

}  // namespace
}  // namespace motionlab::faults
