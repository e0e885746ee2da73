/// @file  What to do with a checksum whose rule is not documented: find the rule first, then judge.
#pragma once

#include <cstdint>
#include <optional>

#include "drivers/mru/mru_wire.hpp"

namespace motionlab::mru {

enum class ChecksumPolicy : std::uint8_t {
  ignore,   ///< nobody looks at it
  count,    ///< a mismatch is counted and marks the sample as suspect
  enforce,  ///< a mismatch refuses the datagram, once the rule is known
};

/// Judges each datagram by its checksum. Where the format says how it is made that is easy; where it does
/// not (MRUBIN), the judge learns which rule a unit follows.
///
/// With a configured rule every frame is judged from the first. Without one, both rules are scored over the
/// first `frames_to_score` frames; the one that matched more than `lock_share` of them is locked, otherwise
/// (none, or both) the rule stays unknown for good and no frame is ever suspect.
class ChecksumJudge {
 public:
  struct Config {
    ChecksumPolicy policy = ChecksumPolicy::count;
    std::optional<ChecksumRule> rule{};  ///< nothing: find out
    std::uint32_t frames_to_score = 1000;
    double lock_share = 0.99;
  };
  enum class Verdict : std::uint8_t { good, suspect, refuse };
  enum class State : std::uint8_t { scoring, locked, unknown };

  explicit ChecksumJudge(Config config) noexcept;

  /// Of a datagram that may follow either rule of MRUBIN.
  Verdict judge(ChecksumMatch match) noexcept;
  /// Of a datagram whose format has one rule.
  Verdict judge(bool matches) noexcept;

  [[nodiscard]] State state() const noexcept { return state_; }
  /// The rule in force; nothing while scoring or when unknown.
  [[nodiscard]] std::optional<ChecksumRule> rule() const noexcept { return rule_; }
  /// Frames that did not match the rule in force.
  [[nodiscard]] std::uint64_t mismatches() const noexcept { return mismatches_; }

 private:
  void score(ChecksumMatch match) noexcept;
  [[nodiscard]] Verdict mismatch() noexcept;

  Config config_;
  State state_ = State::scoring;
  std::optional<ChecksumRule> rule_;
  std::uint32_t scored_ = 0;
  std::uint32_t matched_sum8_ = 0;
  std::uint32_t matched_ones_complement_ = 0;
  std::uint64_t mismatches_ = 0;
};

}  // namespace motionlab::mru
