/// @file  What the topics say, in one line each, for people.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "gateway/monitor/report.hpp"
#include "idl/control.hpp"
#include "idl/health.hpp"
#include "idl/mode.hpp"
#include "idl/score.hpp"

namespace motionlab::monitor {

enum class Ink { good, caution, bad };

/// Colours a word, or leaves it as it is when the reader is no terminal.
class Paint {
 public:
  explicit Paint(bool colour) : colour_(colour) {}
  [[nodiscard]] std::string operator()(Ink ink, std::string_view text) const;

 private:
  bool colour_;
};

/// A number with so many decimals; "-" for one that is not finite.
[[nodiscard]] std::string fixed(double value, int decimals);

/// "engaged, authority full, owner alice@lab: engaged on request"
[[nodiscard]] std::string mode_line(const topic::Mode& mode, Paint paint);

/// "mru1       up          200.0 Hz  age    2.1 ms (max 8.0 of 30.0)  lost 0  rejected 3 (foreign 3)  advice"
[[nodiscard]] std::string device_line(const topic::Health& health, Paint paint);

/// How many devices are up, and what is wrong with the first that is not.
struct HealthSummary {
  int devices = 0;
  int up = 0;
  std::string trouble;  ///< "mru1 stale"; empty when there is none
  void add(const topic::Health& health);
};

/// What the live line is made of.
struct LiveFacts {
  double t_s = 0;  ///< of the run
  topic::Score score;
  std::optional<topic::Mode> mode;
  std::optional<topic::Control> control;
  HealthSummary health;
  double silent_s = 0;  ///< since the newest sample of the source
};

/// " 23 s  engaged  swing 0.04 deg (without: 5.12)  load 3.2 mm (without: 612.0)  ages mru 2.4 bodies 8.1 …"
[[nodiscard]] std::string live_line(const LiveFacts& facts, Paint paint);

/// The report in a few lines.
[[nodiscard]] std::string summary(const Report& report);

}  // namespace motionlab::monitor
