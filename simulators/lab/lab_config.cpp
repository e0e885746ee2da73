#include "simulators/lab/lab_config.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <sstream>

#include "drivers/core/error.hpp"
#include "simulators/lab/motion_csv.hpp"

namespace motionlab::lab {

namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180;

Vector3d vector3(const std::array<double, 3>& a) {
  return {a[0], a[1], a[2]};
}

void read_vector(const TomlTable& t, std::string_view key, Vector3d& value, double unit = 1.0) {
  if (t.has(key)) value = unit * vector3(t.numbers<3>(key));
}

void read_joints(const TomlTable& t, std::string_view key, std::array<double, 6>& value, double unit = 1.0,
                 Range range = {}) {
  if (!t.has(key)) return;
  value = t.numbers<6>(key, range);
  for (double& v : value) v *= unit;
}

void read_number(const TomlTable& t, std::string_view key, double& value, Range range = {}) {
  value = t.number_or(key, value, range);
}

/// A number that the file says in degrees.
void read_degrees(const TomlTable& t, std::string_view key, double& value_rad, Range range = {}) {
  if (t.has(key)) value_rad = kDegree * t.number(key, range);
}

void read_pose(const TomlTable& calibration, std::string_view key, math::RigidTransform& pose) {
  if (!calibration.has(key)) return;
  const TomlTable t = calibration.table(key);
  const auto q = t.numbers<4>("q", {-1, 1});
  const Eigen::Vector4d q_wxyz(q[0], q[1], q[2], q[3]);
  if (std::abs(q_wxyz.norm() - 1) > 1e-3)
    t.fail("q", "the quaternion is not of unit length; write w, x, y, z");
  pose = math::RigidTransform::from_quaternion(q_wxyz, vector3(t.numbers<3>("p_m", {-100, 100})));
}

void read_calibration(const TomlTable& t, plant::Calibration& c) {
  read_pose(t, "world_to_em8000", c.world_to_em8000);
  read_pose(t, "world_to_em1500", c.world_to_em1500);
  read_pose(t, "em8000_to_comau", c.em8000_to_comau);
  read_pose(t, "world_to_qtm", c.world_to_qtm);
  read_pose(t, "em8000_to_mru1", c.em8000_to_mru1);
  read_pose(t, "em1500_to_mru2", c.em1500_to_mru2);
}

void read_differences(const TomlTable& t, plant::Differences& d) {
  read_number(t, "joint_bandwidth_factor", d.joint_bandwidth_factor, {0.1, 10});
  read_number(t, "sensor_extra_latency_s", d.sensor_extra_latency_s, {0, 1});
  read_number(t, "calibration_offset_m", d.calibration_offset_m, {0, 0.1});
  read_degrees(t, "calibration_angle_deg", d.calibration_angle_rad, {0, 10});
  read_number(t, "wire_extra_m", d.wire_extra_m, {-0.5, 0.5});
  read_number(t, "mru_noise_factor", d.mru_noise_factor, {0, 100});
}

void read_arm(const TomlTable& t, plant::WorldConfig& w) {
  read_number(t, "a1_m", w.arm_geometry.a1_m, {0, 10});
  read_number(t, "a2_m", w.arm_geometry.a2_m, {0, 10});
  read_number(t, "a3_m", w.arm_geometry.a3_m, {0, 10});
  read_number(t, "d1_m", w.arm_geometry.d1_m, {0, 10});
  read_number(t, "reach_m", w.arm_geometry.reach_m, {0, 10});
  read_joints(t, "home_deg", w.home_rad, kDegree, {-360, 360});
  w.arm_mode.flexible = t.boolean_or("flexible", w.arm_mode.flexible);
  // Faster than this the tick is too long for the arm's own oscillation.
  read_number(t, "mode_frequency_hz", w.arm_mode.frequency_hz, {0.5, 200});
  read_number(t, "mode_damping_ratio", w.arm_mode.damping_ratio, {0, 2});
  read_number(t, "mode_mass_kg", w.arm_mode.mass_kg, {1, 10000});
  read_joints(t, "omega_radps", w.arm.omega_radps, 1.0, {0.1, 500});
  read_joints(t, "zeta", w.arm.zeta, 1.0, {0.05, 5});
  read_number(t, "command_delay_s", w.arm.command_delay_s, {0, 1});
  read_joints(t, "stroke_min_deg", w.arm.stroke_min_rad, kDegree);
  read_joints(t, "stroke_max_deg", w.arm.stroke_max_rad, kDegree);
  read_joints(t, "speed_max_degps", w.arm.speed_max_radps, kDegree, Range::positive());
  read_joints(t, "acceleration_max_radps2", w.arm.acceleration_max_radps2, 1.0, Range::positive());
  read_number(t, "encoder_noise_rms_rad", w.encoder.joint_noise_rms_rad, {0, 0.1});
  read_number(t, "encoder_quantum_rad", w.encoder.joint_quantum_rad, {0, 0.1});
  read_number(t, "speed_noise_rms_radps", w.encoder.joint_speed_noise_rms_radps, {0, 1});
}

void read_winch(const TomlTable& t, plant::WorldConfig& w) {
  read_number(t, "omega_radps", w.winch.omega_radps, {0.1, 500});
  read_number(t, "zeta", w.winch.zeta, {0.05, 5});
  read_number(t, "speed_max_mps", w.winch.speed_max_mps, Range::positive());
  read_number(t, "acceleration_max_mps2", w.winch.acceleration_max_mps2, Range::positive());
  read_number(t, "length_at_zero_travel_m", w.winch.length_at_zero_travel_m, {0.1, 50});
  read_number(t, "travel_m", w.winch.travel_m, {0, 50});
  read_number(t, "wire_per_motor_rev_m", w.winch.wire_per_motor_rev_m, Range::positive());
  const double shortest = w.winch.length_at_zero_travel_m;
  read_number(t, "start_length_m", w.start_wire_length_m, {shortest, shortest + w.winch.travel_m});
}

void read_load(const TomlTable& t, const plant::WorldConfig& w, plant::LoadConfig& c) {
  read_number(t, "mass_kg", c.mass_kg, {0.1, 1000});
  read_number(t, "gravity_mps2", c.gravity_mps2, Range::positive());
  // Stiffer than this the tick is too long for the wire's own oscillation.
  read_number(t, "wire_ea_n", c.wire_ea_n, {1e3, 2e6 * c.mass_kg});
  read_number(t, "wire_damping_ratio", c.wire_damping_ratio, {0, 2});
  read_number(t, "swing_damping_ratio", c.swing_damping_ratio, {0, 2});
  read_number(t, "radius_m", c.radius_m, {0, 2});
  read_number(t, "drag_coefficient", c.drag_coefficient, {0, 5});
  read_number(t, "air_density_kgpm3", c.air_density_kgpm3, {0, 2});
  c.rigid_body = t.boolean_or("rigid_body", c.rigid_body);
  // Some wire has to be left above the hook, and a body smaller than this tilts too fast for the tick.
  read_number(t, "hook_to_centre_m", c.hook_to_centre_m, {0, 0.8 * w.winch.length_at_zero_travel_m});
  read_number(t, "gyration_radius_m", c.gyration_radius_m, {0.01, 5});
  read_number(t, "tilt_damping_ratio", c.tilt_damping_ratio, {0, 2});
}

void read_sea(const TomlTable& t, LabConfig::SeaWish& c) {
  if (t.has("significant_height_m")) c.significant_height_m = t.number("significant_height_m", {0, 20});
  if (t.has("peak_period_s")) c.peak_period_s = t.number("peak_period_s", {1, 100});
  if (t.has("peak_enhancement")) c.peak_enhancement = t.number("peak_enhancement", {1, 10});
  plant::WaveDirection direction;
  read_degrees(t, "mean_direction_deg", direction.mean_rad, {-360, 360});
  read_degrees(t, "spreading_deg", direction.spreading_rad, {0, 180});
  if (t.boolean_or("directional", false)) c.direction = direction;
}

void read_second_ship(const TomlTable& t, LabConfig& c) {
  c.second_ship_height_m = t.number_or("significant_height_m", c.second_ship_height_m, {0, 20});
  if (t.has("scenario")) c.set_second_ship(t.text("scenario"));
}

void read_mru(const TomlTable& t, plant::MruConfig& c) {
  read_number(t, "period_s", c.period_s, {0.001, 1});
  read_number(t, "output_latency_s", c.output_latency_s, {0, 1});
  read_vector(t, "misalignment_deg", c.misalignment_rad, kDegree);
  read_vector(t, "lever_to_origin_m", c.lever_to_origin_m);
  c.high_pass = t.boolean_or("high_pass", c.high_pass);
  read_number(t, "surge_sway_period_s", c.surge_sway_period_s, {0.1, 100});
  read_number(t, "surge_sway_damping", c.surge_sway_damping, {0.1, 2});
  read_number(t, "heave_period_s", c.heave_period_s, {0.1, 100});
  read_number(t, "heave_damping", c.heave_damping, {0.1, 2});
  read_number(t, "roll_pitch_rms_rad", c.roll_pitch_rms_rad, {0, 0.1});
  read_number(t, "roll_pitch_correlation_s", c.roll_pitch_correlation_s, Range::positive());
  read_number(t, "roll_pitch_white_rms_rad", c.roll_pitch_white_rms_rad, {0, 0.1});
  if (t.has("yaw_walk_deg_per_sqrt_min")) {
    c.yaw_walk_rad_per_sqrt_s = kDegree * t.number("yaw_walk_deg_per_sqrt_min", {0, 100}) / std::sqrt(60.0);
  }
  read_number(t, "rate_noise_rms_radps", c.rate_noise_rms_radps, {0, 1});
  read_number(t, "acceleration_noise_rms_mps2", c.acceleration_noise_rms_mps2, {0, 10});
  read_vector(t, "acceleration_bias_mps2", c.acceleration_bias_mps2);
  read_number(t, "temperature_degc", c.temperature_degc, {-50, 100});
}

void read_camera(const TomlTable& t, plant::CameraConfig& c) {
  read_number(t, "period_s", c.period_s, {0.001, 1});
  read_number(t, "latency_s", c.latency_s, {0, 1});
  read_number(t, "marker_noise_rms_m", c.marker_noise_rms_m, {0, 1});
  c.load_markers = static_cast<int>(t.integer_or("load_markers", c.load_markers, {1, 100}));
  c.platform_markers = static_cast<int>(t.integer_or("platform_markers", c.platform_markers, {1, 100}));
  read_number(t, "correlated_rms_m", c.correlated_rms_m, {0, 1});
  read_number(t, "correlation_s", c.correlation_s, Range::positive());
  read_degrees(t, "angle_noise_rms_deg", c.angle_noise_rms_rad, {0, 10});
  read_number(t, "dropouts_per_minute", c.dropouts_per_minute, {0, 10000});
  read_number(t, "dropout_s", c.dropout_s, {0, 1000});
}

mru::VariableList read_variables(const TomlTable& t) {
  std::vector<mru::Variable> variables;
  for (const double number : t.numbers("variables", {0, 65535})) {
    variables.push_back(static_cast<mru::Variable>(number));
  }
  const auto list = mru::VariableList::of(variables);
  if (!list) t.fail("variables", list.fault().text);
  return *list;
}

void read_mru_device(const TomlTable& t, LabConfig::Mru& c) {
  c.from = t.endpoint_or("from", c.from);
  c.device.to = t.endpoint_or("to", c.device.to);
  c.device.layout.token = static_cast<std::uint8_t>(t.integer_or("token", c.device.layout.token, {0, 255}));
  c.device.format =
      mru::kFormats[t.choice_or("format", static_cast<std::size_t>(c.device.format), mru::kFormatNames)];
  if (t.has("variables")) c.device.layout.variables = read_variables(t);
  c.device.layout.text_in_degrees = t.choice_or("text_angles", 0, {"rad", "deg"}) == 1;
  constexpr std::array kRules{mru::ChecksumRule::sum8, mru::ChecksumRule::ones_complement};
  const std::size_t now = c.device.checksum_rule == kRules[0] ? 0 : 1;
  c.device.checksum_rule = kRules[t.choice_or("checksum", now, {"sum8", "ones_complement"})];
  c.device.system_time_start_ms = static_cast<std::uint32_t>(
      t.integer_or("system_time_start_ms", c.device.system_time_start_ms, {0, 4294967295}));
  read_number(t, "output_jitter_s", c.device.output_jitter_s, {0, 1});
  read_number(t, "settling_s", c.device.settling_s, Range::at_least(0));
  read_number(t, "clock_drift_ppm", c.device.clock_drift_ppm, {-1000, 1000});
}

void read_pendant(const TomlTable& t, comau::Pendant::Config& c) {
  read_number(t, "powerlink_after_s", c.powerlink_after_s, Range::at_least(0));
  read_number(t, "drive_on_after_s", c.drive_on_after_s, Range::at_least(0));
  read_number(t, "driving_on_s", c.driving_on_s, Range::at_least(0));
  read_number(t, "start_after_s", c.start_after_s, Range::at_least(0));
  read_number(t, "driving_off_s", c.driving_off_s, Range::at_least(0));
  read_number(t, "override_percent", c.override_percent, {1, 100});
}

void read_arm_device(const TomlTable& t, LabConfig& c) {
  c.arm_listen = t.endpoint_or("listen", c.arm_listen);
  c.arm.hardened = t.boolean_or("hardened", c.arm.hardened);
  c.arm.peer = t.endpoint_or("peer", c.arm.peer);
  read_joints(t, "q_min_deg", c.arm.q_min_rad, kDegree);
  read_joints(t, "q_max_deg", c.arm.q_max_rad, kDegree);
  read_joints(t, "speed_max_degps", c.arm.qd_max_radps, kDegree, Range::positive());
  read_number(t, "deceleration_radps2", c.arm.deceleration_radps2, Range::positive());
  read_number(t, "command_age_max_s", c.arm.command_age_max_s, Range::positive());
  if (t.has("acceleration_max_radps2")) {
    c.arm.acceleration_max_radps2.fill(t.number("acceleration_max_radps2", Range::positive()));
  }
  const auto bytes = t.integer_or("answer_bytes", c.arm.long_answers ? 124 : 52, {52, 124});
  if (bytes != 52 && bytes != 124) t.fail("answer_bytes", "answers have 52 or 124 bytes");
  c.arm.long_answers = bytes == 124;
  read_number(t, "remote_enabled_after_s", c.arm.remote_enabled_after_s, Range::at_least(0));
  read_pendant(t.table_or_empty("pendant"), c.arm.pendant);
}

void read_winch_device(const TomlTable& t, LabConfig& c) {
  c.winch_listen = t.endpoint_or("listen", c.winch_listen);
  if (t.has("net_id")) {
    try {
      c.winch.net_id = winch::NetId::parse(t.text("net_id"));
    } catch (const StartupError& error) {
      t.fail("net_id", error.what());
    }
  }
  c.winch.plc_port = static_cast<std::uint16_t>(t.integer_or("ams_port", c.winch.plc_port, {1, 65535}));
  c.winch.project = t.choice_or("project", 0, {"gvl_winch", "legacy"}) == 1 ? winch::PlcProject::legacy
                                                                            : winch::PlcProject::gvl_winch;
  for (const auto& route : t.texts_or("routes", {})) {
    try {
      c.winch.routes.push_back(winch::NetId::parse(route));
    } catch (const StartupError& error) {
      t.fail("routes", error.what());
    }
  }
  read_number(t, "position_max_m", c.winch.plc.position_max_m, {0, c.world.winch.travel_m});
}

void read_qualisys_device(const TomlTable& t, LabConfig& c) {
  c.qualisys_listen = t.endpoint_or("listen", c.qualisys_listen);
  if (t.has("big_endian_listen")) c.qualisys_big_endian_listen = t.endpoint("big_endian_listen");
  if (t.has("discovery_listen")) c.qualisys_discovery_listen = t.endpoint("discovery_listen");
  read_number(t, "jitter_s", c.qualisys.jitter_s, {0, 1});
  read_number(t, "hook_marker_spacing_m", c.hook_marker_spacing_m, {0, 1});
  c.qualisys.newest_version_minor =
      static_cast<int>(t.integer_or("newest_version_minor", c.qualisys.newest_version_minor, {8, 28}));
  using qualisys::TimecodeSource;
  constexpr std::array timecodes{TimecodeSource::none, TimecodeSource::smpte, TimecodeSource::irig,
                                 TimecodeSource::camera};
  c.qualisys.timecode = timecodes[t.choice_or("timecode", 0, {"none", "smpte", "irig", "camera"})];
}

void read_plc_reply_device(const TomlTable& t, LabConfig& c) {
  c.plc_reply_enabled = t.boolean_or("enabled", c.plc_reply_enabled);
  c.plc_reply_listen = t.endpoint_or("listen", c.plc_reply_listen);
  c.plc_reply.to = t.endpoint_or("to", c.plc_reply.to);
}

}  // namespace

