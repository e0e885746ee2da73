// Every driver joined to its device in memory, through a wire that does one named thing wrong: what health
// says, what the samples are worth, what arm and winch do meanwhile, and that all is well when the fault has
// ended. The laboratory lies calm and is known exactly, so that a wrong sample can be told from a right one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "drivers/core/memory_network.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/service/devices.hpp"
#include "gateway/service/gateway_config.hpp"
#include "gateway/service/snapshot.hpp"
#include "simulators/faults/wire_faults.hpp"
#include "simulators/lab/simulated_lab.hpp"

namespace motionlab {
namespace {

using testing::HasSubstr;
using topic::LinkState;

constexpr Nanoseconds kFaultLasts = 5s;
constexpr double kArmSpeed_radps = 0.03;  ///< asked of joint 1
constexpr double kWinchSpeed_mps = 0.02;

/// What the samples of one device were worth for a while.
struct Quality {
  std::size_t samples = 0;  ///< usable by their own word: stable, tracked, checksum not suspect
  std::size_t wrong = 0;    ///< of these
  std::size_t marked = 0;   ///< not usable by their own word
  std::size_t from_the_future = 0;
  std::size_t back_in_time = 0;
  std::optional<Nanoseconds> newest_age;
};

/// Laboratory, wires and drivers on a virtual clock. The arm's joint 1 turns and the winch pays out all the
/// time.
class Bench {
 public:
  Bench()
      : gateway_(service::load_gateway_config(file("lab.toml"), {file("loopback.toml")})),
        lab_(calm(), network_, clock_.now()),
        devices_(gateway_, network_, bus_, schedule_),
        arm_out_(bus_.advertise<topic::ArmCommand>()),
        winch_out_(bus_.advertise<topic::WinchCommand>()),
        mru_(bus_.subscribe<topic::Mru>()),
        bodies_(bus_.subscribe<topic::Bodies>()),
        arm_(bus_.subscribe<topic::ArmState>()),
        winch_(bus_.subscribe<topic::WinchState>()) {}

  static std::filesystem::path file(const char* name) {
    return std::filesystem::path(MOTIONLAB_SOURCE_DIR) / "deploy" / "config" / name;
  }
  static lab::LabConfig calm() {
    lab::LabConfig config = lab::LabConfig::load(file("world.toml"));
    config.set_scenario("calm");
    config.use_perfect_sensors();
    config.use_belief_as_world();
    return config;
  }

  void run(Nanoseconds duration) {
    for (const LabTime end = now() + duration; now() < end;) {
      network_.run_until(now() + 500us);
      command();
      lab_.step(now());
      devices_.step(now());
      network_.deliver_due(now());
      listen();
    }
  }
  /// The driver lets an arm that ignored its commands go again once somebody says hold, as the gateway does.
  void hold_arm() {
    arm_follows_ = false;
    run(200ms);
    arm_follows_ = true;
  }
  /// The winch's latch is opened as the gateway does after `reset`: enable low, reset edge, enable.
  void reset_winch() {
    winch_enable_ = false;
    run(200ms);
    winch_reset_ = true;
    run(200ms);
    winch_reset_ = false;
    winch_enable_ = true;
    run(400ms);
  }

  Status fault(std::string_view device, std::string_view name, bool active, double value = 0) {
    return lab_.set_fault(device, name, active, value);
  }
  [[nodiscard]] LabTime now() const { return clock_.now(); }
  [[nodiscard]] topic::Health health(std::string_view device) {
    topic::Health found;
    bus_.for_each_newest<topic::Health>([&](const topic::Health& health) {
      if (health.device.view() == device) found = health;
    });
    return found;
  }
  /// Since the last call.
  Quality take_quality(std::string_view device) {
    Quality& quality = device == "mru1"       ? mru_quality_
                       : device == "qualisys" ? bodies_quality_
                       : device == "arm"      ? arm_quality_
                                              : winch_quality_;
    return std::exchange(quality, Quality{});
  }
  [[nodiscard]] double arm_speed_radps() const { return lab_.world().qd_radps()[0]; }
  [[nodiscard]] double winch_speed_mps() { return lab_.state().winch_speed_mps; }
  /// The fastest that joint 1 really went since the last call.
  double take_arm_speed_max_radps() { return std::exchange(arm_speed_max_, 0.0); }

