/// @file  The scenarios of the thesis by name (Tab 5.5, Tab 5.7, Sec 4.4), and what can be run in them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gateway/controller/thesis_gains.hpp"

namespace motionlab::thesis {

enum class System { pendulum, load, motion };
enum class Controller { none, prefilter, integral, damper, ours };
enum class Estimator { ideal, kf4, ekf4, ekf10, ekf35 };
/// In which axes the swing equations are fed: the world's, or N's as in the thesis (heave upside down).
enum class Frame { world, thesis };
enum class ReferenceKind { home, unit_step, steps, published_steps, sinus };

[[nodiscard]] std::string_view to_string(Controller controller);
[[nodiscard]] std::string_view to_string(Estimator estimator);
[[nodiscard]] std::string_view to_string(Frame frame);
[[nodiscard]] std::string_view to_string(controller::ThesisWeights weights);

struct Scenario {
  std::string_view name;
  System system;
  std::string_view about;
  ReferenceKind reference = ReferenceKind::home;
  bool wave = false;        ///< Tab 4.4
  bool offset = false;      ///< starts with 15° and 20° (Tab 5.2)
  double wire_m = 2.0;      ///< mean length
  bool wire_sinus = false;  ///< Eq 5.2
  double duration_s = 30;
  Controller controller = Controller::integral;  ///< what the thesis runs here
};

/// All of them, in the order of the thesis. Names without suffix take the step sequence that the figure
/// shows as far as it can be read; suffix `b` takes the one of the author's published model.
[[nodiscard]] std::span<const Scenario> scenarios();
[[nodiscard]] const Scenario* find_scenario(std::string_view name);

/// Where the tool point is asked to be, as a deviation from home in the robot's axes [m].
class Reference {
 public:
  explicit Reference(ReferenceKind kind) : kind_(kind) {}
  /// Steps are constant inside a millisecond: they look at `begin_ms`; the sinus looks at `t_s`.
  [[nodiscard]] Eigen::Vector3d at(std::int64_t begin_ms, double t_s) const;
  /// When something happens, in ms. An offset start is an event at 0.
  [[nodiscard]] std::vector<std::int64_t> events_ms(bool offset_start) const;

 private:
  ReferenceKind kind_;
};

/// What is to be run. Words as on the command line; empty: what the thesis runs in that scenario.
struct Request {
  std::string scenario;
  std::string controller;
  std::string estimator;
  std::string frame;
  std::string gains;
  std::string sensors;
  std::optional<double> seconds;
  std::uint64_t seed = 1;
};

/// A request that makes sense.
struct Run {
  const Scenario* scenario = nullptr;
  Controller controller = Controller::integral;
  Estimator estimator = Estimator::ideal;
  Frame frame = Frame::world;
  controller::ThesisWeights weights = controller::ThesisWeights::code;
  bool noise = false;  ///< white, with the deviations that the filter believes; else measurements are exact
  double duration_s = 0;
  std::uint64_t seed = 1;

  /// Whether gains are solved for at all.
  [[nodiscard]] bool has_gains() const {
    return controller == Controller::prefilter || controller == Controller::integral;
  }
};

/// @throws StartupError with a sentence that lists what goes.
[[nodiscard]] Run choose(const Request& request);

/// Scenarios, controllers, estimators, frames and gains for `--list`.
[[nodiscard]] std::string describe();

}  // namespace motionlab::thesis
