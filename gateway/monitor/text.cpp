#include "gateway/monitor/text.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "drivers/core/result.hpp"
#include "gateway/monitor/safe_text.hpp"

namespace motionlab::monitor {
namespace {

/// The parts, one behind the other.
template <class... Parts>
std::string joined(const Parts&... parts) {
  std::string text;
  (text.append(std::string_view{parts}), ...);
  return text;
}

std::string left(std::string_view text, std::size_t width) {
  std::string padded{text};
  if (padded.size() < width) padded.resize(width, ' ');
  return padded;
}

std::string right(const std::string& text, std::size_t width) {
  return text.size() < width ? std::string(width - text.size(), ' ') + text : text;
}

/// "0.04 deg (without: 5.12)": the value now, and what the uncontrolled twin has.
std::string beside(double value, double without, std::string_view unit, int decimals, std::size_t width) {
  std::string text = joined(right(fixed(value, decimals), width), " ", unit);
  if (std::isfinite(without)) text += joined(" (without: ", right(fixed(without, decimals), width), ")");
  return text;
}

std::string age_ms(double age_s) {
  return age_s < 0 ? "-" : fixed(1e3 * age_s, 1);
}

std::string rejects(const topic::Health& health) {
  const auto total = std::accumulate(health.rejected.begin(), health.rejected.end(), std::uint64_t{0});
  const std::string text = joined("rejected ", std::to_string(total));
  std::string reasons;
  for (std::size_t i = 0; i < health.rejected.size(); ++i) {
    if (health.rejected[i] == 0) continue;
    if (!reasons.empty()) reasons += ", ";
    reasons += joined(to_string(static_cast<Reason>(i)), " ", std::to_string(health.rejected[i]));
  }
  return reasons.empty() ? text : joined(text, " (", reasons, ")");
}

Ink ink_of(topic::LinkState link) {
  switch (link) {
    case topic::LinkState::up:
      return Ink::good;
    case topic::LinkState::connecting:
      return Ink::caution;
    case topic::LinkState::down:
    case topic::LinkState::stale:
      break;
  }
  return Ink::bad;
}

Ink ink_of(topic::ModeState state) {
  switch (state) {
    case topic::ModeState::engaged:
    case topic::ModeState::ready:
      return Ink::good;
    case topic::ModeState::fault:
      return Ink::bad;
    case topic::ModeState::off:
    case topic::ModeState::settled:
    case topic::ModeState::stopping:
      break;
  }
  return Ink::caution;
}

}  // namespace

std::string Paint::operator()(Ink ink, std::string_view text) const {
  if (!colour_) return std::string{text};
  constexpr std::array<std::string_view, 3> kEscapes{"\033[32m", "\033[33m", "\033[31m"};
  return joined(kEscapes[static_cast<std::size_t>(ink)], text, "\033[0m");
}

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  std::array<char, 400> text{};  // room for the greatest double
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}

std::string mode_line(const topic::Mode& mode, Paint paint) {
  std::string text = paint(ink_of(mode.state), to_string(mode.state));
  text += joined(", authority ", to_string(mode.authority));
  if (!mode.owner.empty()) text += joined(", owner ", escaped(mode.owner.view()));
  if (!mode.fault_code.empty()) text += joined(", ", escaped(mode.fault_code.view()));
  if (!mode.reason.empty()) text += joined(": ", escaped(mode.reason.view()));
  return text;
}

std::string device_line(const topic::Health& health, Paint paint) {
  std::string text = joined(left(escaped(health.device.view()), 10), " ",
                            paint(ink_of(health.link), left(to_string(health.link), 10)));
  text += joined(" ", right(fixed(health.rate_hz, 1), 7), " Hz  age ", right(age_ms(health.age_s), 7),
                 " ms (max ", age_ms(health.age_max_s), " of ", age_ms(health.stale_after_s), ")  lost ",
                 std::to_string(health.lost), "  ", rejects(health));
  if (!health.required) text += "  optional";
  if (!health.advice.empty()) text += joined("  ", paint(Ink::caution, escaped(health.advice.view())));
  return text;
}

