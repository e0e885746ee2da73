#include "gateway/service/gateway_config.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "drivers/core/error.hpp"
#include "drivers/core/toml_reader.hpp"
#include "gateway/service/roll_call.hpp"

namespace motionlab::service {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;
/// The fastest joint while nothing but us would stop the arm.
constexpr double kSpeedWithoutWatchdog = 0.1;

constexpr Range kPeriod{.low = 0.0002, .high = 1.0};
constexpr Range kLatency{.low = 0.0, .high = 0.5};
constexpr Range kFreshness{.low = 0.005, .high = 2.0};
/// Measurements carry noise. As many in a row that are the same to the last bit are none, at any rate.
constexpr double kStuckAfterPeriods = 5.0;

template <std::size_t N>
std::array<double, N> scaled(std::array<double, N> values, double by) {
  for (auto& value : values) value *= by;
  return values;
}

/// Reads a text by its own parser; what that one says is told with the key's place.
template <class Parse>
auto parsed(const TomlTable& table, std::string_view key, Parse&& parse) {
  const std::string text = table.text(key);
  try {
    return parse(text);
  } catch (const StartupError& error) {
    table.fail(key, error.what());
  }
}

math::RigidTransform pose(const TomlTable& table, std::string_view key) {
  const TomlTable entry = table.table(key);
  const auto q = entry.numbers<4>("q", {-1.0, 1.0});
  const auto p = entry.numbers<3>("p_m", {-100.0, 100.0});
  const double norm = Eigen::Map<const Eigen::Vector4d>(q.data()).norm();
  if (std::abs(norm - 1.0) > 1e-3) {
    entry.fail("q", "its length is " + std::to_string(norm) + ", a rotation has 1; write w, x, y, z");
  }
  return math::RigidTransform::from_quaternion(Eigen::Map<const Eigen::Vector4d>(q.data()),
                                               Eigen::Map<const Eigen::Vector3d>(p.data()));
}

/// The variables of MRUBIN by their numbers; those that the product does not know are read over.
mru::VariableList variable_list(const TomlTable& t) {
  const auto numbers = [&t](std::string_view key) {
    std::vector<mru::Variable> variables;
    if (!t.has(key)) return variables;
    for (const double number : t.numbers(key, {0.0, 65535.0})) {
      if (number != std::floor(number)) t.fail(key, "a variable has a whole number");
      variables.push_back(static_cast<mru::Variable>(number));
    }
    return variables;
  };
  const auto f32 = numbers("unlisted_f32"), i32 = numbers("unlisted_i32");
  if (!t.has("variables")) return mru::VariableList::laboratory();
  const auto list = mru::VariableList::of(numbers("variables"), f32, i32);
  if (!list) t.fail("variables", list.fault().text);
  return *list;
}

/// Beyond these a datagram is refused; by default what no ship does.
mru::PlausibilityLimits plausibility(const TomlTable& t) {
  mru::PlausibilityLimits limits;
  if (t.has("tilt_max_deg")) limits.tilt_rad = kDegree * t.number("tilt_max_deg", {1.0, 90.0});
  limits.heave_m = t.number_or("heave_max_m", limits.heave_m, {0.1, 100.0});
  limits.rate_radps = t.number_or("rate_max_radps", limits.rate_radps, {0.1, 100.0});
  return limits;
}

MruLink mru_link(const TomlTable& root, const std::string& name) {
  const TomlTable t = root.table(name);
  MruLink link;
  link.listen = t.endpoint("listen");
  link.driver.device = name;
  link.driver.source_address = parsed(t, "source", Endpoint::parse_address);
  link.driver.format = mru::kFormats[t.choice_or("format", 0, mru::kFormatNames)];
  link.driver.layout.token = static_cast<std::uint8_t>(t.integer("token", {0, 255}));
  link.driver.layout.variables = variable_list(t);
  link.driver.layout.limits = plausibility(t);
  link.driver.layout.text_in_degrees = t.choice_or("text_angles", 0, {"rad", "deg"}) == 1;
  link.driver.period_s = t.number("period_s", kPeriod);
  link.driver.latency_s = t.number("latency_s", kLatency);
  constexpr std::array policies{mru::ChecksumPolicy::ignore, mru::ChecksumPolicy::count,
                                mru::ChecksumPolicy::enforce};
  link.driver.checksum.policy = policies[t.choice("checksum", {"ignore", "count", "enforce"})];
  constexpr std::array rules{std::optional<mru::ChecksumRule>{}, std::optional{mru::ChecksumRule::sum8},
                             std::optional{mru::ChecksumRule::ones_complement}};
  link.driver.checksum.rule = rules[t.choice_or("checksum_rule", 0, {"auto", "sum8", "ones_complement"})];
  link.driver.stuck_after_s =
      t.number_or("stuck_after_s", kStuckAfterPeriods * link.driver.period_s, {0.0, 60.0});
  link.rule.stale_after_s = t.number("stale_after_s", kFreshness);
  return link;
}

QualisysLink qualisys_link(const TomlTable& root) {
  const TomlTable t = root.table("qualisys");
  QualisysLink link;
  link.server = t.endpoint("server");
  link.listen = t.endpoint("listen");
  link.load_body = t.text("load_body");
  link.platform_body = t.text("platform_body");
  link.driver.hook = {t.text("hook_body"), t.number("hook_spacing_m", {0.01, 1.0}),
                      t.number("hook_tolerance_m", {0.0005, 0.05})};
  constexpr std::array orders{std::endian::little, std::endian::big};
  link.driver.byte_order = orders[t.choice("byte_order", {"little", "big"})];
  link.coast_s = t.number("coast_s", {0.0, 10.0});
  link.rest_by_s = t.number("rest_by_s", {0.1, 30.0});
  if (link.rest_by_s <= link.coast_s) t.fail("rest_by_s", "it is not after coast_s");
  link.driver.server_address = link.server.address;
  link.driver.udp_port = link.listen.port;
  link.driver.frame_period_s = t.number("period_s", kPeriod);
  link.driver.latency_s = t.number("latency_s", kLatency);
  link.rule.stale_after_s = t.number("stale_after_s", kFreshness);
  return link;
}

/// The driver's own copy of the arm's limits: what the robot computer keeps it in, whatever the guard allows.
void read_arm_limits(const TomlTable& t, comau::DriverConfig& driver) {
  constexpr Range angle{-2700.0, 2700.0};
  driver.q_min_rad = scaled(t.numbers<6>("q_min_deg", angle), kDegree);
  driver.q_max_rad = scaled(t.numbers<6>("q_max_deg", angle), kDegree);
  for (std::size_t i = 0; i < 6; ++i) {
    if (driver.q_min_rad[i] >= driver.q_max_rad[i]) {
      t.fail("q_min_deg", "joint " + std::to_string(i + 1) + " has its minimum at or above its maximum");
    }
  }
  driver.qd_max_radps = scaled(t.numbers<6>("qd_max_degps", {0.0, 230.0}), kDegree);
  driver.qdd_max_radps2 = t.numbers<6>("qdd_max_radps2", {0.01, 50.0});
  driver.stop_deceleration_radps2 = t.numbers<6>("stop_deceleration_radps2", {0.1, 10.0});
}

ComauLink comau_link(const TomlTable& root) {
  const TomlTable t = root.table("comau");
  ComauLink link;
  link.listen = t.endpoint("listen");
  link.driver.robot_computer = t.endpoint("robot_computer");
  link.driver.command_period_s = t.number("command_period_s", {0.001, 0.02});
  link.driver.latency_s = t.number("latency_s", kLatency);
  link.rule.stale_after_s = t.number("stale_after_s", kFreshness);
  link.driver.command_stale_after_s = link.rule.stale_after_s;
  link.driver.answer_stale_after_s = link.rule.stale_after_s;
  read_arm_limits(t, link.driver);
  return link;
}

WinchLink winch_link(const TomlTable& root) {
  const TomlTable t = root.table("winch");
  WinchLink link;
  link.plc = t.endpoint("plc");
  link.driver.target = {parsed(t, "net_id", winch::NetId::parse),
                        static_cast<std::uint16_t>(t.integer("ads_port", {1, 65535}))};
  link.driver.local = {parsed(t, "local_net_id", winch::NetId::parse),
                       static_cast<std::uint16_t>(t.integer("local_ads_port", {1, 65535}))};
  link.driver.command_period_s = t.number("command_period_s", {0.005, 0.05});
  link.driver.latency_s = t.number("latency_s", kLatency);
  link.driver.wire_at_zero_travel_m = t.number("wire_at_zero_travel_m", {0.0, 20.0});
  link.driver.pay_out_sign = t.number("pay_out_sign", {-1.0, 1.0});
  if (std::abs(link.driver.pay_out_sign) != 1.0) t.fail("pay_out_sign", "it is a sign; write 1.0 or -1.0");
  link.driver.profile =
      t.choice("profile", {"gvl_winch", "legacy"}) == 1 ? winch::Profile::legacy : winch::Profile::gvl_winch;
  link.driver.legacy_commands = t.boolean("legacy_commands");
  link.driver.legacy_speed_max_mps = t.number("legacy_speed_max_mps", {0.0, 0.2});
  link.driver.legacy_travel_m = t.number("legacy_travel_m", {0.0, 10.0});
  link.rule.stale_after_s = t.number("stale_after_s", kFreshness);
  return link;
}

/// Checked also where it is not enabled. An older file may lack the table.
std::optional<PlcReplyLink> plc_reply_link(const TomlTable& root) {
  if (!root.has("plc_reply")) return std::nullopt;
  const TomlTable t = root.table("plc_reply");
  PlcReplyLink link;
  link.listen = t.endpoint("listen");
  link.driver.plc = t.endpoint("plc");
  link.driver.period_s = t.number("period_s", {0.005, 0.1});
  link.driver.latency_s = t.number("latency_s", kLatency);
  link.driver.mru_latency_s = t.number("mru_latency_s", kLatency);
  constexpr std::array orders{plc_reply::EulerOrder::xyz, plc_reply::EulerOrder::zyx};
  link.driver.euler_order = orders[t.choice("euler_order", {"xyz", "zyx"})];
  link.driver.silent_after_s = std::max(link.driver.silent_after_s, 5.0 * link.driver.period_s);
  link.rule.stale_after_s = t.number("stale_after_s", kFreshness);
  return t.boolean("enabled") ? std::optional(link) : std::nullopt;
}

/// An older file knows multicast alone.
bus::DdsConfig dds_config(const TomlTable& root) {
  const TomlTable t = root.table("bus");
  bus::DdsConfig dds;
  dds.domain = static_cast<int>(t.integer("domain", {0, 232}));
  dds.interface_whitelist = t.texts("interfaces");
  dds.participant = t.text("participant");
  dds.peers = t.texts_or("peers", {});
  for (const std::string& peer : dds.peers) {
    try {
      (void)Endpoint::parse_address(peer);
    } catch (const StartupError& error) {
      t.fail("peers", error.what());
    }
  }
  dds.server = t.text_or("server", "");
  if (!dds.server.empty()) (void)t.endpoint("server");
  if (!dds.server.empty() && !dds.peers.empty()) t.fail("server", "there are peers, too; choose one of them");
  dds.security = t.text_or("security", "");
  if (!dds.server.empty() && !dds.security.empty())
    t.fail("security", "a discovery server has no identity; name peers, or use multicast");
  return dds;
}

DeadmanRule deadman_rule(const TomlTable& root) {
  const TomlTable t = root.table("deadman");
  return {t.number("heartbeat_s", {0.01, 2.0}), t.number("control_s", {0.02, 5.0})};
}

/// Read once the devices are known. An older file may lack the table.
void read_service(const TomlTable& root, GatewayConfig& config) {
  const TomlTable t = root.table_or_empty("service");
  constexpr std::array levels{LogLevel::info, LogLevel::warning, LogLevel::error};
  config.log_level = levels[t.choice_or("log_level", 0, {"info", "warning", "error"})];
  config.absent = t.texts_or("absent", {});
  const std::vector<std::string> known = device_names(config);
  for (const auto& device : config.absent) {
    if (std::find(known.begin(), known.end(), device) != known.end()) continue;
    std::string names;
    for (const auto& name : known) names += (names.empty() ? "" : ", ") + name;
    t.fail("absent", "there is no device " + device + "; the devices are " + names);
  }
}

controller::GuardLimits guard_limits(const TomlTable& root) {
  const TomlTable t = root.table("limits");
  constexpr Range angle{-2700.0, 2700.0};
  controller::GuardLimits limits;
  limits.q_min_rad = scaled(t.numbers<6>("q_min_deg", angle), kDegree);
  limits.q_max_rad = scaled(t.numbers<6>("q_max_deg", angle), kDegree);
  for (std::size_t i = 0; i < 6; ++i) {
    if (limits.q_min_rad[i] >= limits.q_max_rad[i]) {
      t.fail("q_min_deg", "joint " + std::to_string(i + 1) + " has its minimum at or above its maximum");
    }
  }
  limits.qd_max_radps = scaled(t.numbers<6>("qd_max_degps", {0.0, 230.0}), kDegree);
  limits.qdd_max_radps2 = t.numbers<6>("qdd_max_radps2", {0.0, 50.0});
  limits.jerk_max_radps3 = t.number("jerk_max_radps3", {1.0, 1e5});
  limits.stop_deceleration_radps2 = t.number("stop_deceleration_radps2", {0.1, 10.0});
  limits.wire_min_m = t.number("wire_min_m", {0.0, 20.0});
  limits.wire_max_m = t.number("wire_max_m", {0.0, 20.0});
  if (limits.wire_min_m >= limits.wire_max_m) t.fail("wire_min_m", "it is not below wire_max_m");
  limits.wire_speed_max_mps = t.number("wire_speed_max_mps", {0.0, 2.378});
  // Slower than the load falls, or the wire goes slack under a hand's push already.
  limits.wire_acceleration_max_mps2 = t.number("wire_acceleration_max_mps2", {0.01, 3.567});
  limits.motor_torque_min_nm = t.number("motor_torque_min_nm", {-1000.0, 1000.0});
  limits.motor_torque_max_nm = t.number("motor_torque_max_nm", {-1000.0, 1000.0});
  if (limits.motor_torque_min_nm >= limits.motor_torque_max_nm)
    t.fail("motor_torque_min_nm", "it is not below motor_torque_max_nm");
  return limits;
}

/// Needs the arm and where the second platform stands.
controller::FenceLimits fence_limits(const TomlTable& root, const math::CraneArmGeometry& arm,
                                     const Eigen::Vector3d& p_world_second_m) {
  const TomlTable t = root.table("limits");
  controller::FenceLimits fences;
  constexpr Range place{-10.0, 10.0};
  const auto low = t.numbers<3>("p_base_tool_min_m", place), high = t.numbers<3>("p_base_tool_max_m", place);
  for (std::size_t i = 0; i < 3; ++i) {
    if (low[i] >= high[i]) t.fail("p_base_tool_min_m", "a minimum is at or above its maximum");
  }
  fences.arm = arm;
  fences.p_base_tool_min_m = Eigen::Map<const Eigen::Vector3d>(low.data());
  fences.p_base_tool_max_m = Eigen::Map<const Eigen::Vector3d>(high.data());
  fences.load_height_min_m = t.number("load_height_min_m", {0.0, 10.0});
  fences.p_world_second_m = p_world_second_m;
  fences.distance_to_second_min_m = t.number("distance_to_second_min_m", {0.0, 10.0});
  return fences;
}

ModeRules mode_rules(const TomlTable& root) {
  const TomlTable t = root.table("modes");
  ModeRules rules;
  const auto devices = [&t](std::string_view key) {
    auto names = t.texts(key);
    for (const auto& name : names) {
      constexpr std::array known{"mru1", "mru2", "qualisys", "arm", "winch"};
      if (std::ranges::find(known, name) == known.end())
        t.fail(key, name + " is no device; write mru1, mru2, qualisys, arm or winch");
    }
    return names;
  };
  rules.engaged = devices("engaged");
  rules.to_engage = devices("to_engage");
  for (const char* const always : {"mru1", "arm", "winch"}) {
    if (std::ranges::find(rules.engaged, always) == rules.engaged.end()) {
      t.fail("engaged", std::string(always) + " is missing: without it there is no estimate to move by");
    }
  }
  rules.cross_check_tilt_deg = t.number("cross_check_tilt_deg", {0.05, 20.0});
  rules.cross_check_load_m = t.number("cross_check_load_m", {0.02, 2.0});
  return rules;
}

RecordRule record_rule(const TomlTable& root) {
  const TomlTable t = root.table("record");
  RecordRule rule;
  rule.inputs = t.text("inputs");
  rule.outputs_every = static_cast<std::uint32_t>(t.integer("outputs_every", {1, 1'000'000}));
  rule.zstd_level = static_cast<int>(t.integer("zstd_level", {0, 19}));
  return rule;
}

math::CraneArmGeometry arm_geometry(const TomlTable& t) {
  constexpr Range length{0.0, 5.0};
  return {t.number("a1_m", length), t.number("a2_m", length), t.number("a3_m", length),
          t.number("d1_m", length), t.number("reach_m", length)};
}

estimator::Belief belief(const TomlTable& root, const math::CraneArmGeometry& arm) {
  const TomlTable t = root.table("calibration");
  estimator::Belief belief;
  auto& c = belief.calibration;
  c.X_WN = pose(t, "world_to_em8000");
  c.X_BR = pose(t, "em8000_to_comau");
  c.X_WQ = pose(t, "world_to_qtm");
  c.X_BP = pose(t, "em8000_to_platform_body");
  const auto misalignment = scaled(t.numbers<3>("mru1_misalignment_deg", {-10.0, 10.0}), kDegree);
  const auto lever = t.numbers<3>("mru1_lever_to_origin_m", {-20.0, 20.0});
  c.X_BM = pose(t, "em8000_to_mru1");
  c.X_BM.R = c.X_BM.R *
             math::from_euler(Eigen::Map<const Eigen::Vector3d>(misalignment.data()), math::EulerOrder::zyx);
  c.p_MO = Eigen::Map<const Eigen::Vector3d>(lever.data());
  constexpr std::array orders{math::EulerOrder::zyx, math::EulerOrder::xyz};
  c.mru_order = orders[t.choice("mru_euler_order", {"zyx", "xyz"})];
  c.arm = arm;
  const auto second_misalignment = scaled(t.numbers<3>("mru2_misalignment_deg", {-10.0, 10.0}), kDegree);
  const auto second_lever = t.numbers<3>("mru2_lever_to_origin_m", {-20.0, 20.0});
  c.second.X_WN = pose(t, "world_to_em1500");
  c.second.X_BM = pose(t, "em1500_to_mru2");
  c.second.X_BM.R =
      c.second.X_BM.R *
      math::from_euler(Eigen::Map<const Eigen::Vector3d>(second_misalignment.data()), math::EulerOrder::zyx);
  c.second.p_MO = Eigen::Map<const Eigen::Vector3d>(second_lever.data());
  c.second.order = c.mru_order;
  return belief;
}

GatewayConfig read(const TomlDocument& document) {
  const TomlTable root = document.root();
  GatewayConfig config;
  config.effective = document.effective();

  const TomlTable control = root.table("control");
  config.control_period_s = control.number("period_s", {0.0005, 0.01});
  config.control_cpu = static_cast<int>(control.integer("cpu", {-1, 1023}));
  config.io_cpu = static_cast<int>(control.integer("io_cpu", {-1, 1023}));
  config.control_awake = control.boolean_or("awake", false);  // recordings of before it have none
  if (config.control_awake && config.control_cpu < 0)
    control.fail("awake", "no processor is chosen that could be kept awake; choose one with cpu");
  constexpr std::array ladder{topic::Authority::observe, topic::Authority::shadow, topic::Authority::limited,
                              topic::Authority::full};
  config.authority = ladder[control.choice("authority", {"observe", "shadow", "limited", "full"})];
  constexpr std::array laws{ControlLaw::ours, ControlLaw::integral};
  config.law = laws[control.choice("law", {"ours", "integral"})];
  const bool tracked =
      control.choice("platform", {"tracked", "untracked"}) == 0;  // taken below, by all it concerns

  config.bus = dds_config(root);

  config.mrus = {mru_link(root, "mru1"), mru_link(root, "mru2")};
  config.qualisys = qualisys_link(root);
  config.comau = comau_link(root);
  config.winch = winch_link(root);
  config.plc_reply = plc_reply_link(root);
  config.deadman = deadman_rule(root);
  read_service(root, config);
  config.limits = guard_limits(root);
  config.limits.posture_age_max_s =
      std::max(config.comau.rule.stale_after_s, config.winch.rule.stale_after_s) + 0.05;
  config.modes = mode_rules(root);
  const auto required = [&config](const char* device) {
    return std::ranges::find(config.modes.to_engage, device) != config.modes.to_engage.end();
  };
  config.mrus.front().rule.required = required("mru1");
  config.mrus.back().rule.required = required("mru2");
  config.qualisys.rule.required = required("qualisys");
  config.comau.rule.required = required("arm");
  config.winch.rule.required = required("winch");
  constexpr std::array platform_limits{"plc", "mechanical"};
  config.platform_limits = platform_limits[root.table("limits").choice("platform", {"plc", "mechanical"})];
  const TomlTable comau = root.table("comau");
  const bool watched = comau.choice("watchdog", {"none", "relay", "patched"}) != 0;
  const double watchdog_s = comau.number("watchdog_s", {0.005, 1.0});
  if (watched) {
    config.comau.watchdog_s = watchdog_s;
  } else {
    for (auto* const limit : {&config.limits.qd_max_radps, &config.comau.driver.qd_max_radps}) {
      for (auto& fastest : *limit) fastest = std::min(fastest, kSpeedWithoutWatchdog);
    }
    config.notes.push_back(
        "the robot computer has no watchdog: joints are limited to 0.1 rad/s; declare [comau] watchdog when "
        "it has one");
  }
  if (config.winch.driver.legacy() && config.winch.driver.legacy_commands) {
    config.notes.push_back(
        "winch.legacy_commands lets a PLC project without a watchdog move the winch: should the gateway die, "
        "it goes on with the last velocity");
  }

  const TomlTable arm = root.table("arm");
  const math::CraneArmGeometry geometry = arm_geometry(arm);
  config.belief = belief(root, geometry);
  config.keeper.arm = geometry;
  config.limits.fences = fence_limits(root, geometry, config.belief.calibration.second.X_WN.p);
  config.keeper.X_BR = config.belief.calibration.X_BR;
  config.keeper.X_WN_second = config.belief.calibration.second.X_WN;
  config.keeper.servo = {arm.number("servo_omega_radps", {1.0, 200.0}), arm.number("servo_zeta", {0.1, 2.0}),
                         arm.number("servo_delay_s", {0.0, 0.1})};
  config.keeper.identifier.memory_s = arm.number("servo_memory_s", {0.0, 3600.0});
  config.keeper.command_period_s = config.comau.driver.command_period_s;
  config.record = record_rule(root);
  config.p_world_load_reference_m = root.table("reference").numbers<3>("p_world_load_m", {-20.0, 20.0});

  config.set_platform_tracked(tracked);
  document.refuse_unknown_keys();
  return config;
}

}  // namespace

GatewayConfig load_gateway_config(const std::filesystem::path& file,
                                  const std::vector<std::filesystem::path>& overlays,
                                  const std::vector<TomlText>& texts) {
  return read(TomlDocument::load(file, overlays, texts));
}

GatewayConfig parse_gateway_config(const TomlText& text) {
  return read(TomlDocument::parse(text));
}

void GatewayConfig::set_platform_tracked(bool tracked) {
  belief.use_platform_body = tracked;
  qualisys.driver.bodies = {qualisys.load_body};
  if (tracked) qualisys.driver.bodies.push_back(qualisys.platform_body);
}

}  // namespace motionlab::service