 private:
  void command() {
    topic::ArmCommand arm;
    arm.device = "arm";
    arm.requester = service::kGatewayRequester;
    arm.t_created_ns = to_ns(now());
    arm.follow = arm_follows_;
    arm.qd_wanted_radps[0] = kArmSpeed_radps;
    arm_out_.publish(arm);
    topic::WinchCommand winch;
    winch.device = "winch";
    winch.requester = service::kGatewayRequester;
    winch.t_created_ns = to_ns(now());
    winch.mode = winch_enable_ ? topic::WinchCommandMode::velocity : topic::WinchCommandMode::hold;
    winch.enable = winch_enable_;
    winch.reset = winch_reset_;
    winch.wire_speed_wanted_mps = kWinchSpeed_mps;
    winch_out_.publish(winch);
    arm_speed_max_ = std::max(arm_speed_max_, std::abs(arm_speed_radps()));
  }

  template <class Sample>
  void judge(Quality& quality, const Sample& sample, bool usable, bool right, std::int64_t& newest_ns) {
    if (usable) {
      ++quality.samples;
      if (!right) ++quality.wrong;
    } else {
      ++quality.marked;
    }
    if (sample.t_measured_ns > sample.t_received_ns) ++quality.from_the_future;
    if (sample.t_measured_ns < newest_ns) ++quality.back_in_time;
    newest_ns = sample.t_measured_ns;
    quality.newest_age = Nanoseconds{sample.t_received_ns - sample.t_measured_ns};
  }
  /// What does not move in a calm must not move in a sample either.
  void listen() {
    while (const auto mru = mru_.next()) {
      if (mru->device.view() != "mru1") continue;
      const bool right = near(mru->euler_heading_mru_rad, mru_first_.euler_heading_mru_rad, 0.01) &&
                         near(mru->a_mru_mps2, mru_first_.a_mru_mps2, 0.05) &&
                         near(mru->omega_mru_radps, mru_first_.omega_mru_radps, 0.01);
      if (mru->sequence_number == 1) mru_first_ = *mru;
      judge(mru_quality_, *mru, mru->stable && !mru->checksum_suspect, right || mru->sequence_number == 1,
            mru_newest_);
    }
    while (const auto body = bodies_.next()) {
      if (body->body.view() != lab::kPlatformBody) continue;
      if (body->tracked && !platform_first_) platform_first_ = *body;
      judge(bodies_quality_, *body, body->tracked,
            !body->tracked || near(body->p_camera_body_m, platform_first_->p_camera_body_m, 0.01),
            bodies_newest_);
    }
    while (const auto arm = arm_.next()) {
      judge(arm_quality_, *arm, true, std::abs(arm->q_rad[3]) < 0.01 && std::abs(arm->q_rad[4]) < 0.01,
            arm_newest_);
    }
    while (const auto winch = winch_.next()) {
      judge(winch_quality_, *winch, !winch->error,
            std::abs(winch->wire_length_m - lab_.truth().wire_length_m) < 0.02, winch_newest_);
    }
  }
  template <std::size_t N>
  static bool near(const std::array<double, N>& a, const std::array<double, N>& b, double within) {
    for (std::size_t i = 0; i < N; ++i) {
      if (!(std::abs(a[i] - b[i]) <= within)) return false;
    }
    return true;
  }

  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();

