#include "gateway/console/program/lab_json.hpp"

#include <nlohmann/json.hpp>

#include <Eigen/Geometry>

namespace motionlab::console {
namespace {

using nlohmann::ordered_json;

ordered_json pose_json(const math::RigidTransform& X) {
  const Eigen::Quaterniond q{Eigen::Matrix3d{X.R}};
  return {{"q", {q.w(), q.x(), q.y(), q.z()}}, {"p_m", {X.p.x(), X.p.y(), X.p.z()}}};
}

}  // namespace

std::string lab_json(const service::GatewayConfig& config, bool control) {
  const auto& calibration = config.belief.calibration;
  ordered_json json;
  json["control"] = control;
  json["arm"] = {{"a1_m", calibration.arm.a1_m},
                 {"a2_m", calibration.arm.a2_m},
                 {"a3_m", calibration.arm.a3_m},
                 {"d1_m", calibration.arm.d1_m},
                 {"reach_m", calibration.arm.reach_m}};
  json["poses"] = {{"world_to_em8000", pose_json(calibration.X_WN)},
                   {"em8000_to_comau", pose_json(calibration.X_BR)},
                   {"em8000_to_mru1", pose_json(calibration.X_BM)},
                   {"world_to_qtm", pose_json(calibration.X_WQ)},
                   {"world_to_em1500", pose_json(calibration.second.X_WN)}};
  json["reference"] = {{"p_world_load_m", config.p_world_load_reference_m}};
  json["limits"] = {{"q_min_rad", config.limits.q_min_rad},
                    {"q_max_rad", config.limits.q_max_rad},
                    {"qd_max_radps", config.limits.qd_max_radps},
                    {"wire_min_m", config.limits.wire_min_m},
                    {"wire_max_m", config.limits.wire_max_m}};
  ordered_json stale = ordered_json::object();
  for (const auto& mru : config.mrus) stale[mru.driver.device] = mru.rule.stale_after_s;
  stale[config.qualisys.driver.device] = config.qualisys.rule.stale_after_s;
  stale[config.comau.driver.device] = config.comau.rule.stale_after_s;
  stale[config.winch.driver.device] = config.winch.rule.stale_after_s;
  if (config.plc_reply) stale[config.plc_reply->driver.device] = config.plc_reply->rule.stale_after_s;
  json["stale_after_s"] = stale;
  return json.dump(1) + "\n";
}

}  // namespace motionlab::console
