#include "simulators/lab/study/thesis_plots.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "gateway/estimator/thesis_filter4.hpp"
#include "simulators/lab/thesis/pushed_pendulum.hpp"
#include "simulators/lab/thesis/scenario.hpp"
#include "simulators/lab/thesis/simulation.hpp"

namespace motionlab::study {
namespace {

using thesis::Run;
using thesis::Sample;
using thesis::Scenario;

constexpr double kDegree = std::numbers::pi / 180;

// What the figures ask for and no table of the thesis has.
constexpr Scenario kSinusFromOffset{.name = "",
                                    .system = thesis::System::load,
                                    .about = "",
                                    .reference = thesis::ReferenceKind::sinus,
                                    .offset = true};
constexpr Scenario kStepsOnResting{
    .name = "", .system = thesis::System::motion, .about = "", .reference = thesis::ReferenceKind::steps};
/// Until each axis has made its step up.
constexpr double kStepsUp_s = 35;

/// One run, thinned.
struct Recording {
  std::vector<double> t_s;
  std::vector<Sample> samples;

  template <class Value>
  [[nodiscard]] Curve curve(std::string legend, Pen pen, const Value& value) const {
    Curve curve{std::move(legend), pen, {}};
    curve.y.reserve(samples.size());
    for (const Sample& s : samples) curve.y.push_back(value(s));
    return curve;
  }
};

Recording record(const Run& run) {
  const auto every_ms = std::max<std::int64_t>(1, std::llround(run.duration_s * 1e3) / kPlotPoints);
  Recording recording;
  thesis::simulate(run, [&](const Sample& s) {
    if (s.t_ms % every_ms != 0) return;
    recording.t_s.push_back(1e-3 * static_cast<double>(s.t_ms));
    recording.samples.push_back(s);
  });
  return recording;
}

Run run_of(std::string_view scenario, std::string_view controller = "") {
  thesis::Request request;
  request.scenario = scenario;
  request.controller = controller;
  return thesis::choose(request);
}

/// A controller as the figures call it.
struct Variant {
  std::string_view controller, legend;
  Pen pen;
};
constexpr std::array<Variant, 3> kVariants{
    {{"prefilter", "FPF", Pen::first}, {"integral", "IC", Pen::second}, {"damper", "NL", Pen::third}}};
const Variant& variant_of(std::string_view controller) {
  return *std::find_if(kVariants.begin(), kVariants.end(),
                       [&](const Variant& v) { return v.controller == controller; });
}

/// Recordings of one scenario, and how they are drawn.
struct Drawn {
  Recording recording;
  std::string_view legend;
  Pen pen;
  bool height = true;  ///< whether the height is controlled at all
};

constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};

void add_tool(const std::vector<Drawn>& all, Plot& plot) {
  for (int i = 0; i < 3; ++i) {
    const std::string axis(kAxes[static_cast<std::size_t>(i)]);
    Panel panel{"tool " + axis + " [m]", {}, Scale::linear, 0.2};
    panel.curves.push_back(all.front().recording.curve("reference", Pen::set_point,
                                                       [i](const Sample& s) { return s.p_RT_reference[i]; }));
    for (const Drawn& drawn : all) {
      if (i == 2 && !drawn.height) continue;
      panel.curves.push_back(drawn.recording.curve(std::string(drawn.legend), drawn.pen,
                                                   [i](const Sample& s) { return s.state[i]; }));
    }
    plot.panels.push_back(std::move(panel));
  }
}

void add_swing(const std::vector<Drawn>& all, Plot& plot) {
  for (int i = 0; i < 2; ++i) {
    Panel panel{i == 0 ? "α [deg]" : "β [deg]", {}, Scale::linear, 4};
    for (const Drawn& drawn : all) {
      panel.curves.push_back(drawn.recording.curve(
          std::string(drawn.legend), drawn.pen, [i](const Sample& s) { return s.state[6 + i] / kDegree; }));
    }
    plot.panels.push_back(std::move(panel));
  }
}

/// Where the load is in world, from where it hangs with the tool at home and the ship at neutral.
void add_load(const Recording& recording, Plot& plot) {
  constexpr std::array kPens{Pen::first, Pen::second, Pen::third};
  const Eigen::Vector3d home = recording.samples.front().p_WL_set;
  Panel panel{"load [m]", {}, Scale::linear, 0.2};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    panel.curves.push_back(recording.curve("world " + std::string(kAxes[i]), kPens[i],
                                           [&, axis](const Sample& s) { return s.p_WL[axis] - home[axis]; }));
  }
  plot.panels.push_back(std::move(panel));
}

void add_wire(const Recording& recording, Plot& plot) {
  plot.panels.push_back({"wire [m]",
                         {recording.curve("length", Pen::truth, [](const Sample& s) { return s.wire_m; })},
                         Scale::linear,
                         0.2});
}

Plot plot_of(const std::vector<Drawn>& all) {
  Plot plot;
  plot.t_s = all.front().recording.t_s;
  return plot;
}

