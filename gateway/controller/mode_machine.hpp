/// @file  Modes: off → settled → ready → engaged → stopping → settled, and fault from all that moves,
/// latched.
#pragma once

#include <optional>
#include <string_view>

#include "drivers/core/text.hpp"
#include "drivers/core/time.hpp"
#include "gateway/controller/lease.hpp"
#include "idl/mode.hpp"
#include "idl/mode_request.hpp"

namespace motionlab::controller {

/// Something that keeps the gateway from moving: a code for programs and a sentence for people, both literals
/// or texts that outlive the call.
struct Obstacle {
  Text<32> code;
  Text<200> text;
};

/// What the mode depends on, at one time.
struct ModeFacts {
  LabTime t{};
  bool links_up = false;              ///< every required device has been heard
  std::optional<Obstacle> not_ready;  ///< why engaging is refused now
  std::optional<Obstacle> unsafe;     ///< why an engaged gateway must come to rest now
  bool at_rest = true;                ///< the guard's last command asks nothing to move
  std::optional<LabTime> commanded;   ///< when the owner's controller last gave a wish
};

/// The state machine as one table (README.md of this folder draws it). Nothing in it resumes by itself:
/// engaged is entered by a request alone, and a fault is left by a reset alone, at rest, with its cause gone.
/// It holds the lease of whoever is engaged, renews it with each wish of his, and latches when it expires.
class ModeMachine {
 public:
  using State = topic::ModeState;

  /// @param authority  what the gateway may do once engaged, until somebody asks for another
  explicit ModeMachine(topic::Authority authority) : authority_(authority) { topic_.authority = authority; }

  /// Takes one request. Settle wins over everything else that was asked in the same cycle. To engage takes a
  /// requester with a name.
  void request(const topic::ModeRequest& request, LabTime t);

  /// Advances by the facts. Call once per control step, after the requests.
  void step(const ModeFacts& facts);

  /// Who asks to be engaged in this cycle.
  struct Applicant {
    Text<32> name;
    bool external = false;  ///< will command himself
  };
  [[nodiscard]] const std::optional<Applicant>& applicant() const { return applicant_; }
  /// The owner's, while engaged or stopping.
  [[nodiscard]] const std::optional<Lease>& lease() const { return lease_; }

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] topic::Authority authority() const { return authority_; }
  /// Whether the guard may pass wishes on.
  [[nodiscard]] bool may_move() const {
    return state_ == State::engaged && authority_ >= topic::Authority::limited;
  }
  /// Share of the limits that the authority grants.
  [[nodiscard]] double share_of_limits() const { return authority_ == topic::Authority::full ? 1.0 : 0.1; }
  /// The state as it is published; the sequence number moves with every change.
  [[nodiscard]] const topic::Mode& topic() const { return topic_; }

 private:
  struct Transition;
  void enter(State state, LabTime t, std::string_view code, std::string_view reason);

  State state_ = State::off;
  topic::Authority authority_;
  bool settle_asked_ = false;
  std::optional<Applicant> applicant_;
  bool reset_asked_ = false;
  LeaseDesk leases_;
  std::optional<Lease> lease_;
  topic::Mode topic_;
};

}  // namespace motionlab::controller
