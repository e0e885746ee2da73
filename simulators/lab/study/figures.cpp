#include "simulators/lab/study/figures.hpp"

#include <fstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "drivers/core/error.hpp"
#include "simulators/lab/study/figure_page.hpp"
#include "simulators/lab/study/gnuplot.hpp"
#include "simulators/lab/study/lab_plots.hpp"
#include "simulators/lab/study/thesis_plots.hpp"

namespace motionlab::study {
namespace {

struct Figure {
  std::string_view name;    ///< of its files
  std::string_view number;  ///< the thesis' figure that it is the counterpart of, or "Ours"
  std::string_view title;
  std::string_view seen;  ///< in one sentence
  Plot (*plot)(LabRecordings&);
};

struct Section {
  std::string_view title;
  std::string_view about;
  std::vector<Figure> figures;
};

const std::vector<Section>& sections() {
  static const std::vector<Section> all{
      {"The pendulum in a plane",
       "A cart that can be accelerated at will, and a load on a rigid wire of 2 m below it (Sec 4.4).",
       {
           {"fig-4-20", "Fig 4.20", "Filters on a pushed pendulum, wire 2 m",
            "Both filters begin plumb while the pendulum hangs at 20 deg: told Q and R per step, the linear "
            "filter is right at once, as the extended one is; taking the same numbers for spectral "
            "densities, as in the thesis, it needs two seconds.",
            [](LabRecordings&) { return pushed_pendulum(2.0); }},
           {"fig-4-21", "Fig 4.21", "Filters that believe 2 m on a pushed pendulum, wire 4 m",
            "On a wire twice as long as the filters believe only the linear one that takes Q and R for "
            "densities fails: what the thesis shows is a matter of tuning, not of linear against extended.",
            [](LabRecordings&) { return pushed_pendulum(4.0); }},
           {"fig-4-22", "Fig 4.22", "Pendulum, step of 1 m: state feedback with pre-filter",
            "The cart is at its new place after 4 s, without overshoot to speak of; the load is thrown by "
            "3.4 deg.",
            [](LabRecordings&) { return pendulum_step("prefilter"); }},
           {"fig-4-24", "Fig 4.24", "Pendulum, step of 1 m: state feedback with integral",
            "The integral halves the swing to 1.8 deg, for 3 % of overshoot and two seconds more.",
            [](LabRecordings&) { return pendulum_step("integral"); }},
           {"fig-4-27", "Fig 4.27", "Pendulum, step of 1 m: virtual damper with PD",
            "With the sign of the damper corrected (as printed it is unstable) the load swings least, 0.7 "
            "deg, and the cart is slowest: 13 s.",
            [](LabRecordings&) { return pendulum_step("damper"); }},
       }},
      {"The load below the arm",
       "The arm stands on the ground and its tool point can be accelerated at will; rigid wire, no friction "
       "(Sec 4.5, 5.2).",
       {
           {"fig-4-29", "Fig 4.29", "Ten-state filter, load let go plumb",
            "The tool follows the sinus of Tab 5.4 under integral control; measurements are exact and the "
            "filter begins right, so truth and estimate are one line.",
            [](LabRecordings&) { return load_filter(false); }},
           {"fig-4-30", "Fig 4.30", "Ten-state filter, load let go at 15/20 deg",
            "The same, but the filter begins plumb, wrong by 15 and 20 deg: after 40 ms it is right.",
            [](LabRecordings&) { return load_filter(true); }},
           {"fig-4-31", "Fig 4.31", "Load, steps of 0.4 m: pre-filter (FPF)",
            "Each axis is at its new place 4 s after its step; the steps in x and y throw the load by 2.8 "
            "deg, the one in z does not.",
            [](LabRecordings&) { return load_steps("prefilter"); }},
           {"fig-4-33", "Fig 4.33", "Load, steps of 0.4 m: integral (IC)",
            "A little sooner settled in x and y and without overshoot, while the load swings half as far, "
            "1.2 deg; z takes three times as long.",
            [](LabRecordings&) { return load_steps("integral"); }},
           {"fig-4-36", "Fig 4.36", "Load, steps of 0.4 m: virtual damper and cascade (NL)",
            "In y the damper overshoots by half the step and swings on for 15 s; height is not controlled "
            "and not shown.",
            [](LabRecordings&) { return load_steps("damper"); }},
           {"fig-5-1", "Fig 5.1", "Reference of the tool point: sequence of steps",
            "Up by 0.4 m, one axis after the other, then down again, in the robot's axes.",
            [](LabRecordings&) { return step_reference(); }},
           {"fig-5-2", "Fig 5.2", "Reference of the tool point: sinus",
            "0.5, 0.3 and 0.25 m about home, at 0.07, 0.09 and 0.15 Hz, in the robot's axes.",
            [](LabRecordings&) { return sinus_reference(); }},
           {"fig-5-4", "Fig 5.4", "Load, scenario 1 (at home, let go at 15/20 deg): FPF, IC, NL",
            "Pre-filter and integral bring the load to rest in about 4 s within 0.4 m; the virtual damper "
            "takes five times as long and moves the tool by more than 2 m, farther than the arm can reach.",
            [](LabRecordings&) { return load_scenario("thesis-load-1"); }},
           {"fig-5-5", "Fig 5.5", "Load, scenario 2 (steps, plumb): FPF, IC, NL",
            "The integral throws the load least and settles first in x and y, the pre-filter in z; the "
            "damper overshoots by half the step in y.",
            [](LabRecordings&) { return load_scenario("thesis-load-2"); }},
           {"fig-5-6", "Fig 5.6", "Load, scenario 3 (sinus, plumb): FPF, IC, NL",
            "All three follow late, the integral latest and in z by a quarter less; the load lags by about "
            "one degree.",
            [](LabRecordings&) { return load_scenario("thesis-load-3"); }},
           {"fig-5-7", "Fig 5.7", "Load, scenario 4 (steps, let go at 15/20 deg, wire 6 m): FPF, IC, NL",
            "On 6 m of wire, with gains and filter for 2 m, pre-filter and integral still calm the load, "
            "slowly; under the virtual damper it swings farther and farther in y, to 33 deg, the tool far "
            "beyond the arm's reach.",
            [](LabRecordings&) { return load_scenario("thesis-load-4"); }},
       }},
      {"The arm on a ship",
       "The thesis' whole motion system (Sec 4.6, 5.3), swing against gravity.",
       {
           {"fig-4-38", "Fig 4.38", "35-state filter, noisy measurements: angles of the ship in the wave",
            "The filter begins level and finds the ship's angles within 0.1 s; of 0.57 deg of noise on each "
            "measurement 0.13 deg is left.",
            [](LabRecordings&) { return ship_filter(); }},
           {"fig-4-39", "Fig 4.39", "35-state filter, noisy measurements: swing in the wave",
            "The angles are told with 5.7 deg of noise, as much as the filter believes in; 0.4 deg is left.",
            [](LabRecordings&) { return swing_filter(); }},
           {"ours-estimate", "Ours", "Ours, thesis wave: error of the estimated load",
            "How far the estimated load is from the true one, in a world that differs from what the "
            "estimator believes: where the blue line leaves the dashed band more than one time in twenty, "
            "the estimator is surer of itself than it should be.",
            [](LabRecordings& lab) { return lab_estimate(lab, "thesis-wave"); }},
           {"fig-5-3", "Fig 5.3", "The ship's motion in the thesis wave",
            "The wave of Tab 4.4, relative to neutral: 0.1 to 0.2 m and 5 deg, at 0.1 to 0.2 Hz; z points "
            "down.",
            [](LabRecordings&) { return ship_wave(); }},
           {"fig-4-40", "Fig 4.40", "Motion system, ship at rest, steps of 0.4 m: integral (IC)",
            "Each axis settles within 4 s of its step; the robot stands askew on the ship, so that a step in "
            "one of its axes moves the load in two of the world's.",
            [](LabRecordings&) { return motion_steps(); }},
           {"fig-5-8", "Fig 5.8", "Motion system, scenario 1 (ship at rest, let go at 15/20 deg): IC",
            "The tool goes after the load by up to 0.3 m; after 5.3 s the swing stays below 1 deg.",
            [](LabRecordings&) { return motion_scenario("thesis-motion-1", {}); }},
           {"fig-5-9", "Fig 5.9", "Motion system, scenario 2 (ship at rest, steps, 15/20 deg): IC",
            "The offset dies out as in scenario 1; then every step in x or y throws the load by about 2 deg.",
            [](LabRecordings&) { return motion_scenario("thesis-motion-2", {}); }},
           {"fig-5-10", "Fig 5.10", "Motion system, scenario 3 (ship at rest, sinus, plumb): IC",
            "The tool follows the sinus a second late, and the load swings by less than 1.5 deg.",
            [](LabRecordings&) { return motion_scenario("thesis-motion-3", {}); }},
       }},
      {"In the wave: the thesis and ours",
       "The wave of Tab 4.4. In the laboratory it fades in over 5 s, and the gateway is engaged at 10 s.",
       {
           {"fig-5-11", "Fig 5.11", "Motion system, scenario 4 (thesis wave): no control",
            "Without friction the swing builds up, to 24 deg in a minute; fed with heave upside down, as the "
            "thesis' equations are, it would be 32 deg.",
            [](LabRecordings&) { return uncontrolled_wave(); }},
           {"fig-5-12", "Fig 5.12", "Motion system, scenario 5 (thesis wave, at home): IC",
            "Integral control ends the build-up, but the load still goes with the ship: 0.66 m rms from its "
            "place, where it is 0.68 m without control.",
            [](LabRecordings&) {
              return motion_scenario("thesis-motion-5", {true, true, false});
            }},
           {"ours-wave", "Ours", "Ours, thesis wave: the load with and without control",
            "Once engaged, the gateway keeps the load where it belongs in the world, while the uncontrolled "
            "twin beside it (arm held at home, 3 % of damping) goes on swinging.",
            [](LabRecordings& lab) { return lab_load(lab, "thesis-wave"); }},
           {"ours-wave-rest", "Ours", "Ours, thesis wave: what is left, and the thesis' integral control",
            "The same on logarithmic axes, rms from 20 s on: the thesis' integral control in the same world "
            "is where no control is; ours is some two orders of magnitude below, with a camera body on the "
            "platform (tracked) and without (untracked).",
            [](LabRecordings& lab) { return lab_rest(lab, "thesis-wave"); }},
           {"fig-5-13", "Fig 5.13", "Motion system, scenario 6 (wave, steps, 15/20 deg, moving wire): IC",
            "Integral control follows the steps and calms the offset; then the load goes with the ship and "
            "with the wire, which nothing makes up for.",
            [](LabRecordings&) {
              return motion_scenario("thesis-motion-6", {true, true, true});
            }},
           {"ours-effort", "Ours", "Ours, thesis wave: how arm and winch move",
            "The arm does the work, all three joints moving against the ship; the winch only trims the wire.",
            [](LabRecordings& lab) { return lab_effort(lab, "thesis-wave"); }},
       }},
      {"In a random sea: ours",
       "What the thesis leaves to further work: JONSWAP, drawn from the seed, six degrees of freedom within "
       "the platform's limits.",
       {
           {"ours-sea", "Ours", "Ours, sea: the load with and without control",
            "Such a sea has waves of the pendulum's own frequency, and the uncontrolled twin swings by up to "
            "20 deg; once engaged, the gateway keeps the load where it belongs.",
            [](LabRecordings& lab) { return lab_load(lab, "sea"); }},
           {"ours-sea-rest", "Ours", "Ours, sea: what is left, and the thesis' integral control",
            "The same on logarithmic axes, rms from 20 s on: the thesis' control ends the resonance and "
            "nothing else; ours with a camera body on the platform (tracked) and without (untracked).",
            [](LabRecordings& lab) { return lab_rest(lab, "sea"); }},
       }},
  };
  return all;
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code problem;
  std::filesystem::create_directories(folder, problem);
  if (problem) {
    throw StartupError("cannot make the folder " + folder.string() + ": " + problem.message() +
                       "; choose another for --figures");
  }
}

void write_page(const std::filesystem::path& path, const std::vector<PageSection>& page) {
  std::ofstream file(path, std::ios::binary);
  file << figure_page(page);
  if (!file.flush())
    throw StartupError("cannot write " + path.string() + "; choose a folder that is writable");
}

}  // namespace

void write_figures(const std::filesystem::path& folder, const LabRun& lab) {
  make_folder(folder);
  Gnuplot gnuplot(folder);
  LabRecordings recordings(lab);
  std::vector<PageSection> page;
  for (const Section& section : sections()) {
    page.push_back({std::string(section.title), std::string(section.about), {}});
    for (const Figure& figure : section.figures) {
      Plot plot = figure.plot(recordings);
      plot.title = figure.title;
      gnuplot.draw(plot, std::string(figure.name));
      page.back().figures.push_back(
          {std::string(figure.name), std::string(figure.number), std::string(figure.seen), std::move(plot)});
    }
  }
  gnuplot.finish();
  write_page(folder / "index.html", page);
}

std::string describe_figures() {
  std::string text = "figures\n";
  for (const Section& section : sections()) {
    for (const Figure& figure : section.figures) {
      text.append("  ")
          .append(figure.name)
          .append(16 - figure.name.size(), ' ')
          .append(figure.title)
          .append("\n");
    }
  }
  return text;
}

}  // namespace motionlab::study
