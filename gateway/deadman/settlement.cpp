#include "gateway/deadman/settlement.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>

#include "drivers/core/asio_network.hpp"

namespace motionlab::deadman {
namespace {

constexpr auto kStep = std::chrono::milliseconds{1};

}  // namespace

bool Outcome::settled() const noexcept {
  return arm == BrakeSequence::End::at_rest &&
         (winch == WinchSettler::End::at_rest || winch == WinchSettler::End::nothing_to_settle);
}

std::string Outcome::text(const WireConfig& config) const {
  std::string text;
  switch (arm) {
    case BrakeSequence::End::at_rest:
      text = "the arm is at rest";
      break;
    case BrakeSequence::End::moving:
      text = "the arm was told to stop and still moves: use the stop button";
      break;
    case BrakeSequence::End::not_yet:
    case BrakeSequence::End::silent:
      text = "the robot computer at " + to_string(config.arm.robot_computer) +
             " was told to stop and does not answer: look at the arm before you go near it";
      break;
  }
  switch (winch) {
    case WinchSettler::End::at_rest:
      return text + "; the winch is at rest";
    case WinchSettler::End::nothing_to_settle:
      return text + "; the winch is only listened to, there is nothing to settle";
    case WinchSettler::End::moving:
      return text + "; the winch was told to stop and was not seen at rest: look at it, use the stop button";
    case WinchSettler::End::not_yet:
    case WinchSettler::End::unreachable:
      break;
  }
  return text + "; the winch's controller at " + to_string(config.plc) +
         " does not answer: its own watchdog should have stopped it, look at the winch";
}

struct Settlement::Impl {
  Impl(const WireConfig& c, const Clock& clock_in)
      : config(c), clock(clock_in), network(io, clock), stream(network.client(c.plc)), timer(io) {}

  void send(LabTime now) {
    if (const auto command = brake->due(now)) {
      // A datagram that does not leave is followed by the next, which goes on from what should have left.
      (void)socket->send(config.arm.robot_computer, comau::encode(*command));
    }
  }

  void take(Bytes datagram, Endpoint from) {
    const Endpoint& expected = config.arm.robot_computer;
    if (from.address != expected.address || (expected.port != 0 && from.port != expected.port)) return;
    const auto answer = comau::decode_answer(datagram);
    if (!answer) return;
    const LabTime now = clock.now();
    brake->heard(*answer, now);
    send(now);
  }

  void step() {
    const LabTime now = clock.now();
    send(now);
    winch->step(now);
    if (brake->end(now) != BrakeSequence::End::not_yet && winch->end() != WinchSettler::End::not_yet) {
      io.stop();
      return;
    }
    timer.expires_after(kStep);
    timer.async_wait([this](const boost::system::error_code& cancelled) {
      if (!cancelled) step();
    });
  }

  WireConfig config;
  const Clock& clock;
  boost::asio::io_context io{1};
  AsioNetwork network;
  std::unique_ptr<DatagramSocket> socket;
  std::unique_ptr<StreamClient> stream;
  boost::asio::steady_timer timer;
  std::optional<BrakeSequence> brake;
  std::optional<WinchSettler> winch;
};

Settlement::Settlement(const WireConfig& config, const Clock& clock)
    : impl_(std::make_unique<Impl>(config, clock)) {}

Settlement::~Settlement() = default;

void Settlement::open(Endpoint local) {
  impl_->socket = impl_->network.datagram(local);
}

void Settlement::begin(const std::optional<Said>& last) {
  Impl& s = *impl_;
  const LabTime now = s.clock.now();
  s.brake.emplace(BrakeSequence::Config{.shaper = comau::shaper_config(s.config.arm),
                                        .robot_brakes_after_s = s.config.robot_brakes_after_s},
                  now, last);
  s.send(now);
  s.socket->on_datagram([&s](Bytes datagram, Endpoint from, LabTime) { s.take(datagram, from); });
  s.winch.emplace(s.config.winch, *s.stream, now);
  s.stream->on_event(s.winch->events());
}

Outcome Settlement::finish() {
  Impl& s = *impl_;
  s.step();
  s.io.run();
  return {s.brake->end(s.clock.now()), s.winch->end()};
}

}  // namespace motionlab::deadman
