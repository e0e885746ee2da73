#include "gateway/service/readiness.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace motionlab::service {
namespace {

using controller::Obstacle;

/// The estimate must know the tool this well before the gateway may be engaged.
constexpr double kToolSdToEngage = 0.05;
/// The arm must stand this still, and an external controller ask no more, before the gateway may be engaged.
constexpr double kRestToEngage = 0.01;

constexpr double kDegreesPerRadian = 57.29577951308232;

template <class Sample>
const Sample* pointer(const std::optional<Sample>& sample) {
  return sample ? &*sample : nullptr;
}

template <class... Values>
Text<200> text(const char* format, Values... values) {
  char line[201];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

}  // namespace

Readiness::Readiness(const GatewayConfig& config) : config_(config), check_(config.belief.calibration) {}

controller::ModeFacts Readiness::judge(const Inputs& in) {
  const Snapshot& now = in.now;
  const double mru_limit_s = config_.mrus.front().rule.stale_after_s;
  if (now.load && now.load->tracked && fresh(now.load, now.t, config_.qualisys.rule.stale_after_s))
    load_seen_ = now.t;
  if (now.mru && now.mru->stable) mru_stable_ = now.t;
  check_.step({in.dt_s, fresh(now.mru, now.t, mru_limit_s) ? pointer(now.mru) : nullptr,
               pointer(now.platform), pointer(now.load), pointer(now.arm), pointer(now.winch)});

  controller::ModeFacts facts;
  facts.t = now.t;
  facts.links_up = now.mru && now.arm && now.winch;
  facts.unsafe = unsafe(in);
  facts.not_ready = facts.unsafe ? facts.unsafe : not_ready(in);
  return facts;
}

std::optional<Obstacle> Readiness::stale(const std::vector<std::string>& devices, const Snapshot& now) const {
  const auto needed = [&](const char* device) { return std::ranges::find(devices, device) != devices.end(); };
  if (needed("mru1") && !fresh(now.mru, now.t, config_.mrus.front().rule.stale_after_s)) {
    return Obstacle{"mru1_stale", "no fresh sample from mru1; check the unit and its cable, then reset"};
  }
  // What came in time and was measured too long ago is as good as silence: the driver moves nothing on it.
  const double arm_limit_s = config_.comau.rule.stale_after_s;
  if (needed("arm") && (!fresh(now.arm, now.t, arm_limit_s) || age_s(now.arm, now.t) > arm_limit_s)) {
    return Obstacle{"arm_stale",
                    "no fresh answer from the robot computer; check that its program runs, then reset"};
  }
  if (needed("winch") && !fresh(now.winch, now.t, config_.winch.rule.stale_after_s)) {
    return Obstacle{"winch_stale", "no fresh status from the winch controller; check the PLC, then reset"};
  }
  if (needed("mru2") && !fresh(now.second_mru, now.t, config_.mrus.back().rule.stale_after_s)) {
    return Obstacle{"mru2_stale", "no fresh sample from mru2; check the unit and its cable, then reset"};
  }
  if (needed("qualisys") && !fresh(now.load, now.t, config_.qualisys.rule.stale_after_s)) {
    return Obstacle{"qualisys_stale",
                    "no fresh frame from the cameras; check QTM and the network, then reset"};
  }
  return std::nullopt;
}

std::optional<Obstacle> Readiness::unsafe(const Inputs& in) const {
  const Snapshot& now = in.now;
  if (now.deadman_lost) {
    return Obstacle{"deadman_lost",
                    "the deadman process is gone, nobody would stop the arm if the gateway died; restart the "
                    "gateway"};
  }
  // The driver has let go of the arm by itself; going on would be resuming by itself.
  if (in.dt_s > config_.comau.driver.command_stale_after_s) {
    return Obstacle{"control_late",
                    "control stood still for longer than the arm may wait; see what else this machine does, "
                    "then reset"};
  }
  if (auto silent = stale(config_.modes.engaged, now)) return silent;
  if (now.winch->error)
    return Obstacle{"winch_fault", "the winch drive reports a fault; clear it at the drive, then reset"};
  // For as long as it may be silent: one datagram whose header was damaged says little.
  if (!mru_stable_ || seconds(now.t - *mru_stable_) > config_.mrus.front().rule.stale_after_s)
    return Obstacle{"mru1_unstable", "mru1 says that it is settling; wait until it is stable, then reset"};
  if (!in.estimate.valid)
    return Obstacle{"no_estimate", "there is no estimate; wait until the load is seen, then reset"};
  if (!load_seen_ || seconds(now.t - *load_seen_) > config_.qualisys.rest_by_s) {
    return Obstacle{"load_lost",
                    "the cameras have not seen the load for too long; free the view, then reset"};
  }
  if (in.on_second_ship &&
      !(in.estimate.second_valid && fresh(now.second_mru, now.t, config_.mrus.back().rule.stale_after_s))) {
    return Obstacle{"mru2_stale",
                    "the reference is on the second ship, whose unit is not heard or still settles; check "
                    "mru2 or give a reference in world, then reset"};
  }
  if (now.arm->ignoring) {
    return Obstacle{"arm_ignores",
                    "the arm was told to move and did not: remote mode, drives on, program started, joints "
                    "inside their box? Then reset"};
  }
  if (in.wish_missing)
    return Obstacle{"out_of_reach",
                    "the tool point is out of the arm's reach; move the reference, then reset"};
  return std::nullopt;
}

std::optional<Obstacle> Readiness::not_ready(const Inputs& in) const {
  const Snapshot& now = in.now;
  const topic::Estimate& estimate = in.estimate;
  if (auto silent = stale(config_.modes.to_engage, now)) return silent;
  const auto& sd = estimate.p_world_tool_sd_m;
  const auto& qd = now.arm->qd_radps;
  if (!estimate.load_tracked) return Obstacle{"load_lost", "the cameras do not see the load; free the view"};
  if (config_.belief.use_platform_body && !estimate.platform_tracked) {
    return Obstacle{"platform_lost",
                    "the cameras do not see the body on the platform; free the view or set "
                    "[control] platform = \"untracked\""};
  }
  if (std::any_of(sd.begin(), sd.end(), [](double s) { return s > kToolSdToEngage; }))
    return Obstacle{"estimate_settling", "the estimate is still settling; wait a few seconds"};
  if (auto differ = disagreement()) return differ;
  if (std::any_of(qd.begin(), qd.end(), [](double v) { return std::abs(v) > kRestToEngage; }))
    return Obstacle{"arm_moving", "the arm moves; wait until it rests"};
  if (!now.winch->ready) {
    return Obstacle{"winch_not_ready",
                    "the winch drive is not ready; switch on its power and clear its faults"};
  }
  return in.external_applicant ? applicant(now) : std::nullopt;
}

std::optional<Obstacle> Readiness::disagreement() const {
  const auto tilt = check_.tilt_difference_rad();
  const double most_deg = config_.modes.cross_check_tilt_deg;
  if (tilt && tilt->cwiseAbs().maxCoeff() * kDegreesPerRadian > most_deg) {
    return Obstacle{
        "tilt_disagrees",
        text("mru1 and the cameras differ by %.2f deg in roll and %.2f deg in pitch (at most %.2f): "
             "check mounting, Euler order and the body's pose",
             tilt->x() * kDegreesPerRadian, tilt->y() * kDegreesPerRadian, most_deg)};
  }
  const auto load = check_.load_difference_m();
  if (!load) return Obstacle{"estimate_settling", "the sensors are still compared; wait a few seconds"};
  const double most_m = config_.modes.cross_check_load_m;
  if (load->cwiseAbs().maxCoeff() > most_m) {
    return Obstacle{
        "load_disagrees",
        text("the load is seen %.2f %.2f %.2f m from the plumb line of the tool (at most %.2f): check "
             "world_to_qtm, the joints and the wire's zero",
             load->x(), load->y(), load->z(), most_m)};
  }
  return std::nullopt;
}

std::optional<Obstacle> Readiness::applicant(const Snapshot& now) const {
  const auto& arm = now.external_arm;
  if (!arm || now.t - from_ns(arm->t_created_ns) > controller::kLeaseDuration) {
    return Obstacle{"controller_silent",
                    "there are no fresh commands of the controller that asks; let it publish arm_command at "
                    "rest first"};
  }
  const double wire = now.external_winch ? now.external_winch->wire_speed_wanted_mps : 0.0;
  const auto& qd = arm->qd_wanted_radps;
  if (std::abs(wire) > kRestToEngage ||
      std::any_of(qd.begin(), qd.end(), [](double v) { return std::abs(v) > kRestToEngage; })) {
    return Obstacle{"controller_moving",
                    "the controller that asks wants motion already; let it begin at rest"};
  }
  return std::nullopt;
}

}  // namespace motionlab::service
