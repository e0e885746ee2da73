#include "gateway/monitor/mode_command.hpp"

#include <algorithm>
#include <optional>
#include <ostream>

#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"
#include "gateway/monitor/verdict.hpp"

namespace motionlab::monitor {
namespace {

using topic::Mode;
using topic::ModeAction;
using topic::ModeState;

/// A reset is refused while the arm still brakes; that has passed by then.
constexpr Nanoseconds kBraking = 2s;

/// One request on its way.
class Petition {
 public:
  Petition(Session& session, const Connection& connection, const ModeCommand& command)
      : session_(session),
        action_(command.action),
        repeat_(command.action == ModeAction::settle ? 20ms : 100ms),
        timeout_(from_seconds(connection.timeout_s)),
        wait_ready_(from_seconds(command.wait_ready_s)) {
    session.dds.out<topic::ModeRequest>();
    session.dds.in<Mode>();
    publisher_.emplace(session.local.advertise<topic::ModeRequest>());
    mode_.emplace(session.local.reader<Mode>());
    modes_.emplace(session.local.subscribe<Mode>(session.wakeup));
    session.dds.start();
    start_ = session.clock.now();
    not_before_ = command.at_ns ? std::max(start_, from_ns(*command.at_ns)) : start_;
    request_.requester = requester_name();
    request_.sequence_number = static_cast<std::uint64_t>(to_ns(start_));  // grows from run to run
    request_.action = action_;
    request_.authority = command.authority;
  }

  /// The end of it; a pending verdict when time was over, nothing when no mode was heard.
  std::optional<Verdict> run(const std::atomic<bool>& interrupted) {
    while (!interrupted) {
      now_ = mode_->newest();
      const LabTime t = session_.clock.now();
      if (!asked_ && may_ask(t)) ask_first(t);
      if (asked_) ask_again(t);
      const bool asked = asked_ && session_.dds.matched<topic::ModeRequest>() > 0;
      const std::optional<Verdict> verdict = judged(asked);
      if (verdict && (is_final(*verdict, t) || t >= deadline())) return verdict;
      if (!now_ && t >= deadline()) return std::nullopt;
      session_.wakeup->wait(t < not_before_ ? std::min(repeat_, not_before_ - t) : repeat_);
    }
    return judged(asked_.has_value());
  }

  [[nodiscard]] const std::optional<Mode>& mode() const { return now_; }

 private:
  [[nodiscard]] bool may_ask(LabTime t) const {
    if (action_ == ModeAction::settle) return true;
    if (!now_ || t < not_before_) return false;
    const bool may_become_ready = now_->state == ModeState::off || now_->state == ModeState::settled;
    return !may_become_ready || t >= start_ + wait_ready_;
  }

  [[nodiscard]] bool is_final(const Verdict& verdict, LabTime t) const {
    const bool may_pass = action_ == ModeAction::reset && t < *asked_ + kBraking;
    return verdict.outcome == Outcome::granted || (verdict.outcome == Outcome::refused && !may_pass);
  }

  void ask_first(LabTime t) {
    asked_ = t;
    before_ = now_;
    next_ = t;
    request_.t_created_ns = to_ns(t);
  }

  void ask_again(LabTime t) {
    if (t < next_ || session_.dds.matched<topic::ModeRequest>() == 0) return;
    publisher_->publish(request_);
    next_ = t + repeat_;
  }

  [[nodiscard]] std::optional<Verdict> judged(bool asked) const {
    if (!now_) return std::nullopt;
    if (!asked)
      return Verdict{Outcome::pending, "the gateway is " + std::string{to_string(now_->state)} +
                                           ", but it does not listen to requests"};
    if (action_ == ModeAction::authority) return judge_authority(request_.authority, before_, *now_);
    return judge(action_, before_, *now_, request_.requester.view());
  }

  [[nodiscard]] LabTime deadline() const {
    return asked_ ? *asked_ + timeout_ : std::max(not_before_ + timeout_, start_ + wait_ready_);
  }

  Session& session_;
  const ModeAction action_;
  const Nanoseconds repeat_, timeout_, wait_ready_;
  std::optional<bus::Publisher<topic::ModeRequest>> publisher_;
  std::optional<bus::Reader<Mode>> mode_;
  std::optional<bus::Subscription<Mode>> modes_;  ///< only for being woken
  topic::ModeRequest request_;
  LabTime start_{}, not_before_{}, next_{};
  std::optional<LabTime> asked_;
  std::optional<Mode> before_, now_;
};

}  // namespace

int run_mode(const Connection& connection, const ModeCommand& command, const Terminal& terminal) {
  Session session{connection};
  Petition petition{session, connection, command};
  const std::optional<Verdict> verdict = petition.run(terminal.interrupted);
  const bool granted = verdict && verdict->outcome == Outcome::granted;
  const std::string action{to_string(command.action)};
  const std::string sentence =
      verdict ? verdict->sentence
              : nobody_answers(connection, std::max(connection.timeout_s, command.wait_ready_s));
  if (command.json) {
    nlohmann::ordered_json json;
    json["action"] = action;
    json["granted"] = granted;
    json["sentence"] = sentence;
    json["mode"] = petition.mode() ? topic_json(*petition.mode()) : nullptr;
    terminal.out << json_text(json);
  }
  if (granted) {
    if (!command.json) terminal.out << Paint{terminal.colour}(Ink::good, escaped(sentence)) << "\n";
    return kExitGood;
  }
  if (terminal.interrupted) {
    terminal.err << "interrupted; whether the gateway will " << action << " is not known\n";
    return kExitInterrupted;
  }
  if (!command.json) terminal.err << action << ": " << escaped(sentence) << "\n";
  return verdict ? kExitWrong : kExitNobody;
}

}  // namespace motionlab::monitor
