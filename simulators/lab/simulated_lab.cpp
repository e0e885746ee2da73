#include "simulators/lab/simulated_lab.hpp"

#include <algorithm>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>

#include "gateway/math/euler_rates.hpp"
#include "simulators/faults/faulty_wire.hpp"
#include "simulators/faults/wire_faults.hpp"
#include "simulators/lab/gust.hpp"

namespace motionlab::lab {

namespace {

/// Not a fault, but the end of all.
constexpr std::string_view kOk = "ok";

template <class Vector>
std::array<double, 3> array3(const Vector& v) {
  return {v.x(), v.y(), v.z()};
}

std::array<double, 4> array4(const Eigen::Vector4d& q) {
  return {q[0], q[1], q[2], q[3]};
}

mru::Reading reading_of(const plant::MruReading& r, double temperature_degc) {
  return {.euler_heading_mru_rad = array3(r.euler_rad),
          .omega_mru_radps = array3(r.omega_M_radps),
          .omega_down_radps = r.omega_down_radps,
          .v_mru_mps = array3(r.v_unit_M_mps),
          .a_mru_mps2 = array3(r.a_unit_M_mps2),
          .p_heading_origin_m = array3(r.p_origin_H_m),
          .v_heading_origin_mps = array3(r.v_origin_H_mps),
          .a_heading_origin_mps2 = array3(r.a_origin_H_mps2),
          .sensor_temperature_degc = temperature_degc};
}

plc_reply::Six six(const Eigen::Vector3d& lengths, const Eigen::Vector3d& angles) {
  return {lengths.x(), lengths.y(), lengths.z(), angles.x(), angles.y(), angles.z()};
}

/// What the legs of a platform say of it, about its neutral pose.
plc_reply::PlatformFeedback feedback_of(const plant::PlatformState& s, const math::RigidTransform& X_WN) {
  constexpr auto kOrder = math::EulerOrder::xyz;
  const math::RigidTransform X_NB = X_WN.inverse() * s.X_WB;
  const Eigen::Vector3d rpy = math::to_euler(X_NB.R, kOrder);
  const math::EulerMotion turn =
      math::euler_motion(rpy, {s.omega_WB_B, s.alpha_WB_B}, kOrder).value_or(math::EulerMotion{});
  const Eigen::Matrix3d R_NW = X_WN.R.transpose();
  return {six(X_NB.p, rpy), six(R_NW * s.v_WB, turn.rate_radps),
          six(R_NW * s.a_WB, turn.acceleration_radps2)};
}

plc_reply::MruFeedback feedback_of(const plant::MruReading& r) {
  return {six(r.p_origin_H_m, r.euler_rad), six(r.v_origin_H_mps, r.omega_M_radps)};
}

qualisys::MeasuredBody body_of(std::string_view name, const plant::BodyReading& r) {
  qualisys::MeasuredBody body;
  body.name = name;
  body.tracked = r.tracked;
  if (r.tracked) {
    body.p_camera_body_m = array3(r.X_QB.p);
    body.q_camera_body = array4(r.X_QB.quaternion_wxyz());
    body.residual_m = r.residual_m;
  }
  return body;
}

/// The two markers at the hook, on either side of the wire; none while the load is not seen.
std::vector<qualisys::UnlabelledMarker> hook_markers(const plant::BodyReading& load, double spacing_m,
                                                     double above_centre_m) {
  if (!load.tracked || spacing_m <= 0.0) return {};
  std::vector<qualisys::UnlabelledMarker> markers;
  for (const double side : {-0.5, 0.5}) {
    const Eigen::Vector3d p_QM = load.X_QB * Eigen::Vector3d(side * spacing_m, 0.0, above_centre_m);
    markers.push_back({array3(p_QM), side < 0.0 ? 1U : 2U, load.residual_m});
  }
  return markers;
}

mru::DeviceConfig with(mru::DeviceConfig device, const plant::MruConfig& unit, const LabConfig& lab) {
  device.output_latency_s = unit.output_latency_s + lab.world.differences.sensor_extra_latency_s;
  device.seed = lab.seed;
  return device;
}

qualisys::DeviceConfig cameras(const LabConfig& lab) {
  qualisys::DeviceConfig device = lab.qualisys;
  device.rate_hz = 1 / lab.world.camera.period_s;
  device.latency_s = lab.world.camera.latency_s + lab.world.differences.sensor_extra_latency_s;
  device.seed = lab.seed;
  device.base_port = static_cast<std::uint16_t>(lab.qualisys_listen.port - 1);
  device.bodies = {{std::string(kLoadBody), true}};
  if (lab.world.camera.platform_tracked) device.bodies.push_back({std::string(kPlatformBody), true});
  return device;
}

comau::DeviceConfig robot_pc(const LabConfig& lab) {
  comau::DeviceConfig device = lab.arm;
  device.seed = lab.seed;
  return device;
}

winch::DeviceConfig plc(const LabConfig& lab) {
  winch::DeviceConfig device = lab.winch;
  device.plc.wire_at_zero_travel_m = lab.world.winch.length_at_zero_travel_m;
  return device;
}

plc_reply::DeviceConfig remote_interface(const LabConfig& lab) {
  plc_reply::DeviceConfig device = lab.plc_reply;
  device.seed = lab.seed;
  return device;
}

/// The PLC's remote interface with its wire.
struct PlcEnd {
  PlcEnd(const LabConfig& config, Network& network)
      : wire(network, config.seed, std::string(kPlc),
             [this](Nanoseconds jump) { device.set_clock_jump(jump); }),
        socket(wire.datagram(config.plc_reply_listen)),
        device(remote_interface(config), *socket) {
    socket->on_datagram(
        [this](Bytes datagram, Endpoint from, LabTime t) { device.on_datagram(datagram, from, t); });
  }
  ~PlcEnd() { socket->on_datagram({}); }
  PlcEnd(const PlcEnd&) = delete;
  PlcEnd& operator=(const PlcEnd&) = delete;

