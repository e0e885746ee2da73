#include "simulators/lab/study/source_table.hpp"

#include <iomanip>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "simulators/lab/study/sea_blocks.hpp"

namespace motionlab::study {

namespace {

struct Source {
  std::string_view name;
  std::string_view why;
  std::vector<std::string> ideal;  ///< settings that take it out of the world
};

const std::vector<Source>& sources() {
  static const std::vector<Source> all{
      {"joint lag",
       "10 % slower than the model whose inverse moves the arm",
       {"world.differences.joint_bandwidth_factor=1"}},
      {"latency", "MRU and cameras 3 ms older than stamped", {"world.differences.sensor_extra_latency_s=0"}},
      {"calibration",
       "0.5 mm, 0.05 deg: what turns with the ship is not constant",
       {"world.differences.calibration_offset_m=0", "world.differences.calibration_angle_deg=0"}},
      {"wire",
       "2 mm longer than told, and it stretches",
       {"world.differences.wire_extra_m=0", "world.load.wire_ea_n=2e6"}},
      {"camera, slow", "1 mm over 1 s cannot be told from motion", {"world.camera.correlated_rms_m=0"}},
      {"camera, white",
       "0.5 mm a marker, 0.05 deg",
       {"world.camera.marker_noise_rms_m=0", "world.camera.angle_noise_rms_deg=0"}},
      {"MRU tilt",
       "0.02 deg over 20 s moves the tool and leaks gravity",
       {"world.mru1.roll_pitch_rms_rad=0"}},
      {"MRU yaw",
       "drifts freely; cannot be told from surge and sway",
       {"world.mru1.yaw_walk_deg_per_sqrt_min=0"}},
      {"MRU rates, accelerations",
       "white noise and bias",
       {"world.mru1.rate_noise_rms_radps=0", "world.mru1.acceleration_noise_rms_mps2=0",
        "world.mru1.acceleration_bias_mps2=[0, 0, 0]"}},
      {"encoders",
       "noise and quantum",
       {"world.arm.encoder_noise_rms_rad=0", "world.arm.encoder_quantum_rad=0",
        "world.arm.speed_noise_rms_radps=0"}},
      {"arm compliance",
       "12 Hz: sags with the ship's turning, lags when accelerated",
       {"world.arm.flexible=false"}},
      {"load pitch", "tilts under its hook at 3 Hz", {"world.load.rigid_body=false"}},
  };
  return all;
}

void append(std::vector<std::string>& to, const std::vector<std::string>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

void print_score(const LabOutcome& o, std::ostream& out) {
  const monitor::MotionScore m = o.report.motion.value_or(monitor::MotionScore{});
  out << std::setprecision(4) << std::setw(9) << m.swing_rms_deg << std::setprecision(2) << std::setw(8)
      << 1e3 * m.load_error_rms_norm_m;
}

}  // namespace

std::string source_table(const LabRun& base) {
  std::ostringstream out;
  for (const SeaBlock& block : sea_blocks()) {
    // The default world, a world without any source, and two runs for each source.
    std::vector<LabRun> runs(2, block.over(base));
    for (const Source& source : sources()) append(runs[1].settings, source.ideal);
    for (const Source& source : sources()) {
      LabRun without = block.over(base), alone = without;
      append(without.settings, source.ideal);
      for (const Source& other : sources()) {
        if (&other != &source) append(alone.settings, other.ideal);
      }
      runs.push_back(std::move(without));
      runs.push_back(std::move(alone));
    }
    const auto outcomes = run_labs(runs);
    out << std::defaultfloat << std::setprecision(6) << block.title() << ", seed " << base.seed << ", "
        << base.seconds << " s: rms of swing/deg and load/mm\n"
        << "                           without it           alone\n"
        << std::fixed;
    const auto name = [&out](std::string_view text) {
      out << std::left << std::setw(25) << text << std::right;
    };
    name("(the default world)");
    print_score(outcomes[0], out);
    out << "                     all of them\n";
    for (std::size_t i = 0; i < sources().size(); ++i) {
      name(sources()[i].name);
      print_score(outcomes[2 + 2 * i], out);
      out << "  ";
      print_score(outcomes[3 + 2 * i], out);
      out << "  " << sources()[i].why << '\n';
    }
    name("(no source at all)");
    out << "                   ";
    print_score(outcomes[1], out);
    out << "  the method itself\n\n";
  }
  return out.str();
}

}  // namespace motionlab::study
