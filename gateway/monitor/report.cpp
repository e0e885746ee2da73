#include "gateway/monitor/report.hpp"

#include <nlohmann/json.hpp>

namespace motionlab::monitor {
namespace {

using Json = nlohmann::ordered_json;

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json or_null(const std::string& text) {
  return text.empty() ? Json(nullptr) : Json(text);
}

Json spread(const std::optional<Spread>& of) {
  if (!of) return nullptr;
  return {{"p50", of->p50}, {"p99", of->p99}, {"max", of->max}};
}

/// The keys that a load and its uncontrolled twin have in common.
template <class Add>
void add_motion(const std::optional<MotionScore>& motion, Add&& add) {
  const auto field = [&](const char* key, auto MotionScore::*member) {
    add(key, motion ? Json((*motion).*member) : Json(nullptr));
  };
  field("swing_rms_deg", &MotionScore::swing_rms_deg);
  field("swing_axis_rms_deg", &MotionScore::swing_axis_rms_deg);
  field("swing_max_deg", &MotionScore::swing_max_deg);
  field("swing_axis_max_deg", &MotionScore::swing_axis_max_deg);
  field("load_error_rms_m", &MotionScore::load_error_rms_m);
  field("load_error_rms_norm_m", &MotionScore::load_error_rms_norm_m);
  field("load_error_max_m", &MotionScore::load_error_max_m);
  field("tool_error_rms_m", &MotionScore::tool_error_rms_m);
  field("tool_error_rms_norm_m", &MotionScore::tool_error_rms_norm_m);
}

Json baseline(const Report& report) {
  if (!report.baseline) return nullptr;
  Json json;
  add_motion(report.baseline, [&json](const char* key, Json value) { json[key] = std::move(value); });
  json["settling_time_s"] = or_null(report.baseline_settling_time_s);
  json["joint_speed_max_degps"] = std::array<double, 6>{};  // its arm and winch stand still by definition
  json["winch_speed_max_mps"] = 0.0;
  return json;
}

Json reductions(const Report& report) {
  std::optional<double> swing, load;
  if (report.motion && report.baseline) {
    swing = reduction(report.motion->swing_rms_deg, report.baseline->swing_rms_deg);
    load = reduction(report.motion->load_error_rms_norm_m, report.baseline->load_error_rms_norm_m);
  }
  return {{"swing_rms", or_null(swing)}, {"load_error_rms", or_null(load)}};
}

Json faults(const Report& report) {
  Json list = Json::array();
  for (const FaultReport& fault : report.faults) {
    list.push_back({{"t_s", fault.t_s},
                    {"fault", fault.fault},
                    {"code", or_null(fault.code)},
                    {"detected_after_s", or_null(fault.detected_after_s)},
                    {"at_rest_after_s", or_null(fault.at_rest_after_s)}});
  }
  return list;
}

Json freshness(const Report& report) {
  Json list = Json::array();
  for (const Freshness& device : report.freshness) {
    list.push_back({{"device", device.device},
                    {"age_max_s", device.age_max_s},
                    {"stale_after_s", device.stale_after_s}});
  }
  return list;
}

}  // namespace

std::optional<double> reduction(double value, double baseline) {
  if (!(baseline > 0)) return std::nullopt;
  return 1.0 - value / baseline;
}

std::string to_json(const Report& report) {
  const RunLabels& labels = report.labels;
  Json json;
  json["scenario"] = or_null(labels.scenario);
  json["controller"] = or_null(labels.controller);
  json["estimator"] = or_null(labels.estimator);
  json["sensors"] = or_null(labels.sensors);
  json["seed"] = or_null(labels.seed);
  json["duration_s"] = report.duration_s;
  json["score_from_s"] = report.score_from_s;
  json["source"] = report.source == Source::truth ? "truth" : "estimate";
  json["world"] = or_null(labels.world);
  json["frame"] = or_null(labels.frame);
  json["gains"] = or_null(labels.gains);
  json["platform"] = or_null(labels.platform);
  json["reference_frame"] = or_null(labels.reference_frame);
  json["limits"] = or_null(labels.limits);
  json["samples"] = report.motion ? report.motion->samples : 0;
  add_motion(report.motion, [&json](const char* key, Json value) { json[key] = std::move(value); });
  json["settling_time_s"] = or_null(report.settling_time_s);
  json["joint_speed_max_degps"] = or_null(report.joint_speed_max_degps);
  json["winch_speed_max_mps"] = or_null(report.winch_speed_max_mps);
  json["limited"] = report.limited;
  json["baseline"] = baseline(report);
  json["reduction"] = reductions(report);
  json["age_at_actuation_us"] = spread(report.age_at_actuation_us);
  json["step_time_us"] = spread(report.step_time_us);
  json["faults"] = faults(report);
  json["freshness"] = freshness(report);
  // A label may hold bytes that are no UTF-8 (a command line is anything): they are replaced, never thrown
  // at.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace motionlab::monitor
