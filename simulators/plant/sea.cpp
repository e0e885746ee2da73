#include "simulators/plant/sea.hpp"

#include <cmath>
#include <numbers>

#include "drivers/core/random.hpp"

namespace motionlab::plant {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;
constexpr int kBins = 40;
constexpr double kNode_s = 0.010;

double spectrum(const Scenario& s, double w) {
  return s.sea == Sea::jonswap ? jonswap(w, s.significant_height_m, s.peak_period_s, s.peak_enhancement)
                               : pierson_moskowitz(w, s.significant_height_m, s.peak_period_s);
}

/// The ramp 10 x³ − 15 x⁴ + 6 x⁵ and its derivatives by time.
struct Fade {
  double f = 1, f_dot = 0, f_ddot = 0;
};

Fade fade(double t, double duration) {
  if (t >= duration) return {};
  const double x = t / duration;
  return {x * x * x * (10 + x * (-15 + 6 * x)), 30 * x * x * (1 + x * (-2 + x)) / duration,
          60 * x * (1 + x * (-3 + 2 * x)) / (duration * duration)};
}

ShipCoordinates faded(const ShipCoordinates& s, const Fade& f) {
  return {f.f * s.eta, f.f_dot * s.eta + f.f * s.eta_dot,
          f.f_ddot * s.eta + 2 * f.f_dot * s.eta_dot + f.f * s.eta_ddot};
}

constexpr double kSurgePerHeave = 0.6, kSwayPerHeave = 0.6;
constexpr double kRollPerHeave = 18 * kDegree, kPitchPerHeave = 15 * kDegree, kYawPerHeave = 8 * kDegree;

}  // namespace

std::optional<Scenario> scenario_named(std::string_view name) {
  Scenario s;
  if (name == "thesis-wave") return s;
  if (name == "calm") {
    s.sea = Sea::calm;
    return s;
  }
  if (name == "sea") {
    s.sea = Sea::jonswap;
    return s;
  }
  if (name == "pierson-moskowitz") {
    s.sea = Sea::pierson_moskowitz;
    s.significant_height_m = 0.4;
    return s;
  }
  return std::nullopt;
}

double pierson_moskowitz(double w, double hs, double tp) {
  if (w <= 0) return 0;
  const double wp = 2 * kPi / tp;
  const double r2 = (wp / w) * (wp / w);
  return 5.0 / 16 * hs * hs * r2 * r2 / w * std::exp(-1.25 * r2 * r2);
}

double jonswap(double w, double hs, double tp, double gamma) {
  const double wp = 2 * kPi / tp;
  const double width = (w <= wp ? 0.07 : 0.09) * wp;
  const double x = (w - wp) / width;
  return (1 - 0.287 * std::log(gamma)) * pierson_moskowitz(w, hs, tp) *
         std::pow(gamma, std::exp(-0.5 * x * x));
}

ShipMotion::ShipMotion(const Scenario& scenario, std::uint64_t seed)
    : fade_in_s_(scenario.fade_in_s),
      recording_(scenario.sea == Sea::recorded ? scenario.recording : nullptr) {
  if (scenario.sea == Sea::thesis_wave) add_thesis_wave();
  if (scenario.sea == Sea::jonswap || scenario.sea == Sea::pierson_moskowitz) add_random_sea(scenario, seed);
}

void ShipMotion::add_thesis_wave() {
  // Thesis Tab 4.4, read literally: y = A sin(2 pi f t + phase); theta is pitch, phi is roll.
  struct Row {
    int coordinate;
    double amplitude, frequency_hz, phase_deg;
  };
  constexpr std::array<Row, 6> kTable{{{0, 0.1, 0.10, 0},
                                       {1, 0.2, 0.10, 45},
                                       {2, 0.2, 0.10, 90},
                                       {3, 5 * kDegree, 0.15, 90},
                                       {4, 5 * kDegree, 0.10, 0},
                                       {5, 5 * kDegree, 0.20, 120}}};
  for (const double frequency_hz : {0.10, 0.15, 0.20}) {
    Harmonic h{2 * kPi * frequency_hz, Vector6d::Zero(), Vector6d::Zero()};
    for (const Row& row : kTable) {
      if (row.frequency_hz != frequency_hz) continue;
      h.sine[row.coordinate] = row.amplitude * std::cos(row.phase_deg * kDegree);
      h.cosine[row.coordinate] = row.amplitude * std::sin(row.phase_deg * kDegree);
    }
    harmonics_.push_back(h);
  }
}

/// A wave of heave amplitude a that runs to chi and whose crest passes the ship at the phase −epsilon. Heave
/// counts down; a slope that rises to the bow lifts it, one that rises to starboard rolls to port.
void ShipMotion::add_wave(Harmonic& h, double a, double epsilon, double chi) {
  const double cos_chi = std::cos(chi), sin_chi = std::sin(chi);
  Vector6d with_crest, after_crest;
  with_crest << 0, 0, -1, 0, 0, kYawPerHeave * std::sin(2 * chi);
  after_crest << kSurgePerHeave * cos_chi, kSwayPerHeave * sin_chi, 0, -kRollPerHeave * sin_chi,
      kPitchPerHeave * cos_chi, 0;
  // with_crest cos(wt + epsilon) + after_crest sin(wt + epsilon)
  h.sine = a * (std::cos(epsilon) * after_crest - std::sin(epsilon) * with_crest);
  h.cosine = a * (std::sin(epsilon) * after_crest + std::cos(epsilon) * with_crest);
}

