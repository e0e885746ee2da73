#include "simulators/lab/study/thesis_words.hpp"

#include "drivers/core/error.hpp"
#include "simulators/lab/study/option_words.hpp"

namespace motionlab::study {
namespace {

[[noreturn]] void refuse(const std::string& words, const std::string& world, const std::string& instead) {
  throw StartupError(words + " does not go with --world " + world + "; " + instead);
}

}  // namespace

void ThesisWords::add_to(CLI::App& app) {
  app.add_option("--world", world, "lab: the whole line; thesis: the thesis' own simulations")
      ->check(CLI::IsMember({"lab", "thesis"}))
      ->capture_default_str();
  app.add_option("--frame", frame, "thesis: as printed, with heave upside down (--world thesis)")
      ->check(CLI::IsMember({"world", "thesis"}))
      ->capture_default_str();
  app.add_option("--gains", gains, "whose weights: text, printed or code (--world thesis)")
      ->check(CLI::IsMember({"text", "printed", "code"}));
}

thesis::Request thesis_request(const CLI::App& app, const LabRun& lab, const ThesisWords& words) {
  allow_only(
      app, "world", "--world thesis",
      {"scenario", "controller", "estimator", "frame", "gains", "sensors", "seconds", "seed", "report"});
  const auto given = [&app](const char* option, const std::string& word) {
    return app.count(option) > 0 ? word : std::string();
  };
  thesis::Request request;
  request.scenario = given("--scenario", lab.scenario);
  request.controller = given("--controller", lab.controller);
  request.estimator = given("--estimator", lab.estimator);
  request.frame = given("--frame", words.frame);
  request.gains = words.gains;
  request.sensors = given("--sensors", lab.sensors);
  if (app.count("--seconds") > 0) request.seconds = lab.seconds;
  request.seed = lab.seed;
  return request;
}

void refuse_thesis_words(const LabRun& lab, const ThesisWords& words) {
  if (thesis::find_scenario(lab.scenario) != nullptr) {
    refuse("--scenario " + lab.scenario, "lab", "it is one of --world thesis");
  }
  if (lab.controller != "ours" && lab.controller != "integral" && lab.controller != "none") {
    refuse("--controller " + lab.controller, "lab", "choose one of: ours, integral, none");
  }
  if (lab.estimator != "ours") refuse("--estimator " + lab.estimator, "lab", "choose one of: ours");
  if (words.frame != "world") refuse("--frame " + words.frame, "lab", "choose one of: world");
  if (!words.gains.empty()) refuse("--gains " + words.gains, "lab", "its controller solves for its own");
}

}  // namespace motionlab::study