void HealthSummary::add(const topic::Health& health) {
  ++devices;
  if (health.link == topic::LinkState::up) {
    ++up;
  } else if (trouble.empty()) {
    trouble = joined(escaped(health.device.view()), " ", to_string(health.link));
  }
}

std::string live_line(const LiveFacts& facts, Paint paint) {
  const topic::Score& score = facts.score;
  std::string text = joined(right(fixed(facts.t_s, 0), 4), " s  ");
  if (facts.silent_s > 1) {
    text += joined(paint(Ink::bad, joined("silent for ", fixed(facts.silent_s, 0), " s")), "  ");
  }
  text += facts.mode ? paint(ink_of(facts.mode->state), left(to_string(facts.mode->state), 8)) : "no mode ";
  text += joined("  swing ", beside(score.swing_now_deg, score.baseline_swing_now_deg, "deg", 2, 5));
  text += joined("  load ",
                 beside(1e3 * score.load_error_now_m, 1e3 * score.baseline_load_error_now_m, "mm", 1, 6));
  if (facts.control) {
    text += joined("  ages mru ", age_ms(facts.control->age_mru_s), " bodies ",
                   age_ms(facts.control->age_bodies_s), " arm ", age_ms(facts.control->age_arm_s), " winch ",
                   age_ms(facts.control->age_winch_s), " ms");
  }
  const HealthSummary& health = facts.health;
  const std::string devices = joined(std::to_string(health.up), "/", std::to_string(health.devices), " up");
  text += joined("  ", paint(health.devices > 0 && health.trouble.empty() ? Ink::good : Ink::bad, devices));
  if (!health.trouble.empty()) text += joined(" (", health.trouble, ")");
  return text;
}

std::string summary(const Report& report) {
  if (!report.motion) {
    return joined("scored nothing: the run ended after ", fixed(report.duration_s, 1),
                  " s, the window begins at ", fixed(report.score_from_s, 1), " s\n");
  }
  const MotionScore& motion = *report.motion;
  std::string text;
  const auto line = [&text](std::string_view name, const auto&... parts) {
    text += joined(left(name, 20), parts..., "\n");
  };
  line("scored", fixed(report.duration_s - report.score_from_s, 1), " s, from ",
       fixed(report.score_from_s, 1), " s on, by the ",
       report.source == Source::truth ? "truth" : "estimate");
  const auto load = [&line](std::string_view name, const MotionScore& of) {
    line(name, "swing rms ", fixed(of.swing_rms_deg, 3), " deg, max ", fixed(of.swing_max_deg, 3),
         " deg; load rms ", fixed(1e3 * of.load_error_rms_norm_m, 1), " mm, max ",
         fixed(1e3 * of.load_error_max_m, 1), " mm");
  };
  load("with compensation", motion);
  if (report.baseline) {
    const auto percent = [](std::optional<double> share) { return share ? fixed(100 * *share, 1) : "-"; };
    load("without", *report.baseline);
    line("less by", "swing ", percent(reduction(motion.swing_rms_deg, report.baseline->swing_rms_deg)),
         " %, load ",
         percent(reduction(motion.load_error_rms_norm_m, report.baseline->load_error_rms_norm_m)), " %");
  }
  if (const auto& age = report.age_at_actuation_us) {
    line("age at actuation", "p50 ", age_ms(1e-6 * age->p50), ", p99 ", age_ms(1e-6 * age->p99), ", max ",
         age_ms(1e-6 * age->max), " ms");
  }
  for (const Freshness& device : report.freshness) {
    line(escaped(device.device), "greatest age ", age_ms(device.age_max_s), " of the allowed ",
         age_ms(device.stale_after_s), " ms");
  }
  for (const FaultReport& fault : report.faults)
    line("fault", "at ", fixed(fault.t_s, 2), " s: ", escaped(fault.fault));
  return text;
}

}  // namespace motionlab::monitor
