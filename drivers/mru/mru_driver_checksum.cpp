#include "drivers/mru/mru_driver_checksum.hpp"

namespace motionlab::mru {

ChecksumJudge::ChecksumJudge(Config config) noexcept : config_(config), rule_(config.rule) {
  if (rule_) state_ = State::locked;
}

ChecksumJudge::Verdict ChecksumJudge::judge(ChecksumMatch match) noexcept {
  if (config_.policy == ChecksumPolicy::ignore) return Verdict::good;
  if (state_ == State::scoring) {
    score(match);
    return Verdict::good;
  }
  return !rule_ || match.of(*rule_) ? Verdict::good : mismatch();
}

ChecksumJudge::Verdict ChecksumJudge::judge(bool matches) noexcept {
  return matches || config_.policy == ChecksumPolicy::ignore ? Verdict::good : mismatch();
}

ChecksumJudge::Verdict ChecksumJudge::mismatch() noexcept {
  ++mismatches_;
  return config_.policy == ChecksumPolicy::enforce ? Verdict::refuse : Verdict::suspect;
}

void ChecksumJudge::score(ChecksumMatch match) noexcept {
  ++scored_;
  if (match.sum8) ++matched_sum8_;
  if (match.ones_complement) ++matched_ones_complement_;
  if (scored_ < config_.frames_to_score) return;
  const double needed = config_.lock_share * scored_;
  const bool sum8 = matched_sum8_ > needed;
  const bool ones_complement = matched_ones_complement_ > needed;
  state_ = sum8 != ones_complement ? State::locked : State::unknown;
  if (state_ == State::locked) rule_ = sum8 ? ChecksumRule::sum8 : ChecksumRule::ones_complement;
}

}  // namespace motionlab::mru