void ShipMotion::add_random_sea(const Scenario& scenario, std::uint64_t seed) {
  Random random(seed, "sea");
  const double wp = 2 * kPi / scenario.peak_period_s;
  const double low = 0.25 * wp, high = 3 * wp;
  constexpr int kCells = 4000;
  const double dw = (high - low) / kCells;
  std::vector<double> energy(kCells + 1, 0.0);
  for (int i = 0; i < kCells; ++i) {
    energy[static_cast<std::size_t>(i) + 1] =
        energy[static_cast<std::size_t>(i)] + dw * spectrum(scenario, low + (i + 0.5) * dw);
  }
  const double amplitude = std::sqrt(2 * energy.back() / kBins);
  Vector6d ratio;
  ratio << kSurgePerHeave, kSwayPerHeave, 1.0, kRollPerHeave, kPitchPerHeave, kYawPerHeave;
  std::size_t cell = 0;
  double bin_begin = low;
  for (int bin = 1; bin <= kBins; ++bin) {
    const double level = energy.back() * bin / kBins;
    while (cell + 1 < energy.size() - 1 && energy[cell + 1] < level) ++cell;
    const double inside = (level - energy[cell]) / (energy[cell + 1] - energy[cell]);
    const double bin_end = low + (static_cast<double>(cell) + inside) * dw;
    Harmonic h{bin_begin + (bin_end - bin_begin) * random.uniform(), Vector6d::Zero(), Vector6d::Zero()};
    if (scenario.direction) {
      add_wave(h, amplitude, 2 * kPi * random.uniform(),
               scenario.direction->mean_rad + scenario.direction->spreading_rad * random.normal());
    } else {
      for (int c = 0; c < 6; ++c) {
        const double phase = 2 * kPi * random.uniform();
        h.sine[c] = amplitude * ratio[c] * std::cos(phase);
        h.cosine[c] = amplitude * ratio[c] * std::sin(phase);
      }
    }
    harmonics_.push_back(h);
    bin_begin = bin_end;
  }
}

ShipCoordinates ShipMotion::sum_at(double t) const {
  if (recording_) return recording_->at(t);
  ShipCoordinates sum;
  for (const Harmonic& h : harmonics_) {
    const double s = std::sin(h.omega_radps * t), c = std::cos(h.omega_radps * t);
    const Vector6d value = s * h.sine + c * h.cosine;
    sum.eta += value;
    sum.eta_dot += h.omega_radps * (c * h.sine - s * h.cosine);
    sum.eta_ddot -= h.omega_radps * h.omega_radps * value;
  }
  return sum;
}

ShipCoordinates ShipMotion::at(double t) const {
  if (t < 0) return {};
  if (recording_ && t >= recording_->duration_s()) return {};
  ShipCoordinates ship = sum_at(t);
  if (t < fade_in_s_) ship = faded(ship, fade(t, fade_in_s_));
  if (recording_ && t > recording_->duration_s() - fade_in_s_) {
    Fade out = fade(recording_->duration_s() - t, fade_in_s_);
    out.f_dot = -out.f_dot;
    ship = faded(ship, out);
  }
  return ship;
}

CachedShipMotion::CachedShipMotion(const Scenario& scenario, std::uint64_t seed) : motion_(scenario, seed) {
  move_to(0);
}

void CachedShipMotion::move_to(long long node) {
  const double t = kNode_s * static_cast<double>(node);
  begin_ = node == node_ + 1 ? end_ : motion_.at(t);
  end_ = motion_.at(t + kNode_s);
  node_ = node;
  const double h = kNode_s;
  const Vector6d d = end_.eta - begin_.eta;
  const Vector6d v0 = h * begin_.eta_dot, v1 = h * end_.eta_dot;
  const Vector6d a0 = h * h * begin_.eta_ddot, a1 = h * h * end_.eta_ddot;
  c_ = {begin_.eta,
        v0,
        0.5 * a0,
        10 * d - 6 * v0 - 4 * v1 - 1.5 * a0 + 0.5 * a1,
        -15 * d + 8 * v0 + 7 * v1 + 1.5 * a0 - a1,
        6 * d - 3 * v0 - 3 * v1 - 0.5 * a0 + 0.5 * a1};
}

ShipCoordinates CachedShipMotion::at(double t) {
  if (t < 0) return {};
  const auto node = static_cast<long long>(t / kNode_s);
  if (node != node_) move_to(node);
  const double x = t / kNode_s - static_cast<double>(node);
  const auto& c = c_;
  ShipCoordinates s;
  s.eta = c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * c[5]))));
  s.eta_dot = (c[1] + x * (2 * c[2] + x * (3 * c[3] + x * (4 * c[4] + x * (5 * c[5]))))) / kNode_s;
  s.eta_ddot = (2 * c[2] + x * (6 * c[3] + x * (12 * c[4] + x * (20 * c[5])))) / (kNode_s * kNode_s);
  return s;
}

}  // namespace motionlab::plant