LabConfig::LabConfig() {
  mru1.from = Endpoint::parse("127.0.0.1:50013");
  mru1.device.to = Endpoint::parse("127.0.0.1:50043");
  mru2.from = Endpoint::parse("127.0.0.1:50014");
  mru2.device.to = Endpoint::parse("127.0.0.1:50044");
  mru2.device.layout.token = 12;
  mru2.device.name = kMru2;
  qualisys_listen = Endpoint::parse("127.0.0.1:22223");
  arm_listen = Endpoint::parse("127.0.0.1:50032");
  arm.hardened = true;
  arm.peer = Endpoint::parse("127.0.0.1:0");
  arm.pendant = {.driving_on_s = 1.0, .start_after_s = 0.3, .driving_off_s = 1.0};
  winch_listen = Endpoint::parse("127.0.0.1:48898");
  plc_reply_listen = Endpoint::parse("127.0.0.1:50050");
  plc_reply.to = Endpoint::parse("127.0.0.1:50060");
}

LabConfig LabConfig::load(const std::filesystem::path& file,
                          const std::vector<std::filesystem::path>& overlays,
                          const std::vector<TomlText>& texts) {
  const TomlDocument document = TomlDocument::load(file, overlays, texts);
  const TomlTable root = document.root();
  LabConfig c;
  read_differences(root.table_or_empty("differences"), c.world.differences);
  read_calibration(root.table_or_empty("calibration"), c.world.calibration);
  read_sea(root.table_or_empty("sea"), c.sea);
  read_second_ship(root.table_or_empty("second_ship"), c);
  read_arm(root.table_or_empty("arm"), c.world);
  read_winch(root.table_or_empty("winch"), c.world);
  read_load(root.table_or_empty("load"), c.world, c.world.load);
  read_mru(root.table_or_empty("mru1"), c.world.mru1);
  read_mru(root.table_or_empty("mru2"), c.world.mru2);
  c.world.mru1.gravity_mps2 = c.world.mru2.gravity_mps2 = c.world.load.gravity_mps2;
  read_camera(root.table_or_empty("camera"), c.world.camera);

  const TomlTable devices = root.table_or_empty("devices");
  read_mru_device(devices.table_or_empty(kMru1), c.mru1);
  read_mru_device(devices.table_or_empty(kMru2), c.mru2);
  read_qualisys_device(devices.table_or_empty(kQualisys), c);
  read_arm_device(devices.table_or_empty(kArm), c);
  read_winch_device(devices.table_or_empty(kWinch), c);
  read_plc_reply_device(devices.table_or_empty("plc_reply"), c);

  for (const std::string& text : devices.texts_or("faults", {})) {
    c.faults.push_back(PlannedFault::parse(text));
  }

  const TomlTable bus = root.table_or_empty("bus");
  c.bus_domain = static_cast<int>(bus.integer_or("domain", c.bus_domain, {0, 232}));
  c.bus_interfaces = bus.texts_or("interfaces", c.bus_interfaces);
  document.refuse_unknown_keys();
  return c;
}

