// The gateway's drivers at the other ends of the laboratory's wires, judged by the truth.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>

#include "drivers/comau/comau_driver.hpp"
#include "drivers/core/memory_network.hpp"
#include "drivers/mru/mru_driver.hpp"
#include "drivers/qualisys/qualisys_driver.hpp"
#include "drivers/winch/winch_driver.hpp"
#include "simulators/lab/simulated_lab.hpp"

namespace motionlab::lab {
namespace {

using Eigen::Vector3d;

class DriversMeetLab : public testing::Test {
 protected:
  void build(LabConfig config) {
    config_ = config;
    lab_ = std::make_unique<SimulatedLab>(config, network_, clock_.now());

    mru_socket_ = network_.datagram(config.mru1.device.to);
    mru_ = std::make_unique<mru::MruDriver>(mru::DriverConfig{},
                                            [this](const topic::Mru& s) { mru_sample_ = s; });
    mru_socket_->on_datagram([this](Bytes b, Endpoint from, LabTime t) { mru_->on_datagram(b, from, t); });

    qualisys_socket_ = network_.datagram(Endpoint::parse("127.0.0.1:50199"));
    qualisys_client_ = network_.client(config.qualisys_listen);
    qualisys::DriverConfig cameras;
    cameras.bodies = {"load", "platform"};
    cameras.udp_port = 50199;
    qualisys_ = std::make_unique<qualisys::QualisysDriver>(
        cameras, *qualisys_client_,
        [this](const topic::Bodies& s) { (s.body.view() == "load" ? load_ : platform_) = s; });
    qualisys_client_->on_event(qualisys_.get());
    qualisys_socket_->on_datagram(
        [this](Bytes b, Endpoint from, LabTime t) { qualisys_->on_datagram(b, from, t); });

    arm_socket_ = network_.datagram(Endpoint::parse("127.0.0.1:50042"));
    comau::DriverConfig arm;
    arm.robot_computer = config.arm_listen;
    arm_ = std::make_unique<comau::ComauDriver>(arm, *arm_socket_,
                                                [this](const topic::ArmState& s) { arm_state_ = s; });
    arm_socket_->on_datagram([this](Bytes b, Endpoint from, LabTime t) { arm_->on_datagram(b, from, t); });

    winch_client_ = network_.client(config.winch_listen);
    winch_ = std::make_unique<winch::WinchDriver>(winch::DriverConfig{}, *winch_client_,
                                                  [this](const topic::WinchState& s) { winch_state_ = s; });
    winch_client_->on_event(winch_.get());
  }

  /// Runs on; `each` is called every millisecond before the drivers' steps.
  template <class F>
  void run(Nanoseconds duration, F&& each) {
    for (const LabTime end = clock_.now() + duration; clock_.now() < end;) {
      network_.run_until(clock_.now() + 1ms);
      const LabTime now = clock_.now();
      each(now);
      mru_->step(now);
      qualisys_->step(now);
      arm_->step(now);
      winch_->step(now);
      lab_->step(now);
    }
  }
  void run(Nanoseconds duration) {
    run(duration, [](LabTime) {});
  }

  void command_winch(LabTime now, topic::WinchCommandMode mode, double length_m, double speed_mps) {
    topic::WinchCommand c;
    c.device = "winch";
    c.t_created_ns = to_ns(now);
    c.mode = mode;
    c.enable = true;
    c.wire_length_wanted_m = length_m;
    c.wire_speed_wanted_mps = speed_mps;
    ASSERT_TRUE(winch_->set_command(c));
  }

