#include "gateway/monitor/verdict.hpp"

namespace motionlab::monitor {
namespace {

using topic::Mode;
using topic::ModeAction;
using topic::ModeState;

Verdict pending(const Mode& now) {
  return {Outcome::pending,
          "the gateway stays " + std::string{to_string(now.state)} + ": " + now.reason.str()};
}

Verdict refused(std::string_view what, const Mode& now, std::string_view advice = "") {
  std::string sentence{what};
  if (!now.fault_code.empty()) sentence += " (" + now.fault_code.str() + ")";
  sentence += ": " + now.reason.str();
  if (!advice.empty()) sentence += "; " + std::string{advice};
  return {Outcome::refused, sentence};
}

Verdict judge_settle(const Mode& now) {
  switch (now.state) {
    case ModeState::engaged:
    case ModeState::stopping:
      return pending(now);
    case ModeState::fault:
      return refused("the gateway has stopped by itself", now, "settling changes nothing: motionlab reset");
    case ModeState::off:
    case ModeState::settled:
    case ModeState::ready:
      break;
  }
  return {Outcome::granted, "settled: nothing is commanded"};
}

Verdict judge_engage(bool changed, const Mode& now, std::string_view requester) {
  switch (now.state) {
    case ModeState::engaged:
      if (now.owner.empty() || now.owner.view() == requester) return {Outcome::granted, "engaged"};
      return {Outcome::refused, "already engaged by " + now.owner.str() + "; settle first"};
    case ModeState::fault:
      return refused("a fault is latched", now, "when its cause is gone: motionlab reset");
    case ModeState::settled:
      if (changed && !now.fault_code.empty()) return refused("refused", now);
      break;
    case ModeState::off:
    case ModeState::ready:
    case ModeState::stopping:
      break;
  }
  return pending(now);
}

Verdict judge_reset(bool changed, const std::optional<Mode>& before, const Mode& now) {
  if (now.state != ModeState::fault) {
    const bool was_latched = before && before->state == ModeState::fault;
    return {Outcome::granted, was_latched ? "the fault is reset" : "no fault is latched"};
  }
  return changed ? refused("the fault stays", now) : pending(now);
}

}  // namespace

Verdict judge(ModeAction action, const std::optional<Mode>& before, const Mode& now,
              std::string_view requester) {
  const bool changed = before && now.sequence_number != before->sequence_number;
  switch (action) {
    case ModeAction::settle:
      return judge_settle(now);
    case ModeAction::engage:
      return judge_engage(changed, now, requester);
    case ModeAction::reset:
      return judge_reset(changed, before, now);
    case ModeAction::authority:
      break;
  }
  return {Outcome::refused, "this request is not known here"};
}

Verdict judge_authority(topic::Authority wanted, const std::optional<Mode>& before, const Mode& now) {
  if (now.authority == wanted) return {Outcome::granted, "authority is " + std::string{to_string(wanted)}};
  const bool changed = before && now.sequence_number != before->sequence_number;
  if (changed && now.fault_code.view() == "authority_refused") return refused("refused", now);
  return {Outcome::pending,
          "authority stays " + std::string{to_string(now.authority)} + ": " + now.reason.str()};
}

}  // namespace motionlab::monitor