  faults::FaultyWire wire;
  std::unique_ptr<DatagramSocket> socket;
  plc_reply::PlcReplyDevice device;
};

/// A sensor or a task that comes round at a fixed period.
struct Round {
  LabTime next;
  Nanoseconds period;

  [[nodiscard]] bool due(LabTime t) const { return next <= t; }
  LabTime take() { return std::exchange(next, next + period); }
};

}  // namespace

struct SimulatedLab::Impl {
  Impl(const LabConfig& config, Network& network, LabTime start)
      : world(config.world, config.scenario, config.seed, start),
        mru1_sensor(config.world.mru1.with_noise_times(config.world.differences.mru_noise_factor),
                    config.world.calibration.world_to_em8000, world.calibration().em8000_to_mru1, config.seed,
                    "mru1"),
        mru2_sensor(config.world.mru2.with_noise_times(config.world.differences.mru_noise_factor),
                    config.world.calibration.world_to_em1500, world.calibration().em1500_to_mru2, config.seed,
                    "mru2"),
        camera_sensor(config.world.camera, world.calibration().world_to_qtm, config.seed),
        encoders(config.world.encoder, config.seed),
        mru1_wire(network, config.seed, "mru1", [this](Nanoseconds jump) { mru1.set_clock_jump(jump); }),
        mru2_wire(network, config.seed, "mru2", [this](Nanoseconds jump) { mru2.set_clock_jump(jump); }),
        qualisys_wire(network, config.seed, "qualisys",
                      [this](Nanoseconds jump) { qualisys.set_clock_jump(jump); }),
        arm_wire(network, config.seed, "arm"),
        winch_wire(network, config.seed, "winch", [this](Nanoseconds jump) { winch.set_clock_jump(jump); }),
        mru1_socket(mru1_wire.datagram(config.mru1.from)),
        mru2_socket(mru2_wire.datagram(config.mru2.from)),
        qualisys_server(qualisys_wire.server(config.qualisys_listen)),
        qualisys_socket(qualisys_wire.datagram({config.qualisys_listen.address, 0})),
        arm_socket(arm_wire.datagram(config.arm_listen)),
        winch_server(winch_wire.server(config.winch_listen)),
        mru1(with(config.mru1.device, config.world.mru1, config), *mru1_socket),
        mru2(with(config.mru2.device, config.world.mru2, config), *mru2_socket),
        qualisys(cameras(config), *qualisys_server, *qualisys_socket),
        arm(robot_pc(config), *arm_socket),
        winch(plc(config), *winch_server),
        robot_cycle{start, plant::World::kTick},
        plc_task{start, from_seconds(config.winch.plc.task_period_s)},
        mru1_round{start, from_seconds(config.world.mru1.period_s)},
        mru2_round{start, from_seconds(config.world.mru2.period_s)},
        camera_round{start, from_seconds(config.world.camera.period_s)},
        now(start),
        hook_spacing_m(config.hook_marker_spacing_m),
        hook_above_centre_m(config.world.load.below_hook_m()) {
    if (config.plc_reply_enabled) plc_end.emplace(config, network);
    qualisys_server->on_event(&qualisys);
    if (config.qualisys_big_endian_listen) {
      qualisys_big_endian_server = network.server(*config.qualisys_big_endian_listen);
      qualisys_big_endian_server->on_event(&qualisys.serve_big_endian(*qualisys_big_endian_server));
    }
    if (config.qualisys_discovery_listen) {
      qualisys_discovery = network.datagram(*config.qualisys_discovery_listen);
      qualisys_discovery->on_datagram(
          [this](Bytes datagram, Endpoint from, LabTime t) { qualisys.on_discovery(datagram, from, t); });
    }
    winch_server->on_event(&winch);
    arm_socket->on_datagram(
        [this](Bytes datagram, Endpoint from, LabTime t) { arm.on_datagram(datagram, from, t); });
  }

