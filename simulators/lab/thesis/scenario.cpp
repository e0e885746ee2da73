#include "simulators/lab/thesis/scenario.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drivers/core/error.hpp"

namespace motionlab::thesis {
namespace {

using controller::ThesisWeights;

constexpr std::array kScenarios{
    Scenario{"thesis-pendulum", System::pendulum,
             "cart and pendulum in a plane: a step of 1 m; without control, Fig 4.20's sinusoidal push from "
             "20 deg",
             ReferenceKind::unit_step, false, false, 2.0, false, 20},
    Scenario{"thesis-load-1", System::load, "Tab 5.5: at home, load let go at 15/20 deg", ReferenceKind::home,
             false, true, 2.0, false, 30},
    Scenario{"thesis-load-2", System::load, "Tab 5.5: steps, load plumb", ReferenceKind::steps, false, false,
             2.0, false, 70},
    Scenario{"thesis-load-2b", System::load, "the same with the published steps",
             ReferenceKind::published_steps, false, false, 2.0, false, 30},
    Scenario{"thesis-load-3", System::load, "Tab 5.5: sinus, load plumb", ReferenceKind::sinus, false, false,
             2.0, false, 60},
    Scenario{"thesis-load-4", System::load, "Tab 5.5: steps, load let go at 15/20 deg on 6 m of wire",
             ReferenceKind::steps, false, true, 6.0, false, 70},
    Scenario{"thesis-load-4b", System::load, "the same with the published steps",
             ReferenceKind::published_steps, false, true, 6.0, false, 30},
    Scenario{"thesis-motion-1", System::motion, "Tab 5.7: ship still, at home, load let go at 15/20 deg",
             ReferenceKind::home, false, true, 2.0, false, 30},
    Scenario{"thesis-motion-2", System::motion, "Tab 5.7: ship still, steps, load let go at 15/20 deg",
             ReferenceKind::steps, false, true, 2.0, false, 70},
    Scenario{"thesis-motion-2b", System::motion, "the same with the published steps",
             ReferenceKind::published_steps, false, true, 2.0, false, 30},
    Scenario{"thesis-motion-3", System::motion, "Tab 5.7: ship still, sinus, load plumb",
             ReferenceKind::sinus, false, false, 2.0, false, 60},
    Scenario{"thesis-motion-4", System::motion, "Tab 5.7: wave, no control", ReferenceKind::home, true, false,
             2.0, false, 60, Controller::none},
    Scenario{"thesis-motion-5", System::motion, "Tab 5.7: wave, at home", ReferenceKind::home, true, false,
             2.0, false, 60},
    Scenario{"thesis-motion-6", System::motion,
             "Tab 5.7: wave, steps, load let go at 15/20 deg, wire of 2 + 0.75 sin(2 pi 0.05 t) m",
             ReferenceKind::steps, true, true, 2.0, true, 70},
    Scenario{"thesis-motion-6b", System::motion, "the same with the published steps",
             ReferenceKind::published_steps, true, true, 2.0, true, 40},
};

template <class Word>
struct Named {
  std::string_view name;
  Word value;
};

constexpr std::array kControllers{Named{"none", Controller::none}, Named{"prefilter", Controller::prefilter},
                                  Named{"integral", Controller::integral},
                                  Named{"damper", Controller::damper}, Named{"ours", Controller::ours}};
constexpr std::array kEstimators{Named{"ideal", Estimator::ideal}, Named{"kf4", Estimator::kf4},
                                 Named{"ekf4", Estimator::ekf4}, Named{"ekf10", Estimator::ekf10},
                                 Named{"ekf35", Estimator::ekf35}};
constexpr std::array kFrames{Named{"world", Frame::world}, Named{"thesis", Frame::thesis}};
constexpr std::array kWeights{Named{"text", ThesisWeights::text}, Named{"printed", ThesisWeights::printed},
                              Named{"code", ThesisWeights::code}};
constexpr std::array kSensors{Named{"ideal", false}, Named{"real", true}};

template <class Table, class Word>
std::string_view name_of(const Table& table, Word value) {
  return std::find_if(table.begin(), table.end(), [&](const auto& n) { return n.value == value; })->name;
}

bool goes(System system, Controller controller) {
  if (controller == Controller::ours) return system != System::pendulum;
  return system != System::motion || controller == Controller::none || controller == Controller::integral;
}

bool goes(System system, Estimator estimator) {
  switch (estimator) {
    case Estimator::ideal:
      return true;
    case Estimator::kf4:
    case Estimator::ekf4:
      return system == System::pendulum;
    case Estimator::ekf10:
      return system == System::load;
    case Estimator::ekf35:
      return system == System::motion;
  }
  return false;
}

/// The words of a table that go with a scenario, as a list for people.
template <class Table, class Goes>
std::string list_of(const Table& table, Goes&& goes_here) {
  std::string text;
  for (const auto& named : table) {
    if (goes_here(named.value)) text += (text.empty() ? "" : ", ") + std::string(named.name);
  }
  return text;
}

/// The word's meaning; @throws StartupError naming the words that go.
template <class Table, class Goes>
auto meaning(const std::string& word, const Table& table, Goes&& goes_here, std::string_view flag,
             std::string_view scenario) {
  for (const auto& named : table) {
    if (named.name == word && goes_here(named.value)) return named.value;
  }
  throw StartupError(std::string(flag) + " " + word + " does not go with " + std::string(scenario) +
                     "; choose one of: " + list_of(table, goes_here));
}

Estimator own_estimator(System system) {
  return system == System::pendulum ? Estimator::ekf4
         : system == System::load   ? Estimator::ekf10
                                    : Estimator::ekf35;
}

struct Step {
  std::int64_t at_ms;
  int axis;
  double to_m;
};
/// Fig 5.1 as documented: up one after the other, then down.
constexpr std::array<Step, 6> kSteps{
    {{5'000, 0, 0.4}, {15'000, 1, 0.4}, {25'000, 2, 0.4}, {35'000, 0, 0}, {45'000, 1, 0}, {55'000, 2, 0}}};
/// The author's published model.
constexpr std::array<Step, 6> kPublishedSteps{{{1'000, 0, 0.4},
                                               {2'000, 1, 0.4},
                                               {3'000, 2, 0.4},
                                               {9'000, 2, 0.2},
                                               {10'000, 0, -0.4},
                                               {13'000, 1, -0.4}}};

std::span<const Step> steps_of(ReferenceKind kind) {
  if (kind == ReferenceKind::steps) return kSteps;
  if (kind == ReferenceKind::published_steps) return kPublishedSteps;
  return {};
}

}  // namespace

std::string_view to_string(Controller controller) {
  return name_of(kControllers, controller);
}
std::string_view to_string(Estimator estimator) {
  return name_of(kEstimators, estimator);
}
std::string_view to_string(Frame frame) {
  return name_of(kFrames, frame);
}
std::string_view to_string(ThesisWeights weights) {
  return name_of(kWeights, weights);
}

std::span<const Scenario> scenarios() {
  return kScenarios;
}

const Scenario* find_scenario(std::string_view name) {
  const auto found = std::find_if(kScenarios.begin(), kScenarios.end(),
                                  [&](const Scenario& scenario) { return scenario.name == name; });
  return found == kScenarios.end() ? nullptr : &*found;
}

Eigen::Vector3d Reference::at(std::int64_t begin_ms, double t) const {
  Eigen::Vector3d r = Eigen::Vector3d::Zero();
  if (kind_ == ReferenceKind::unit_step) r.x() = 1;
  if (kind_ == ReferenceKind::sinus) {  // Tab 5.4
    const double w = 2 * std::numbers::pi * t;
    r << 0.5 * std::sin(0.07 * w), 0.3 * std::sin(0.09 * w), 0.25 * std::sin(0.15 * w);
  }
  for (const Step& step : steps_of(kind_)) {
    if (begin_ms >= step.at_ms) r[step.axis] = step.to_m;
  }
  return r;
}

std::vector<std::int64_t> Reference::events_ms(bool offset_start) const {
  std::vector<std::int64_t> events;
  const auto steps = steps_of(kind_);
  if (offset_start || steps.empty()) events.push_back(0);
  for (const Step& step : steps) events.push_back(step.at_ms);
  return events;
}

Run choose(const Request& request) {
  Run run;
  run.scenario = find_scenario(request.scenario);
  if (!run.scenario) {
    std::string names;
    for (const Scenario& scenario : kScenarios)
      names += (names.empty() ? "" : ", ") + std::string(scenario.name);
    throw StartupError((request.scenario.empty()
                            ? "--world thesis needs a --scenario"
                            : "--scenario " + request.scenario + " is not one of --world thesis") +
                       std::string("; choose one of: ") + names);
  }
  const System system = run.scenario->system;
  const auto any = [](auto) { return true; };
  const auto here = [system](auto word) { return goes(system, word); };
  const std::string_view name = run.scenario->name;
  run.controller = run.scenario->controller;
  if (!request.controller.empty()) {
    run.controller = meaning(request.controller, kControllers, here, "--controller", name);
  }
  const bool ours = run.controller == Controller::ours;
  run.estimator = ours ? Estimator::ideal : own_estimator(system);
  if (!request.estimator.empty()) {
    const auto beside = [&](Estimator e) { return ours ? e == Estimator::ideal : goes(system, e); };
    run.estimator =
        meaning(request.estimator, kEstimators, beside, "--estimator", ours ? "--controller ours" : name);
  }
  if (!request.frame.empty()) {
    const auto on_ship = [&](Frame frame) {
      return frame == Frame::world || (system == System::motion && !ours);
    };
    run.frame = meaning(request.frame, kFrames, on_ship, "--frame", name);
  }
  if (!request.gains.empty()) {
    run.weights = meaning(request.gains, kWeights, any, "--gains", name);
    if (!run.has_gains()) {
      throw StartupError(
          "--gains " + request.gains + " does not go with --controller " +
          std::string(to_string(run.controller)) +
          "; only these are solved for from weights: " + list_of(kControllers, [system](Controller c) {
            return goes(system, c) && (c == Controller::prefilter || c == Controller::integral);
          }));
    }
  }
  if (!request.sensors.empty()) {
    const auto usable = [&run](bool noise) { return !noise || run.estimator != Estimator::ideal; };
    run.noise = meaning(request.sensors, kSensors, usable, "--sensors",
                        "--estimator " + std::string(to_string(run.estimator)));
  }
  run.duration_s = request.seconds.value_or(run.scenario->duration_s);
  run.seed = request.seed;
  return run;
}

std::string describe() {
  std::string text = "world thesis (rigid wire, no friction, RK4 1 ms)\n";
  const auto column = [](std::string_view word) {
    return std::string(word) + std::string(18 - word.size(), ' ');
  };
  std::string_view head = "  scenarios    ";
  for (const Scenario& scenario : kScenarios) {
    text += std::string(head) + column(scenario.name) + std::string(scenario.about) + "\n";
    head = "               ";
  }
  text +=
      "  controllers  none              the tool point stands in the robot's axes\n"
      "               prefilter         state feedback with pre-filter (FPF); pendulum, load\n"
      "               integral          state feedback with integral (IC); the default but for "
      "thesis-motion-4\n"
      "               damper            virtual damper with PD or cascade (NL); pendulum, load\n"
      "               ours              keeps the load still in the world; load, motion; sees the state\n"
      "  estimators   ideal             the law sees the state, at every stage of the integration\n"
      "               kf4, ekf4         pendulum (default: ekf4)\n"
      "               ekf10             load (default)\n"
      "               ekf35             motion (default)\n"
      "  frames       world             swing equations in axes with z up (default)\n"
      "               thesis            as printed: fed with z-down accelerations, heave upside down; motion "
      "only\n"
      "  gains        code              weights of the author's scripts (default)\n"
      "               text              weights of the text\n"
      "               printed           weights behind the printed gains, recovered by inverse LQR\n"
      "  sensors      ideal             exact (default)\n"
      "               real              white noise as the filter believes it, from the seed\n";
  return text;
}

}  // namespace motionlab::thesis