  SteppedClock clock_;
  MemoryNetwork network_{clock_, {.latency = 100us}};
  LabConfig config_;
  std::unique_ptr<SimulatedLab> lab_;
  std::unique_ptr<DatagramSocket> mru_socket_, qualisys_socket_, arm_socket_;
  std::unique_ptr<StreamClient> qualisys_client_, winch_client_;
  std::unique_ptr<mru::MruDriver> mru_;
  std::unique_ptr<qualisys::QualisysDriver> qualisys_;
  std::unique_ptr<comau::ComauDriver> arm_;
  std::unique_ptr<winch::WinchDriver> winch_;
  std::optional<topic::Mru> mru_sample_;
  std::optional<topic::Bodies> load_, platform_;
  std::optional<topic::ArmState> arm_state_;
  std::optional<topic::WinchState> winch_state_;
};

LabConfig perfect(std::string_view scenario) {
  LabConfig config;
  config.set_scenario(scenario);
  config.use_perfect_sensors();
  return config;
}

TEST_F(DriversMeetLab, CamerasSayWhereLoadAndPlatformAre) {
  build(perfect("thesis-wave"));
  run(8s);
  ASSERT_TRUE(load_ && load_->tracked);
  ASSERT_TRUE(platform_ && platform_->tracked);
  // Where they were at the exposure is not what the truth says now: compare with the truth of a world beside
  // it.
  plant::World beside(config_.world, config_.scenario, config_.seed);
  // The driver believes 7 ms of latency; this world's cameras are 3 ms older.
  const LabTime exposed = from_ns(load_->t_measured_ns) - 3ms;
  beside.advance(exposed + 1ms);
  const plant::WorldState s = beside.sample(exposed);
  const math::RigidTransform X_WQ = beside.calibration().world_to_qtm;
  const auto pose = [&](const topic::Bodies& b) {
    return X_WQ * math::RigidTransform::from_quaternion(
                      {b.q_camera_body[0], b.q_camera_body[1], b.q_camera_body[2], b.q_camera_body[3]},
                      {b.p_camera_body_m[0], b.p_camera_body_m[1], b.p_camera_body_m[2]});
  };
  // A millisecond of the moving load is a millimetre: the clock mapping and the step of this test.
  EXPECT_LT((pose(*load_).p - s.crane.p_WL).norm(), 2e-3);
  EXPECT_LT((pose(*platform_).p - s.platform.X_WB.p).norm(), 1e-3);
  EXPECT_LT((pose(*platform_).R - s.platform.X_WB.R).norm(), 1e-3);
  EXPECT_LT((pose(*load_).R - plant::load_orientation(s.crane.swing_rad)).norm(), 2e-3);
}

TEST_F(DriversMeetLab, AnUntrackedPlatformIsNeverSeen) {
  LabConfig config = perfect("calm");
  config.set_platform_tracked(false);
  build(config);
  run(3s);
  ASSERT_TRUE(load_ && load_->tracked);
  EXPECT_FALSE(platform_ && platform_->tracked);
}

TEST_F(DriversMeetLab, TheMruSaysHowThePlatformLeans) {
  LabConfig config = perfect("thesis-wave");
  config.world.mru1.misalignment_rad.setZero();
  config.world.differences.calibration_angle_rad = 0;
  build(config);
  run(8s);
  ASSERT_TRUE(mru_sample_);
  EXPECT_FALSE(mru_sample_->checksum_suspect);
  const plant::ShipCoordinates ship = plant::ShipMotion(config_.scenario, config_.seed)
                                          .at(1e-9 * static_cast<double>(mru_sample_->t_measured_ns) - 0.003);
  // The surveyed neutral pose leans by 0.7 mrad; that the unit sees and the ship's coordinates do not.
  EXPECT_NEAR(mru_sample_->euler_heading_mru_rad[0], ship.eta[3], 1.5e-3);
  EXPECT_NEAR(mru_sample_->euler_heading_mru_rad[1], ship.eta[4], 1.5e-3);
  EXPECT_NEAR(mru_sample_->euler_heading_mru_rad[2], ship.eta[5], 1.5e-3);
}

TEST_F(DriversMeetLab, TheArmGoesWhereItsDriverSendsIt) {
  build(perfect("calm"));
  run(1500ms);
  ASSERT_TRUE(arm_state_);
  EXPECT_NEAR(arm_state_->q_rad[2], -std::numbers::pi / 2, 1e-4);
  run(2s, [this](LabTime now) {
    topic::ArmCommand c;
    c.device = "arm";
    c.t_created_ns = to_ns(now);
    c.follow = true;
    c.qd_wanted_radps[1] = -0.05;
    arm_->set_command(c);
  });
  EXPECT_NEAR(lab_->truth().q_rad[1], -0.1, 0.006);
  EXPECT_NEAR(arm_state_->q_rad[1], lab_->truth().q_rad[1], 1e-3);
}

TEST_F(DriversMeetLab, TheWinchPaysOutWhatItsDriverAsksFor) {
  build(perfect("calm"));
  run(1s);
  ASSERT_TRUE(winch_state_);
  EXPECT_NEAR(winch_state_->wire_length_m, 2.0, 1e-6);
  EXPECT_NEAR(winch_state_->motor_torque_nm, 12 * 9.81 * 0.0218304 / (2 * std::numbers::pi), 1e-3);
  run(1s, [this](LabTime now) { command_winch(now, topic::WinchCommandMode::hold, 2.0, 0.0); });
  ASSERT_TRUE(winch_state_->enabled);
  const double load_z = lab_->truth().p_world_load_m[2];
  run(2s, [this](LabTime now) { command_winch(now, topic::WinchCommandMode::velocity, 0.0, 0.1); });
  const topic::TruthWorld truth = lab_->truth();
  EXPECT_NEAR(truth.wire_length_m, 2.002 + 0.2, 0.02);
  EXPECT_NEAR(load_z - truth.p_world_load_m[2], truth.wire_length_m - 2.002, 1e-3);
  EXPECT_NEAR(winch_state_->wire_length_m, truth.wire_length_m - 0.002, 2e-3);
}

}  // namespace
}  // namespace motionlab::lab