  void run_robot_cycle() {
    const LabTime t = robot_cycle.take();
    const auto measured = encoders.read(world.q_rad(), world.qd_radps());
    arm.cycle(t, measured.q_rad, measured.qd_radps);
    if (arm.drives_on()) {
      world.set_joint_set_points(arm.set_point_rad());
      braked = false;
    } else if (!braked) {
      world.set_joint_set_points(world.q_rad());  // the brakes hold it where it is
      braked = true;
    }
    world.advance(robot_cycle.next);
  }

  void run_plc_task() {
    const LabTime t = plc_task.take();
    const plant::WorldState s = world.sample(t);
    winch.cycle(t, {.wire_length_m = s.winch_length_m,
                    .wire_speed_mps = s.winch_speed_mps,
                    .motor_torque_nm = s.winch_torque_nm});
    world.set_wire_set_point(winch.set_point_m());
    if (plc_end) {
      const plant::Calibration& where = world.calibration();
      plc_end->device.cycle(
          t, {feedback_of(s.platform, where.world_to_em8000), feedback_of(s.second, where.world_to_em1500)});
    }
  }

  void expose_cameras() {
    const LabTime t = camera_round.take();
    const plant::WorldState s = world.sample(t);
    const auto seen =
        camera_sensor.sample({plant::load_orientation(s.crane.tilt_rad), s.crane.p_WL}, s.platform.X_WB);
    frame.bodies.clear();
    frame.bodies.push_back(body_of(kLoadBody, seen.load));
    frame.bodies.push_back(body_of(kPlatformBody, seen.platform));
    frame.unlabelled = hook_markers(seen.load, hook_spacing_m, hook_above_centre_m);
    qualisys.capture(frame, t);
  }