/// True and estimated swing, and the error.
Plot swing_estimate(const Recording& recording, bool with_measured, std::string_view filter) {
  Plot plot;
  plot.t_s = recording.t_s;
  for (int i = 0; i < 2; ++i) {
    Panel panel{i == 0 ? "α [deg]" : "β [deg]", {}, Scale::linear, 4};
    if (with_measured) {
      panel.curves.push_back(recording.curve("measured", Pen::measured, [i](const Sample& s) {
        return s.sight.swing_measured_rad[i] / kDegree;
      }));
    }
    panel.curves.push_back(
        recording.curve("true", Pen::truth, [i](const Sample& s) { return s.state[6 + i] / kDegree; }));
    panel.curves.push_back(recording.curve(std::string(filter), Pen::second, [i](const Sample& s) {
      return s.sight.estimate[6 + i] / kDegree;
    }));
    plot.panels.push_back(std::move(panel));
  }
  Panel error{"error [deg]", {}, Scale::linear, 0.1};
  for (int i = 0; i < 2; ++i) {
    error.curves.push_back(recording.curve(
        i == 0 ? "of α" : "of β", i == 0 ? Pen::first : Pen::third,
        [i](const Sample& s) { return (s.sight.estimate[6 + i] - s.state[6 + i]) / kDegree; }));
  }
  plot.panels.push_back(std::move(error));
  return plot;
}

Plot reference(std::string_view scenario) {
  Run run = run_of(scenario);
  run.estimator = thesis::Estimator::ideal;
  const Recording recording = record(run);
  Plot plot;
  plot.t_s = recording.t_s;
  for (int i = 0; i < 3; ++i) {
    plot.panels.push_back(
        {"tool " + std::string(kAxes[static_cast<std::size_t>(i)]) + " [m]",
         {recording.curve("reference", Pen::truth, [i](const Sample& s) { return s.p_RT_reference[i]; })},
         Scale::linear,
         0.2});
  }
  return plot;
}

/// The 35-state filter in the wave, told of everything with the noise that it believes in; nothing is
/// controlled.
Recording noisy_wave() {
  Run run = run_of("thesis-motion-4");
  run.noise = true;
  run.duration_s = 30;
  return record(run);
}

double swing_deg(const Sample& s) {
  return s.state.segment<2>(6).norm() / kDegree;
}

}  // namespace

Plot pushed_pendulum(double wire_m) {
  using estimator::ThesisEkf4, estimator::ThesisKf4, estimator::ThesisKf4Form;
  constexpr int kEvery = 25;
  constexpr double kPush_radps = 1.0;
  Plot plot;
  const auto watched = [&](auto filter, Curve angle, Curve error) {
    plot.t_s.clear();
    Curve truth{"true", Pen::truth, {}};
    thesis::push_pendulum(std::move(filter), wire_m, kPush_radps,
                          [&](int k, const Eigen::Vector4d& x, const Eigen::Vector4d& predicted) {
                            if (k % kEvery != 0) return;
                            plot.t_s.push_back(1e-3 * k);
                            truth.y.push_back(x[2] / kDegree);
                            angle.y.push_back(predicted[2] / kDegree);
                            error.y.push_back((predicted[2] - x[2]) / kDegree);
                          });
    if (plot.panels.empty()) {
      plot.panels.push_back({"θ [deg]", {std::move(truth)}, Scale::linear, 4});
      plot.panels.push_back({"error of θ [deg]", {}, Scale::linear, 1});
    }
    plot.panels[0].curves.push_back(std::move(angle));
    plot.panels[1].curves.push_back(std::move(error));
  };
  const auto kf = [&](ThesisKf4Form form, const char* legend, Pen pen) {
    watched(ThesisKf4({}, Eigen::Vector4d::Zero(), form), {legend, pen, {}}, {legend, pen, {}});
  };
  kf(ThesisKf4Form::continuous, "KF, Q and R as densities", Pen::first);
  kf(ThesisKf4Form::discrete, "KF, Q and R per step", Pen::third);
  watched(ThesisEkf4(), {"EKF", Pen::second, {}}, {"EKF", Pen::second, {}});
  return plot;
}

Plot pendulum_step(std::string_view controller) {
  const Variant& variant = variant_of(controller);
  const Recording recording = record(run_of("thesis-pendulum", controller));
  const std::string legend(variant.legend);
  Plot plot;
  plot.t_s = recording.t_s;
  plot.panels.push_back(
      {"cart x [m]",
       {recording.curve("reference", Pen::set_point, [](const Sample& s) { return s.p_RT_reference[0]; }),
        recording.curve(legend, variant.pen, [](const Sample& s) { return s.state[0]; })},
       Scale::linear,
       0.2});
  plot.panels.push_back(
      {"θ [deg]",
       {recording.curve(legend, variant.pen, [](const Sample& s) { return s.state[6] / kDegree; })},
       Scale::linear,
       4});
  return plot;
}

