// The controller of the house on another host: between it and the gateway lies a network that takes its time.
#include <gtest/gtest.h>

#include <deque>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "gateway/service/remote_controller.hpp"
#include "tests/integration/line.hpp"

namespace motionlab::integration {
namespace {

using topic::ModeState;

/// Carries a topic from bus to bus, each sample as late as the next.
class Carrier {
 public:
  virtual ~Carrier() = default;
  virtual void run(LabTime now) = 0;
};

template <class T>
class CarrierOf final : public Carrier {
 public:
  /// @param period  the newest so often; 0: every sample
  CarrierOf(bus::LocalBus& from, bus::LocalBus& to, Nanoseconds delay, Nanoseconds period,
            const bus::Publisher<T>* except)
      : samples_(from.subscribe<T>(nullptr, except)),
        publisher_(to.advertise_for_strangers<T>()),
        delay_(delay),
        period_(period) {}

  void run(LabTime now) override {
    while (const auto sample = samples_.next()) {
      if (period_ > Nanoseconds{0} && now < next_) continue;
      under_way_.emplace_back(now + delay_, *sample);
    }
    if (now >= next_) next_ = now + period_;
    for (; !under_way_.empty() && under_way_.front().first <= now; under_way_.pop_front()) {
      publisher_.publish(under_way_.front().second);
    }
  }
  [[nodiscard]] const bus::Publisher<T>& arrivals() const { return publisher_; }

 private:
  bus::Subscription<T> samples_;
  bus::Publisher<T> publisher_;
  Nanoseconds delay_, period_;
  LabTime next_{};
  std::deque<std::pair<LabTime, T>> under_way_;
};

/// The far host and the way to it and back.
class FarHost {
 public:
  FarHost(Line& line, Nanoseconds delay) : line_(line), controller_(line.config().gateway, bus_, kName) {
    carry<topic::Mru>(delay);
    carry<topic::Bodies>(delay);
    carry<topic::ArmState>(delay);
    carry<topic::WinchState>(delay);
    carry<topic::Mode>(delay);
    carry_both<topic::ArmCommand>(delay);
    carry_both<topic::WinchCommand>(delay);
  }

  void engage() {
    topic::ModeRequest request;
    request.requester = kName;
    request.action = topic::ModeAction::engage;
    request.external_controller = true;
    requests_.publish(request);
  }
  void step() {
    line_.step();
    if (cut_) return;
    for (const auto& carrier : carriers_) carrier->run(line_.now());
    (void)controller_.step(line_.now());
  }
  void run_for(double s) {
    for (const double end = line_.now_s() + s; line_.now_s() < end;) step();
  }
  void cut() { cut_ = true; }

  static constexpr const char* kName = "controller@desk";

 private:
  template <class T>
  void carry(Nanoseconds delay) {
    carriers_.push_back(
        std::make_unique<CarrierOf<T>>(line_.lockstep().bus(), bus_, delay, Nanoseconds{0}, nullptr));
  }
  template <class T>
  void carry_both(Nanoseconds delay) {
    auto home = std::make_unique<CarrierOf<T>>(bus_, line_.lockstep().bus(), delay, 5ms, nullptr);
    carriers_.push_back(
        std::make_unique<CarrierOf<T>>(line_.lockstep().bus(), bus_, delay, 5ms, &home->arrivals()));
    carriers_.push_back(std::move(home));
  }

  Line& line_;
  bus::LocalBus bus_;
  service::RemoteController controller_;
  std::vector<std::unique_ptr<Carrier>> carriers_;
  bus::Publisher<topic::ModeRequest> requests_ = line_.lockstep().bus().advertise<topic::ModeRequest>();
  bool cut_ = false;
};

/// Scenario, delay each way in ms, the largest rms error of the load in m.
class ControllerFarAway : public testing::TestWithParam<std::tuple<std::string, int, double>> {};

TEST_P(ControllerFarAway, KeepsTheLoadStillAndLosesItsLeaseWhenTheWayIsCut) {
  const auto [scenario, delay_ms, most_m] = GetParam();
  const lockstep::Config config = configure(scenario);
  Line line(config);
  FarHost far(line, std::chrono::milliseconds{delay_ms});
  far.run_for(10);
  ASSERT_EQ(line.mode().state, ModeState::ready) << line.mode().reason.view();
  far.engage();
  far.run_for(10);
  ASSERT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  EXPECT_EQ(line.mode().owner.view(), FarHost::kName);
  line.take_motion();
  far.run_for(40);
  ASSERT_EQ(line.mode().state, ModeState::engaged) << line.mode().reason.view();
  const auto motion = line.take_motion();
  RecordProperty("load_error_rms_m", std::to_string(motion.load_error_rms_norm_m));
  EXPECT_LE(motion.load_error_rms_norm_m, most_m);
  EXPECT_EQ(steps_beyond_limits(line.steps(), config.gateway.limits, config.gateway.control_period_s), 0U);

  const LabTime last = line.now();
  far.cut();
  ASSERT_TRUE(line.run_until_state(ModeState::fault, 1));
  EXPECT_EQ(line.mode().fault_code.view(), "lease_lost");
  EXPECT_LE(line.now() - last, 110ms);
  line.run_for(2);
  EXPECT_TRUE(line.steps().back().at_rest());
}

using Way = ControllerFarAway::ParamType;
INSTANTIATE_TEST_SUITE_P(Ways, ControllerFarAway,
                         testing::Values(Way{"thesis-wave", 0, 0.010}, Way{"thesis-wave", 2, 0.010},
                                         Way{"sea", 1, 0.012}, Way{"thesis-wave", 10, 0.010}));

}  // namespace
}  // namespace motionlab::integration