  void measure(Round& round, plant::MruSensor& sensor, mru::MruDevice& device, bool second) {
    const LabTime t = round.take();
    const plant::WorldState s = world.sample(t);
    const plant::MruReading reading = sensor.sample(second ? s.second : s.platform);
    device.measure(reading_of(reading, sensor.config().temperature_degc), t);
    if (plc_end) {
      const double latency_s =
          sensor.config().output_latency_s + world.config().differences.sensor_extra_latency_s;
      plc_end->device.hear(second ? 1 : 0, feedback_of(reading), t + from_seconds(latency_s));
    }
  }

  /// What the wire does not know, the device may.
  template <class Device>
  Status set_fault(faults::FaultyWire& wire, Device& device, std::string_view fault, bool active,
                   double value) {
    if (faults::WireFaults::knows(fault)) return wire.set_fault(fault, active, value);
    const Status done = device.set_fault(fault, active, value);
    if (done) return done;
    refusal = std::string(done.fault().text) + "; its wire: " + std::string(faults::WireFaults::kNames) +
              "; and ok ends them all";
    return Fault{done.fault().reason, refusal};
  }

  [[nodiscard]] LabTime next_event() const {
    return std::min({robot_cycle.next, plc_task.next, mru1_round.next, mru2_round.next, camera_round.next});
  }

  void step(LabTime to) {
    while (true) {
      const LabTime t = next_event();
      if (t > to) break;
      // The cycle first: it runs the tick that begins now, and the others measure in it.
      if (robot_cycle.due(t)) run_robot_cycle();
      if (plc_task.due(t)) run_plc_task();
      if (mru1_round.due(t)) measure(mru1_round, mru1_sensor, mru1, false);
      if (mru2_round.due(t)) measure(mru2_round, mru2_sensor, mru2, true);
      if (camera_round.due(t)) expose_cameras();
    }
    now = std::max(now, to);
    for (faults::FaultyWire* const wire : {&mru1_wire, &mru2_wire, &qualisys_wire, &arm_wire, &winch_wire}) {
      wire->step(now);
    }
    mru1.step(now);
    mru2.step(now);
    qualisys.step(now);
    winch.step(now);
    if (plc_end) {
      plc_end->wire.step(now);
      plc_end->device.step(now);
    }
  }

  plant::World world;
  Gust gust;
  plant::MruSensor mru1_sensor, mru2_sensor;
  plant::CameraSensor camera_sensor;
  plant::JointEncoders encoders;

  faults::FaultyWire mru1_wire, mru2_wire, qualisys_wire, arm_wire, winch_wire;
  std::unique_ptr<DatagramSocket> mru1_socket, mru2_socket;
  std::unique_ptr<StreamServer> qualisys_server;
  std::unique_ptr<DatagramSocket> qualisys_socket;
  std::unique_ptr<StreamServer> qualisys_big_endian_server;
  std::unique_ptr<DatagramSocket> qualisys_discovery;
  std::unique_ptr<DatagramSocket> arm_socket;
  std::unique_ptr<StreamServer> winch_server;

  mru::MruDevice mru1, mru2;
  qualisys::QualisysDevice qualisys;
  comau::ComauDevice arm;
  winch::WinchDevice winch;
  std::optional<PlcEnd> plc_end;

