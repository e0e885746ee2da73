// The winch that a dead gateway has left behind, on the simulated PLC.
#include "gateway/deadman/winch_settler.hpp"

#include <gtest/gtest.h>

#include "tests/winch/winch_bench.hpp"

namespace motionlab::deadman {
namespace {

using End = WinchSettler::End;

/// A gateway that was moving the winch dies without a word; somebody settles.
class Wake : public winch::Bench {
 public:
  void die_in_motion() {
    engage();
    command = make(topic::WinchCommandMode::velocity, true, 0.1);
    run(300ms);
    ASSERT_GT(device_->set_point_m(), 2.0);
    command.reset();
    driver_.reset();
    client_.reset();
  }

  End settle(const winch::DriverConfig& config = {}, Endpoint plc = kPlc) {
    const auto stream = network_.client(plc, kGateway);
    WinchSettler settler(config, *stream, clock_.now());
    stream->on_event(settler.events());
    const LabTime begun = clock_.now();
    while (settler.end() == End::not_yet && clock_.now() - begun < 30s) {
      pass(1ms);
      settler.step(clock_.now());
    }
    stream->on_event(nullptr);
    return settler.end();
  }

  /// Time passes for the PLC.
  void pass(Nanoseconds duration) {
    for (const LabTime end = clock_.now() + duration; clock_.now() < end;) {
      network_.run_until(clock_.now() + 1ms);
      cycle();
    }
  }

 private:
  void cycle() {
    const LabTime t = clock_.now();
    device_->step(t);
    if (to_ns(t) % 5'000'000 != 0 || !plc_alive) return;
    const double length = device_->brake_closed() ? length_m_ : device_->set_point_m();
    device_->cycle(t, winch::Measurement{length, (length - length_m_) / 0.005, 0.5, 41.0});
    length_m_ = length;
  }
  double length_m_ = 2.0;
};

TEST(WinchSettler, BringsTheWinchToRest) {
  Wake wake;
  wake.die_in_motion();
  EXPECT_EQ(wake.settle(), End::at_rest);
  const double length_m = wake.device_->set_point_m();
  wake.pass(10s);
  EXPECT_TRUE(wake.device_->brake_closed());
  EXPECT_NEAR(wake.device_->set_point_m(), length_m, 1e-3);
}

TEST(WinchSettler, FindsAWinchThatRestsAndSaysSo) {
  Wake wake;
  wake.driver_.reset();
  wake.client_.reset();
  EXPECT_EQ(wake.settle(), End::at_rest);
}

TEST(WinchSettler, SaysThatNobodyAnswers) {
  Wake wake;
  wake.die_in_motion();
  EXPECT_EQ(wake.settle({}, {winch::Bench::kPlc.address, 1}), End::unreachable);
}

TEST(WinchSettler, OpensNothingWhereTheWinchIsOnlyListenedTo) {
  Wake wake;
  wake.driver_.reset();
  wake.client_.reset();
  winch::DriverConfig legacy;
  legacy.profile = winch::Profile::legacy;
  EXPECT_EQ(wake.settle(legacy), End::nothing_to_settle);
}

}  // namespace
}  // namespace motionlab::deadman
