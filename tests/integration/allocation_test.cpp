// Neither a control step nor a driver takes anything from the heap, once it is under way.
#include <gtest/gtest.h>

#include "tests/integration/counted_network.hpp"
#include "tests/integration/taken_apart.hpp"
#include "tests/support/allocations.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeAction;
using topic::ModeState;

/// Runs on and counts what the control steps allocate.
class Counted {
 public:
  explicit Counted(TakenApart& line) : line_(line) {
    line_.before_control = [this] { before_ = test::allocations; };
    line_.after_control = [this] { total_ += test::allocations - before_; };
  }
  std::size_t during(double seconds_on) {
    total_ = 0;
    line_.run_to(line_.now_s() + seconds_on);
    return total_;
  }

 private:
  TakenApart& line_;
  std::size_t before_ = 0;
  std::size_t total_ = 0;
};

TEST(Allocation, NoControlStepTakesAnythingFromTheHeap) {
  for (const bool tracked : {true, false}) {
    TakenApart line(configure("thesis-wave", 1, tracked));
    Counted counted(line);
    EXPECT_EQ(counted.during(10), 0U) << "settled and ready";
    line.ask(ModeAction::engage);
    EXPECT_EQ(counted.during(10), 0U) << "engaged";
    ASSERT_EQ(line.mode().state, ModeState::engaged);
    line.ask(ModeAction::settle);
    EXPECT_EQ(counted.during(2), 0U) << "stopping";
    ASSERT_EQ(line.mode().state, ModeState::ready);
    line.ask(ModeAction::engage);
    (void)counted.during(2);
    ASSERT_TRUE(line.lab().set_fault("mru1", "silent", true));
    EXPECT_EQ(counted.during(3), 0U) << "fault";
    ASSERT_EQ(line.mode().state, ModeState::fault);
    ASSERT_TRUE(line.lab().set_fault("mru1", "silent", false));
    EXPECT_EQ(counted.during(3), 0U) << "the device is back, after more than the estimator bridges";
    line.ask(ModeAction::reset);
    EXPECT_EQ(counted.during(3), 0U) << "reset";
    ASSERT_TRUE(line.lab().set_fault("qualisys", "occlude", true));
    EXPECT_EQ(counted.during(5), 0U) << "blind";
  }
}

TEST(Allocation, NoDriverTakesAnythingFromTheHeapWhileItHearsAndCommands) {
  const auto config = configure("thesis-wave");
  SteppedClock clock;
  MemoryNetwork wires(clock);
  lab::SimulatedLab lab(config.lab, wires, LabTime{});
  CountedNetwork network(wires);
  bus::LocalBus bus;
  service::ArmSchedule schedule;
  service::Devices devices(config.gateway, network, bus, schedule);
  service::ControlLoop control(config.gateway, bus, schedule);
  auto requests = bus.advertise<topic::ModeRequest>();
  const auto run_to = [&](double t_s) {
    for (LabTime t = clock.now(); t < LabTime{from_seconds(t_s)}; t += 1ms) {
      wires.run_until(t);
      lab.step(t);
      wires.deliver_due(t);
      network.count([&] { devices.step(t); });
      control.step(t);
    }
  };
  run_to(5);  // connections, lists of bodies, symbols, handles
  topic::ModeRequest request;
  request.requester = "test";
  request.action = ModeAction::engage;
  requests.publish(request);
  const std::size_t before = network.taken();
  run_to(15);
  EXPECT_EQ(network.taken() - before, 0U);
  EXPECT_EQ(bus.reader<topic::Mode>().newest().value_or(topic::Mode{}).state, ModeState::engaged);
  EXPECT_GT(before, 0U) << "the drivers were watched";
}

TEST(Allocation, TheCounterCounts) {
  const std::size_t before = test::allocations;
  const auto taken = std::make_unique<int>(1);
  EXPECT_EQ(test::allocations, before + 1) << *taken;
}

}  // namespace
}  // namespace motionlab::integration