Plot load_filter(bool offset_start) {
  Run run = run_of("thesis-load-3", "integral");
  if (offset_start) run.scenario = &kSinusFromOffset;
  run.duration_s = offset_start ? 2 : 30;
  return swing_estimate(record(run), false, "EKF, 10 states");
}

Plot load_steps(std::string_view controller) {
  Run run = run_of("thesis-load-2", controller);
  run.duration_s = kStepsUp_s;
  const Variant& variant = variant_of(controller);
  const std::vector<Drawn> drawn{{record(run), variant.legend, variant.pen, controller != "damper"}};
  Plot plot = plot_of(drawn);
  add_tool(drawn, plot);
  if (controller == "damper") plot.panels.pop_back();
  add_swing(drawn, plot);
  return plot;
}

Plot load_scenario(std::string_view scenario) {
  std::vector<Drawn> drawn;
  for (const Variant& v : kVariants) {
    drawn.push_back({record(run_of(scenario, v.controller)), v.legend, v.pen, v.controller != "damper"});
  }
  Plot plot = plot_of(drawn);
  add_tool(drawn, plot);
  add_swing(drawn, plot);
  return plot;
}

Plot ship_filter() {
  constexpr std::array<std::string_view, 3> kNames{"roll [deg]", "pitch [deg]", "yaw [deg]"};
  const Recording recording = noisy_wave();
  Plot plot;
  plot.t_s = recording.t_s;
  for (int i = 0; i < 3; ++i) {
    const auto angle = [i](const Eigen::Matrix<double, 6, 1>& eta) { return eta[3 + i] / kDegree; };
    plot.panels.push_back(
        {std::string(kNames[static_cast<std::size_t>(i)]),
         {recording.curve("measured", Pen::measured,
                          [&](const Sample& s) { return angle(s.sight.eta_measured); }),
          recording.curve("true", Pen::truth, [&](const Sample& s) { return angle(s.eta); }),
          recording.curve("EKF, 35 states", Pen::second,
                          [&](const Sample& s) { return angle(s.sight.eta_estimate); })},
         Scale::linear,
         4});
  }
  return plot;
}

Plot swing_filter() {
  return swing_estimate(noisy_wave(), true, "EKF, 35 states");
}

Plot motion_steps() {
  Run run = run_of("thesis-motion-2");
  run.scenario = &kStepsOnResting;
  run.duration_s = kStepsUp_s;
  const std::vector<Drawn> drawn{{record(run), "IC", Pen::second}};
  Plot plot = plot_of(drawn);
  add_tool(drawn, plot);
  add_swing(drawn, plot);
  add_load(drawn.front().recording, plot);
  return plot;
}

Plot motion_scenario(std::string_view scenario, const MotionShow& show) {
  const std::vector<Drawn> drawn{{record(run_of(scenario)), "IC", Pen::second}};
  Plot plot = plot_of(drawn);
  if (show.tool) add_tool(drawn, plot);
  add_swing(drawn, plot);
  if (show.load) add_load(drawn.front().recording, plot);
  if (show.wire) add_wire(drawn.front().recording, plot);
  return plot;
}

Plot uncontrolled_wave() {
  Run run = run_of("thesis-motion-4");
  run.estimator = thesis::Estimator::ideal;
  Run mistaken = run;
  mistaken.frame = thesis::Frame::thesis;
  const std::vector<Drawn> drawn{{record(run), "no control", Pen::uncontrolled}};
  Plot plot = plot_of(drawn);
  add_swing(drawn, plot);
  add_load(drawn.front().recording, plot);
  plot.panels.push_back({"swing [deg]",
                         {drawn.front().recording.curve("no control", Pen::uncontrolled, swing_deg),
                          record(mistaken).curve("heave upside down", Pen::second, swing_deg)},
                         Scale::linear,
                         4});
  return plot;
}

Plot step_reference() {
  return reference("thesis-load-2");
}

Plot sinus_reference() {
  return reference("thesis-load-3");
}

Plot ship_wave() {
  Run run = run_of("thesis-motion-4");
  run.estimator = thesis::Estimator::ideal;
  run.duration_s = 30;
  const Recording recording = record(run);
  const auto coordinate = [&](const char* legend, Pen pen, Eigen::Index i, double unit) {
    return recording.curve(legend, pen, [=](const Sample& s) { return s.eta[i] / unit; });
  };
  Plot plot;
  plot.t_s = recording.t_s;
  plot.panels.push_back({"position [m]",
                         {coordinate("x", Pen::first, 0, 1), coordinate("y", Pen::second, 1, 1),
                          coordinate("z (down)", Pen::third, 2, 1)},
                         Scale::linear,
                         0.2});
  plot.panels.push_back(
      {"angle [deg]",
       {coordinate("roll", Pen::first, 3, kDegree), coordinate("pitch", Pen::second, 4, kDegree),
        coordinate("yaw", Pen::third, 5, kDegree)},
       Scale::linear,
       4});
  return plot;
}

}  // namespace motionlab::study
