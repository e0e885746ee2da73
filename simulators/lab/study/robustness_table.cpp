#include "simulators/lab/study/robustness_table.hpp"

#include <iomanip>
#include <numeric>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "simulators/lab/study/sea_blocks.hpp"

namespace motionlab::study {

namespace {

struct Case {
  std::string_view name;
  std::vector<std::string> settings;
  std::vector<std::string> faults;
  bool needs_platform_body = false;
};

/// What fails, fails after 60 s. EA of a slack wire: (2 pi f)² m L with 12 kg on 1.7 m.
const std::vector<Case>& cases() {
  static const std::vector<Case> all{
      {"default world", {}, {}},
      {"joints 20 % slower", {"world.differences.joint_bandwidth_factor=0.8"}, {}},
      {"joints 20 % faster", {"world.differences.joint_bandwidth_factor=1.2"}, {}},
      {"sensors 5 ms older", {"world.differences.sensor_extra_latency_s=0.005"}, {}},
      {"wire 5 % longer", {"world.differences.wire_extra_m=0.1"}, {}},
      {"wire 5 % shorter", {"world.differences.wire_extra_m=-0.1"}, {}},
      {"load mass x 0.3", {"world.load.mass_kg=3.6"}, {}},
      {"load mass x 3", {"world.load.mass_kg=36"}, {}},
      {"calibration 1 mm, 0.1 deg",
       {"world.differences.calibration_offset_m=0.001", "world.differences.calibration_angle_deg=0.1"},
       {}},
      {"MRU noise x 3", {"world.differences.mru_noise_factor=3"}, {}},
      {"cameras at 100 Hz", {"world.camera.period_s=0.01", "lab.qualisys.period_s=0.01"}, {}},
      {"wire mode 5 Hz", {"world.load.wire_ea_n=20134"}, {}},
      {"wire mode 3 Hz", {"world.load.wire_ea_n=7248"}, {}},
      {"arm mode 6 Hz", {"world.arm.mode_frequency_hz=6"}, {}},
      {"platform hidden 2 s", {}, {"qualisys:occlude:platform@60..62"}, true},
      {"platform hidden 10 s", {}, {"qualisys:occlude:platform@60..70"}, true},
      {"load hidden 2 s", {}, {"qualisys:occlude:load@60..62"}},
      {"all cameras out 2 s", {}, {"qualisys:silent@60..62"}},
      {"all cameras out 10 s", {}, {"qualisys:silent@60..70"}},
      {"gust 50 N, 0.1 s", {}, {"world:gust=50@60..60.1"}},
      {"gust 50 N, 0.5 s", {}, {"world:gust=50@60..60.5"}},
  };
  return all;
}

/// A joint at its limit lags and overshoots a little, and encoders are noisy.
constexpr double kAngleTolerance_rad = 0.002;
constexpr double kSpeedTolerance = 1.05;
/// While engaged the load never hangs this far off unless something is being paid off; at the end it must
/// not.
constexpr double kUnstable_m = 0.25;
constexpr double kStill_deg = 0.12, kStill_m = 0.012;

std::string verdict(const LabOutcome& o) {
  if (o.beyond_angle_limit_rad > kAngleTolerance_rad) return "JOINT LIMIT EXCEEDED";
  if (o.share_of_speed_limit > kSpeedTolerance) return "SPEED LIMIT EXCEEDED";
  if (!o.report.motion) return "NOT SCORED";
  if (!o.engaged_at_end) return o.fault_code.empty() ? "rests" : "rests: " + o.fault_code;
  if (o.last_load_error_max_m > kUnstable_m) return "UNSTABLE";
  const auto& m = *o.report.motion;
  if (m.swing_rms_deg <= kStill_deg && m.load_error_rms_norm_m <= kStill_m) return "still";
  return o.last_load_error_max_m <= 3 * kStill_m ? "still again at the end" : "holds";
}

void print_row(const Case& c, const LabOutcome& o, std::ostream& out) {
  const monitor::MotionScore m = o.report.motion.value_or(monitor::MotionScore{});
  const auto limited = std::accumulate(o.report.limited.begin(), o.report.limited.end(), std::uint64_t{0});
  out << std::left << std::setw(27) << c.name << std::right << std::fixed << std::setprecision(3)
      << std::setw(8) << m.swing_rms_deg << std::setw(8) << m.swing_max_deg << std::setprecision(1)
      << std::setw(8) << 1e3 * m.load_error_rms_norm_m << std::setw(8) << 1e3 * m.load_error_max_m
      << std::setw(8) << 1e3 * o.last_load_error_max_m << std::setw(7) << 100 * o.share_of_speed_limit
      << std::setw(8) << limited << "  " << std::left << std::setw(9) << topic::to_string(o.worst_mode) << ' '
      << verdict(o) << '\n';
}

}  // namespace

std::string robustness_table(const LabRun& base) {
  std::ostringstream out;
  for (const SeaBlock& block : sea_blocks()) {
    std::vector<const Case*> rows;
    std::vector<LabRun> runs;
    for (const Case& c : cases()) {
      if (c.needs_platform_body && block.platform == "untracked") continue;
      LabRun run = block.over(base);
      run.settings.insert(run.settings.end(), c.settings.begin(), c.settings.end());
      run.faults.insert(run.faults.end(), c.faults.begin(), c.faults.end());
      rows.push_back(&c);
      runs.push_back(std::move(run));
    }
    const auto outcomes = run_labs(runs);
    out << std::defaultfloat << std::setprecision(6) << block.title() << ", seed " << base.seed << ", "
        << base.seconds << " s\n"
        << "                           swing/deg        load/mm                 speed  limited  worst\n"
        << "                             rms     max     rms     max  at end      %  samples  mode      "
           "verdict\n";
    for (std::size_t i = 0; i < rows.size(); ++i) print_row(*rows[i], outcomes[i], out);
    out << '\n';
  }
  return out.str();
}

}  // namespace motionlab::study