  Round robot_cycle, plc_task, mru1_round, mru2_round, camera_round;
  LabTime now;
  bool braked = false;
  qualisys::CameraFrame frame;
  double hook_spacing_m, hook_above_centre_m;
  std::uint64_t truths = 0;
  std::string refusal;  ///< the last one
};

SimulatedLab::SimulatedLab(const LabConfig& config, Network& network, LabTime start)
    : impl_(std::make_unique<Impl>(config, network, start)) {}

SimulatedLab::~SimulatedLab() {
  impl_->arm_socket->on_datagram({});
  impl_->qualisys_server->on_event(nullptr);
  impl_->winch_server->on_event(nullptr);
}

void SimulatedLab::step(LabTime now) {
  impl_->step(now);
}
LabTime SimulatedLab::next_event() const {
  return impl_->next_event();
}
const plant::World& SimulatedLab::world() const {
  return impl_->world;
}
plant::WorldState SimulatedLab::state() {
  return impl_->world.sample(impl_->now);
}
bool SimulatedLab::arm_program_alive() const {
  return !impl_->arm.crashed();
}

topic::TruthWorld SimulatedLab::truth() {
  const plant::WorldState s = state();
  topic::TruthWorld truth;
  truth.sequence_number = ++impl_->truths;
  truth.t_ns = to_ns(s.t);
  truth.p_world_platform_m = array3(s.platform.X_WB.p);
  truth.q_world_platform = array4(s.platform.X_WB.quaternion_wxyz());
  truth.q_rad = s.q_rad;
  truth.wire_length_m = s.crane.free_length_m;
  truth.p_world_tool_m = array3(s.crane.tool.p_W);
  truth.p_world_load_m = array3(s.crane.p_WL);
  truth.v_world_load_mps = array3(s.crane.v_WL);
  truth.swing_rad = {s.crane.swing_rad[0], s.crane.swing_rad[1]};
  truth.p_world_twin_tool_m = array3(s.twin.tool.p_W);
  truth.p_world_twin_load_m = array3(s.twin.p_WL);
  truth.twin_swing_rad = {s.twin.swing_rad[0], s.twin.swing_rad[1]};
  truth.wire_tension_n = s.crane.tension_n;
  return truth;
}

Status SimulatedLab::set_fault(std::string_view device, std::string_view fault, bool active, double value) {
  if (const auto names = fault_names(device); fault == kOk && !names.empty()) {
    // Ending what never began changes nothing, and what the device cannot have it need not end.
    for (const std::string& name : names) {
      if (active) (void)set_fault(device, name, false);
    }
    return Done{};
  }
  if (device == kMru1) return impl_->set_fault(impl_->mru1_wire, impl_->mru1, fault, active, value);
  if (device == kMru2) return impl_->set_fault(impl_->mru2_wire, impl_->mru2, fault, active, value);
  if (device == kQualisys)
    return impl_->set_fault(impl_->qualisys_wire, impl_->qualisys, fault, active, value);
  if (device == kArm) return impl_->set_fault(impl_->arm_wire, impl_->arm, fault, active, value);
  if (device == kWinch) return impl_->set_fault(impl_->winch_wire, impl_->winch, fault, active, value);
  if (device == kPlc && impl_->plc_end)
    return impl_->set_fault(impl_->plc_end->wire, impl_->plc_end->device, fault, active, value);
  if (device == kWorld) {
    const Status done = impl_->gust.set(fault, active, value);
    impl_->world.set_push(impl_->gust.force_n());
    return done;
  }
  return Fault{Reason::refused,
               "no such device; there are mru1, mru2, qualisys, arm, winch and world, and plc where "
               "[devices.plc_reply] is enabled"};
}

std::vector<std::string> SimulatedLab::fault_names(std::string_view device) const {
  std::string names;
  if (device == kMru1 || device == kMru2) {
    names = mru::MruDevice::fault_names();
  } else if (device == kQualisys) {
    names = impl_->qualisys.fault_names();
  } else if (device == kArm) {
    names = comau::ComauDevice::fault_names();
  } else if (device == kWinch) {
    names = winch::WinchDevice::fault_names();
  } else if (device == kPlc && impl_->plc_end) {
    names = plc_reply::PlcReplyDevice::fault_names();
  } else if (device == kWorld) {
    return {std::string(Gust::kName)};
  } else {
    return {};
  }
  std::istringstream words(names.append(" ").append(faults::WireFaults::kNames));
  return {std::istream_iterator<std::string>(words), {}};
}

}  // namespace motionlab::lab