  SteppedClock clock_;
  MemoryNetwork network_{clock_, {.latency = 100us}};
  bus::LocalBus bus_;
  service::ArmSchedule schedule_;
  service::GatewayConfig gateway_;
  lab::SimulatedLab lab_;
  service::Devices devices_;
  bus::Publisher<topic::ArmCommand> arm_out_;
  bus::Publisher<topic::WinchCommand> winch_out_;
  bus::Subscription<topic::Mru> mru_;
  bus::Subscription<topic::Bodies> bodies_;
  bus::Subscription<topic::ArmState> arm_;
  bus::Subscription<topic::WinchState> winch_;
  bool arm_follows_ = true;
  bool winch_enable_ = false, winch_reset_ = false;
  double arm_speed_max_ = 0;
  Quality mru_quality_, bodies_quality_, arm_quality_, winch_quality_;
  std::int64_t mru_newest_ = kNever, bodies_newest_ = kNever, arm_newest_ = kNever, winch_newest_ = kNever;
  topic::Mru mru_first_;
  std::optional<topic::Bodies> platform_first_;
};

/// One fault on one device's wire, and what has to come of it.
struct Cell {
  std::string device;
  std::string fault;
  double value;
  double usable_min, usable_max;    ///< share of the samples that the device made which are told as good
  std::optional<Reason> counted{};  ///< health counts refusals for this reason
  bool up = true;                   ///< the link, while the fault lasts
  bool rests = false;               ///< the actuator on this wire comes to rest
  /// The format cannot tell a flipped bit: wrong samples are possible, and a clock that was led astray by one
  /// creeps back with 200 ppm only.
  bool no_checksum = false;
};
void PrintTo(const Cell& cell, std::ostream* out) {
  *out << cell.device << ':' << cell.fault;
}

// Measurements travel one way, so a tenth lost is a tenth lost. The arm answers what it has heard: commands
// and answers are at risk, 0.81 remain. A datagram that was overtaken is too old to be told.
const std::vector<Cell> kCells{
    {"mru1", "cut", 0, 0.0, 0.01, {}, false},
    {"mru1", "loss", 0.1, 0.85, 0.95},
    {"mru1", "burst", 5, 0.75, 0.99},
    {"mru1", "jitter", 0.01, 0.99, 1.0},
    {"mru1", "reorder", 0.1, 0.85, 0.95, Reason::out_of_order},
    {"mru1", "duplicate", 0.1, 1.0, 1.0, Reason::duplicate},
    {"mru1", "corrupt", 0.1, 0.85, 0.95},
    {"mru1", "truncate", 0.1, 0.85, 0.95, Reason::too_short},
    {"mru1", "foreign", 0.1, 1.0, 1.0, Reason::foreign},
    {"mru1", "clock-jump", 2, 0.98, 1.0},
    {"mru1", "clock-jump", -2, 0.98, 1.0},

    {"qualisys", "cut", 0, 0.0, 0.01, {}, false},
    {"qualisys", "loss", 0.1, 0.85, 0.95},
    {"qualisys", "burst", 5, 0.70, 0.99},  // and lost for good after five frames without one
    {"qualisys", "jitter", 0.01, 0.99, 1.0},
    {"qualisys", "reorder", 0.1, 0.85, 0.95, Reason::out_of_order},
    {"qualisys", "duplicate", 0.1, 1.0, 1.0, Reason::duplicate},
    {.device = "qualisys",
     .fault = "corrupt",
     .value = 0.1,
     .usable_min = 0.85,
     .usable_max = 1.0,
     .counted = Reason::bad_value,
     .no_checksum = true},
    {"qualisys", "truncate", 0.1, 0.85, 0.95, Reason::too_short},
    {"qualisys", "foreign", 0.1, 1.0, 1.0, Reason::foreign},
    {"qualisys", "clock-jump", 2, 0.98, 1.0},
    {"qualisys", "clock-jump", -2, 0.98, 1.0},

    {.device = "arm",
     .fault = "cut",
     .value = 0,
     .usable_min = 0.0,
     .usable_max = 0.01,
     .up = false,
     .rests = true},
    {"arm", "loss", 0.1, 0.75, 0.87},
    {"arm", "burst", 5, 0.65, 0.97},
    {"arm", "jitter", 0.01, 0.75, 1.0,
     Reason::duplicate},  // commands that arrive together get one measurement
    {"arm", "reorder", 0.1, 0.75, 0.95, Reason::out_of_order},
    {"arm", "duplicate", 0.1, 1.0, 1.0, Reason::duplicate},
    {.device = "arm",
     .fault = "corrupt",
     .value = 0.1,
     .usable_min = 0.90,
     .usable_max = 1.0,
     .no_checksum = true},
    {"arm", "truncate", 0.1, 0.75, 0.87, Reason::too_short},
    {"arm", "foreign", 0.1, 1.0, 1.0, Reason::foreign},

    {.device = "winch",
     .fault = "cut",
     .value = 0,
     .usable_min = 0.0,
     .usable_max = 0.01,
     .counted = Reason::transport,
     .up = false,
     .rests = true},
    {"winch", "jitter", 0.01, 0.99, 1.01},
    {"winch", "clock-jump", 2, 0.99, 1.0},
    {"winch", "clock-jump", -2, 0.99, 1.0},
};

class WireMatrix : public testing::TestWithParam<Cell> {
 protected:
  static double rate_hz(std::string_view device) { return device == "winch" ? 100 : 200; }
  static std::size_t samples_in(Nanoseconds duration, std::string_view device) {
    return static_cast<std::size_t>(seconds(duration) * rate_hz(device) + 0.5);
  }
  static std::uint64_t refused(const topic::Health& health) {
    std::uint64_t sum = 0;
    for (const auto n : health.rejected) sum += n;
    return sum;
  }
  static std::vector<std::string> others(const std::string& device) {
    std::vector<std::string> all{"mru1", "mru2", "qualisys", "arm", "winch"};
    std::erase(all, device);
    return all;
  }
};

TEST_P(WireMatrix, IsCountedMarkedAnsweredAndForgotten) {
  const Cell& cell = GetParam();
  Bench bench;
  bench.run(2s);
  bench.hold_arm();
  bench.reset_winch();
  bench.run(4s);  // the rule of the MRU's checksum is learned from 1000 datagrams
  const topic::Health before = bench.health(cell.device);
  ASSERT_EQ(before.link, LinkState::up) << before.advice.view();
  const Quality well = bench.take_quality(cell.device);
  ASSERT_EQ(well.wrong, 0U);
  ASSERT_TRUE(well.newest_age);
  bench.take_arm_speed_max_radps();

  ASSERT_TRUE(bench.fault(cell.device, cell.fault, true, cell.value));
  bench.run(kFaultLasts);

  // Health.
  const topic::Health during = bench.health(cell.device);
  EXPECT_EQ(during.link == LinkState::up, cell.up) << during.advice.view();
  EXPECT_TRUE(cell.up || !during.advice.empty());
  if (cell.counted) {
    const auto reason = static_cast<std::size_t>(*cell.counted);
    EXPECT_GT(during.rejected[reason], before.rejected[reason]);
  }
  if (cell.fault == "loss" || cell.fault == "burst") {
    EXPECT_GT(during.lost, before.lost);
  }
  for (const std::string& other : others(cell.device)) {
    EXPECT_EQ(bench.health(other).link, LinkState::up) << other;
    EXPECT_EQ(refused(bench.health(other)), 0U) << other;
  }

  // Quality.
  const Quality quality = bench.take_quality(cell.device);
  const auto made = static_cast<double>(samples_in(kFaultLasts, cell.device));
  EXPECT_GE(static_cast<double>(quality.samples), made * cell.usable_min - 3);
  EXPECT_LE(static_cast<double>(quality.samples), made * cell.usable_max + 3);
  if (cell.no_checksum) {
    EXPECT_LE(static_cast<double>(quality.wrong), 0.05 * made);
  } else {
    EXPECT_EQ(quality.wrong, 0U);
    EXPECT_EQ(quality.back_in_time, 0U);
    EXPECT_TRUE(!cell.up || *quality.newest_age <= *well.newest_age + 11ms);  // the longest jitter
  }
  EXPECT_EQ(quality.from_the_future, 0U);

  // Reaction. Nothing that happens on a wire makes anything faster than it was asked to be.
  const bool arm_rests = cell.rests && cell.device == "arm";
  const bool winch_rests = cell.rests && cell.device == "winch";
  EXPECT_NEAR(bench.arm_speed_radps(), arm_rests ? 0.0 : kArmSpeed_radps, 0.1 * kArmSpeed_radps);
  EXPECT_NEAR(bench.winch_speed_mps(), winch_rests ? 0.0 : kWinchSpeed_mps, 0.1 * kWinchSpeed_mps);
  EXPECT_LE(bench.take_arm_speed_max_radps(), cell.no_checksum ? 0.1 : 1.1 * kArmSpeed_radps);

  // Recovery: without a trace.
  ASSERT_TRUE(bench.fault(cell.device, cell.fault, false));
  bench.run(4s);
  bench.hold_arm();
  bench.reset_winch();
  bench.run(1s);
  const topic::Health then = bench.health(cell.device);
  (void)bench.take_quality(cell.device);
  bench.run(2s);
  const topic::Health after = bench.health(cell.device);
  EXPECT_EQ(after.link, LinkState::up);
  EXPECT_EQ(after.advice.view(), "");
  EXPECT_EQ(refused(after), refused(then));
  EXPECT_EQ(after.lost, then.lost);
  const Quality again = bench.take_quality(cell.device);
  EXPECT_NEAR(static_cast<double>(again.samples), static_cast<double>(samples_in(2s, cell.device)), 2);
  EXPECT_EQ(again.wrong + again.marked + again.from_the_future + again.back_in_time, 0U);
  EXPECT_TRUE(cell.no_checksum || *again.newest_age <= *well.newest_age + 1ms);
  EXPECT_NEAR(bench.arm_speed_radps(), kArmSpeed_radps, 0.02 * kArmSpeed_radps);
  EXPECT_NEAR(bench.winch_speed_mps(), kWinchSpeed_mps, 0.02 * kWinchSpeed_mps);
}

std::string name_of(const testing::TestParamInfo<Cell>& test) {
  std::string name = test.param.device + "_" + test.param.fault;
  if (test.param.fault == "clock-jump") name += test.param.value > 0 ? "_ahead" : "_back";
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Cell, WireMatrix, testing::ValuesIn(kCells), name_of);

TEST(WireMatrixIsWhole, EveryFaultIsACellOrRefusedByNameWithTheReason) {
  Bench bench;
  std::istringstream names{std::string(faults::WireFaults::kNames)};
  for (std::string fault; names >> fault;) {
    for (const std::string device : {"mru1", "qualisys", "arm", "winch"}) {
      const bool in_matrix = std::any_of(kCells.begin(), kCells.end(), [&](const Cell& cell) {
        return cell.device == device && cell.fault == fault;
      });
      const Status taken = bench.fault(device, fault, false);
      EXPECT_EQ(static_cast<bool>(taken), in_matrix) << device << ':' << fault;
      if (!taken) {
        EXPECT_EQ(taken.fault().reason, Reason::refused);
        EXPECT_THAT(std::string(taken.fault().text), HasSubstr(device == "winch" ? "TCP" : "clock"));
      }
    }
  }
}

TEST(WireMatrixIsWhole, AnUnknownFaultIsRefusedWithTheNamesOfTheDeviceAndOfItsWire) {
  Bench bench;
  for (const char* const device : {"mru1", "mru2", "qualisys", "arm", "winch"}) {
    const Status refused = bench.fault(device, "gremlins", true);
    ASSERT_FALSE(refused) << device;
    EXPECT_THAT(std::string(refused.fault().text), HasSubstr("silent")) << device;
    EXPECT_THAT(std::string(refused.fault().text), HasSubstr(std::string(faults::WireFaults::kNames)));
  }
}

}  // namespace
}  // namespace motionlab
