#include "simulators/lab/study/lab_plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "simulators/lab/thesis/table_text.hpp"

namespace motionlab::study {
namespace {

constexpr double kDegree = std::numbers::pi / 180, kMillimetre = 1e-3;
constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};

template <class Value>
Curve curve(const LabRecording& recording, std::string legend, Pen pen, const Value& value) {
  Curve curve{std::move(legend), pen, {}};
  curve.y.reserve(recording.moments.size());
  for (const LabMoment& moment : recording.moments) curve.y.push_back(value(moment));
  return curve;
}

double norm(double a, double b, double c = 0) {
  return std::sqrt(a * a + b * b + c * c);
}

double distance(const std::array<double, 3>& p, const std::array<double, 3>& q) {
  return norm(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

Plot plot_of(const LabRecordings& lab, const LabRecording& recording) {
  Plot plot;
  plot.t_s = recording.t_s;
  if (lab.base().engage_at_s < recording.t_s.back())
    plot.events.push_back({lab.base().engage_at_s, "engaged"});
  return plot;
}

/// @param rms  not a number when the run was too short to be scored
std::string with_rms(std::string_view who, double rms, int decimals) {
  return std::string(who) + (std::isfinite(rms) ? ", rms " + thesis::fixed(rms, decimals) : "");
}

/// Swing [deg] and distance [mm] of a load.
struct Rms {
  double swing_deg = kGap, load_mm = kGap;

  explicit Rms(const std::optional<monitor::MotionScore>& score) {
    if (!score) return;
    swing_deg = score->swing_rms_deg;
    load_mm = score->load_error_rms_norm_m / kMillimetre;
  }
};

}  // namespace

const LabRecording& LabRecordings::of(std::string_view scenario, std::string_view platform,
                                      std::string_view controller) {
  const auto [place, is_new] =
      made_.try_emplace(std::string(scenario) + ' ' + std::string(platform) + ' ' + std::string(controller));
  LabRecording& recording = place->second;
  if (!is_new) return recording;
  LabRun run = base_;
  run.scenario = scenario;
  run.platform = platform;
  run.controller = controller;
  const auto every = std::max<std::int64_t>(1, std::llround(run.seconds * 1e3) / kPlotPoints);
  std::int64_t seen = 0;
  recording.p_world_load_set_m = configure(run).gateway.p_world_load_reference_m;
  recording.outcome = run_lab(run, [&](const topic::TruthWorld& truth, const topic::Estimate* estimate) {
    if (seen++ % every != 0) return;
    recording.t_s.push_back(1e-9 * static_cast<double>(truth.t_ns));
    recording.moments.push_back({truth, estimate ? *estimate : topic::Estimate{}});
  });
  return recording;
}

Plot lab_load(LabRecordings& lab, std::string_view scenario) {
  const LabRecording& recording = lab.of(scenario, "tracked");
  const auto& set = recording.p_world_load_set_m;
  Plot plot = plot_of(lab, recording);
  for (std::size_t i = 0; i < 2; ++i) {
    plot.panels.push_back({i == 0 ? "α [deg]" : "β [deg]",
                           {curve(recording, "without control", Pen::uncontrolled,
                                  [i](const LabMoment& m) { return m.truth.twin_swing_rad[i] / kDegree; }),
                            curve(recording, "ours", Pen::first,
                                  [i](const LabMoment& m) { return m.truth.swing_rad[i] / kDegree; })},
                           Scale::linear,
                           4});
  }
  for (std::size_t i = 0; i < 3; ++i) {
    plot.panels.push_back(
        {"load " + std::string(kAxes[i]) + " [m]",
         {curve(recording, "without control", Pen::uncontrolled,
                [&, i](const LabMoment& m) { return m.truth.p_world_twin_load_m[i] - set[i]; }),
          curve(recording, "ours", Pen::first,
                [&, i](const LabMoment& m) { return m.truth.p_world_load_m[i] - set[i]; })},
         Scale::linear,
         0.2});
  }
  return plot;
}

Plot lab_rest(LabRecordings& lab, std::string_view scenario) {
  const LabRecording& tracked = lab.of(scenario, "tracked");
  const LabRecording& untracked = lab.of(scenario, "untracked");
  const auto& set = tracked.p_world_load_set_m;
  const Rms twin(tracked.outcome.report.baseline);
  Plot plot = plot_of(lab, tracked);
  Panel swing{"swing [deg]", {}, Scale::logarithmic, 0.01}, load{"load [mm]", {}, Scale::logarithmic, 1};
  swing.curves.push_back(curve(tracked, with_rms("without control", twin.swing_deg, 2), Pen::uncontrolled,
                               [](const LabMoment& m) {
                                 return norm(m.truth.twin_swing_rad[0], m.truth.twin_swing_rad[1]) / kDegree;
                               }));
  load.curves.push_back(
      curve(tracked, with_rms("without control", twin.load_mm, 0), Pen::uncontrolled,
            [&](const LabMoment& m) { return distance(m.truth.p_world_twin_load_m, set) / kMillimetre; }));
  const auto add = [&](const LabRecording& recording, std::string_view who, Pen pen) {
    const Rms score(recording.outcome.report.motion);
    swing.curves.push_back(curve(recording, with_rms(who, score.swing_deg, 3), pen, [](const LabMoment& m) {
      return norm(m.truth.swing_rad[0], m.truth.swing_rad[1]) / kDegree;
    }));
    load.curves.push_back(curve(recording, with_rms(who, score.load_mm, 1), pen, [&](const LabMoment& m) {
      return distance(m.truth.p_world_load_m, set) / kMillimetre;
    }));
  };
  add(lab.of(scenario, "tracked", "integral"), "thesis IC", Pen::second);
  add(untracked, "untracked", Pen::third);
  add(tracked, "tracked", Pen::first);
  plot.panels = {std::move(swing), std::move(load)};
  return plot;
}

Plot lab_estimate(LabRecordings& lab, std::string_view scenario) {
  const LabRecording& recording = lab.of(scenario, "tracked");
  Plot plot = plot_of(lab, recording);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto sd = [i](double times) {
      return [i, times](const LabMoment& m) {
        return m.estimate.valid ? times * m.estimate.p_world_load_sd_m[i] / kMillimetre : kGap;
      };
    };
    plot.panels.push_back({"load " + std::string(kAxes[i]) + " [mm]",
                           {curve(recording, "estimate minus truth", Pen::first,
                                  [i](const LabMoment& m) {
                                    return m.estimate.valid
                                               ? (m.estimate.p_world_load_m[i] - m.truth.p_world_load_m[i]) /
                                                     kMillimetre
                                               : kGap;
                                  }),
                            curve(recording, "two standard deviations", Pen::set_point, sd(2)),
                            curve(recording, "", Pen::set_point, sd(-2))},
                           Scale::linear,
                           2});
  }
  return plot;
}

Plot lab_effort(LabRecordings& lab, std::string_view scenario) {
  constexpr std::array kPens{Pen::first, Pen::second, Pen::third};
  const LabRecording& recording = lab.of(scenario, "tracked");
  const topic::TruthWorld& home = recording.moments.front().truth;
  Plot plot = plot_of(lab, recording);
  Panel joints{"joint [deg]", {}, Scale::linear, 4};
  for (std::size_t j = 0; j < 3; ++j) {
    joints.curves.push_back(
        curve(recording, "joint " + std::to_string(j + 1) + " from home", kPens[j],
              [&, j](const LabMoment& m) { return (m.truth.q_rad[j] - home.q_rad[j]) / kDegree; }));
  }
  plot.panels.push_back(std::move(joints));
  plot.panels.push_back(
      {"wire [m]",
       {curve(recording, "length", Pen::truth, [](const LabMoment& m) { return m.truth.wire_length_m; })},
       Scale::linear,
       0.2});
  return plot;
}

}  // namespace motionlab::study
