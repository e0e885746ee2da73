#include "gateway/controller/mode_machine.hpp"

#include <array>
#include <span>

namespace motionlab::controller {

using topic::ModeAction;

void ModeMachine::request(const topic::ModeRequest& request, LabTime t) {
  switch (request.action) {
    case ModeAction::settle:
      settle_asked_ = true;
      break;
    case ModeAction::engage:
      // An owner without a name owns nothing.
      if (!request.requester.empty()) applicant_ = Applicant{request.requester, request.external_controller};
      break;
    case ModeAction::reset:
      reset_asked_ = true;
      break;
    case ModeAction::authority:
      // More authority is never granted while something moves.
      if (request.authority > topic::Authority::full) break;
      if ((state_ == State::engaged || state_ == State::stopping) && request.authority > authority_) {
        enter(state_, t, "authority_refused", "more authority is granted only while settled; settle first");
        break;
      }
      authority_ = request.authority;
      // A latched fault goes on telling its cause.
      if (state_ == State::fault) {
        enter(state_, t, topic_.fault_code, topic_.reason);
      } else {
        enter(state_, t, "", "authority changed on request");
      }
      break;
  }
}

/// One row of the table: in `from`, when `applies`, go to `to`.
struct ModeMachine::Transition {
  State from;
  State to;
  bool applies;
  std::string_view code;
  std::string_view reason;
};

void ModeMachine::step(const ModeFacts& facts) {
  const bool settle = settle_asked_, reset = reset_asked_;
  const bool engage = applicant_.has_value() && !settle;
  if (lease_ && facts.commanded) lease_->renew(*facts.commanded);
  const bool lapsed = state_ == State::engaged && !(lease_ && lease_->valid(facts.t));
  const std::string_view unsafe_code = facts.unsafe ? facts.unsafe->code.view() : "";
  const std::string_view unsafe_text = facts.unsafe ? facts.unsafe->text.view() : "";
  // What would stop an engaged gateway also keeps it from engaging.
  const std::optional<Obstacle>& not_ready = facts.not_ready ? facts.not_ready : facts.unsafe;
  const std::string_view hindrance_code = not_ready ? not_ready->code.view() : "";
  const std::string_view hindrance = not_ready ? not_ready->text.view() : "";
  const bool hindered = not_ready.has_value();
  const bool unsafe = facts.unsafe.has_value();

  // The first row that applies is taken; its order within a state is its priority.
  const std::array table{
      Transition{State::off, State::settled, facts.links_up, "", "all required devices have been heard"},
      Transition{State::settled, State::ready, !hindered, "",
                 "everything is fresh and healthy; engage when you like"},
      Transition{State::settled, State::settled, engage, hindrance_code, hindrance},
      Transition{State::ready, State::settled, hindered, hindrance_code, hindrance},
      Transition{State::ready, State::engaged, engage, "", "engaged on request"},
      Transition{State::engaged, State::fault, unsafe, unsafe_code, unsafe_text},
      Transition{State::engaged, State::fault, lapsed, "lease_lost",
                 "the owner's commands have ceased; see whether that controller runs, then reset"},
      Transition{State::engaged, State::stopping, settle, "", "settling on request"},
      Transition{State::stopping, State::fault, unsafe, unsafe_code, unsafe_text},
      Transition{State::stopping, State::settled, facts.at_rest, "", "at rest; nothing is commanded"},
      Transition{State::fault, State::fault, reset && unsafe, unsafe_code, unsafe_text},
      Transition{State::fault, State::fault, reset && !facts.at_rest, topic_.fault_code,
                 "a fault is reset only at rest; ask again"},
      Transition{State::fault, State::settled, reset, "", "fault was reset at rest"},
  };
  for (const Transition& row : table) {
    if (row.from != state_ || !row.applies) continue;
    if (row.to == State::engaged) lease_ = leases_.grant(applicant_->name, applicant_->external, facts.t);
    enter(row.to, facts.t, row.code, row.reason);
    break;
  }
  settle_asked_ = reset_asked_ = false;
  applicant_.reset();
  topic_.t_lease_expires_ns = lease_ ? to_ns(lease_->expires()) : 0;
}

void ModeMachine::enter(State state, LabTime t, std::string_view code, std::string_view reason) {
  if (state != state_) topic_.t_changed_ns = to_ns(t);
  state_ = state;
  if (state != State::engaged && state != State::stopping) lease_.reset();
  topic_.owner = lease_ ? lease_->owner() : Text<32>{};
  topic_.external_controller = lease_ && lease_->external();
  ++topic_.sequence_number;
  topic_.state = state;
  topic_.authority = authority_;
  topic_.fault_latched = state == State::fault;
  topic_.fault_code = code;
  topic_.reason = reason;
}

}  // namespace motionlab::controller