void LabConfig::set_scenario(std::string_view name) {
  if (constexpr std::string_view kCsv = "csv:"; name.starts_with(kCsv)) {
    scenario = {.sea = plant::Sea::recorded};
    scenario.recording = std::make_shared<plant::RecordedMotion>(
        read_motion_csv(std::filesystem::path(name.substr(kCsv.size()))));
    return;
  }
  const auto found = plant::scenario_named(name);
  if (!found) {
    throw StartupError("there is no scenario \"" + std::string(name) +
                       "\"; choose thesis-wave, sea, pierson-moskowitz, calm or csv:FILE");
  }
  scenario = *found;
  scenario.significant_height_m = sea.significant_height_m.value_or(scenario.significant_height_m);
  scenario.peak_period_s = sea.peak_period_s.value_or(scenario.peak_period_s);
  scenario.peak_enhancement = sea.peak_enhancement.value_or(scenario.peak_enhancement);
  scenario.direction = sea.direction;
}

void LabConfig::set_second_ship(std::string_view name) {
  const auto found = plant::scenario_named(name);
  if (!found) {
    throw StartupError("the second ship knows no scenario \"" + std::string(name) +
                       "\"; choose calm, sea, pierson-moskowitz or thesis-wave");
  }
  world.second_ship = *found;
  world.second_ship.significant_height_m = second_ship_height_m;
}

void LabConfig::refuse_beyond(const plant::PlatformLimits& limits, double seconds) const {
  const auto found = plant::excess(plant::ShipMotion(scenario, seed), limits, seconds);
  if (!found) return;
  std::string advice;
  const auto rounded_down = [](double value) {
    std::ostringstream text;
    text << std::floor(1000 * value) / 1000;
    return text.str();
  };
  switch (scenario.sea) {
    case plant::Sea::jonswap:
    case plant::Sea::pierson_moskowitz:
      advice = "with seed " + std::to_string(seed) + " and Tp " + rounded_down(scenario.peak_period_s) +
               " s the largest Hs that fits is " +
               rounded_down(scenario.significant_height_m * found->share_that_fits) +
               " m; write it as significant_height_m in [sea] of world.toml";
      break;
    case plant::Sea::recorded:
      advice = "the largest share of the recording that fits is " + rounded_down(found->share_that_fits) +
               "; scale its six columns by it";
      break;
    default:
      advice = "the largest share that fits is " + rounded_down(found->share_that_fits) +
               "; choose another scenario or --limits mechanical";
  }
  throw StartupError("the sea is too much for the platform: " + plant::describe(*found, limits) + "; " +
                     advice);
}

}  // namespace motionlab::lab
