#include "gateway/monitor/reference_command.hpp"

#include <algorithm>
#include <cmath>
#include <ostream>
#include <string>

#include "gateway/monitor/progress.hpp"
#include "gateway/monitor/safe_text.hpp"
#include "gateway/monitor/text.hpp"
#include "gateway/monitor/topic_json.hpp"
#include "idl/estimate.hpp"
#include "idl/mode.hpp"

namespace motionlab::monitor {
namespace {

using Place = std::array<double, 3>;

constexpr Nanoseconds kRepeat = 50ms;
/// The match is one-sided for a moment: what is written then may be lost, so it is said for so long.
constexpr Nanoseconds kSayFor = 500ms;

std::string metres(const Place& place) {
  return fixed(place[0], 4) + " " + fixed(place[1], 4) + " " + fixed(place[2], 4) + " m";
}

double distance(const Place& a, const Place& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// What the bus says about the place of the load, and a voice.
class Talk {
 public:
  Talk(const Connection& connection, const Terminal& terminal, bool speaks)
      : session_{connection}, terminal_{terminal}, timeout_{from_seconds(connection.timeout_s)} {
    session_.dds.in<topic::Estimate>();
    session_.dds.in<topic::Mode>();
    if (speaks) {
      session_.dds.out<topic::Reference>();
    } else {
      session_.dds.in<topic::Reference>();
    }
    session_.dds.start();
  }

  /// Waits until it is so, or time is over, or the user has had enough.
  template <class Done>
  bool wait(Nanoseconds at_most, Done&& done) {
    const LabTime end = session_.clock.now() + at_most;
    while (!terminal_.interrupted) {
      while (const auto heard = references_.next()) reference_ = heard;
      if (done()) return true;
      if (session_.clock.now() >= end) break;
      session_.wakeup->wait(kRepeat);
    }
    return false;
  }

  [[nodiscard]] std::optional<Place> load() const {
    const auto estimate = estimates_.newest();
    return estimate && estimate->valid ? std::optional{estimate->p_world_load_m} : std::nullopt;
  }
  [[nodiscard]] std::optional<topic::Mode> mode() const { return modes_.newest(); }
  [[nodiscard]] const std::optional<topic::Reference>& reference() const { return reference_; }
  [[nodiscard]] Nanoseconds timeout() const { return timeout_; }
  [[nodiscard]] LabTime now() const { return session_.clock.now(); }

  /// Says it again and again. @returns false when nobody listens
  bool say(topic::Reference& reference) {
    auto publisher = session_.local.advertise<topic::Reference>();
    if (!wait(timeout_, [this] { return session_.dds.matched<topic::Reference>() > 0; })) return false;
    reference.requester = requester_name();
    reference.t_created_ns = to_ns(now());
    reference.sequence_number = static_cast<std::uint64_t>(reference.t_created_ns);  // grows from run to run
    (void)wait(kSayFor, [&] {
      publisher.publish(reference);
      return false;
    });
    return true;
  }

 private:
  Session session_;
  const Terminal& terminal_;
  const Nanoseconds timeout_;
  bus::Reader<topic::Estimate> estimates_ = session_.local.reader<topic::Estimate>();
  bus::Reader<topic::Mode> modes_ = session_.local.reader<topic::Mode>();
  bus::Subscription<topic::Reference> references_ =
      session_.local.subscribe<topic::Reference>(session_.wakeup);
  std::optional<topic::Reference> reference_;
};

int show(Talk& talk, const Connection& connection, bool json, const Terminal& terminal) {
  // A reference is kept by whoever told it only as long as he is there: most often there is none to be heard.
  (void)talk.wait(talk.timeout(), [&] { return talk.load().has_value() && talk.mode().has_value(); });
  if (terminal.interrupted) return kExitInterrupted;
  const auto load = talk.load();
  if (!load && !talk.mode() && !talk.reference()) {
    terminal.err << nobody_answers(connection, connection.timeout_s) << "\n";
    return kExitNobody;
  }
  if (json) {
    nlohmann::ordered_json out;
    out["load"] = load ? nlohmann::ordered_json(*load) : nullptr;
    out["reference"] = talk.reference() ? topic_json(*talk.reference()) : nullptr;
    terminal.out << json_text(out);
    return kExitGood;
  }
  terminal.out << "load       " << (load ? metres(*load) + " in world, estimated" : "no valid estimate")
               << "\n";
  if (const auto& reference = talk.reference()) {
    terminal.out << "reference  " << metres(reference->p_world_load_m) << " in "
                 << to_string(reference->frame) << ", by " << escaped(reference->requester.view()) << "\n";
  }
  return kExitGood;
}

}  // namespace

int run_reference(const Connection& connection, const ReferenceCommand& command, const Terminal& terminal) {
  Talk talk{connection, terminal, command.p_world_load_m.has_value()};
  if (!command.p_world_load_m) return show(talk, connection, command.json, terminal);

  topic::Reference reference;
  reference.frame = command.frame;
  reference.p_world_load_m = *command.p_world_load_m;
  if (command.by) {
    if (!talk.wait(talk.timeout(), [&] { return talk.load().has_value(); })) {
      if (terminal.interrupted) return kExitInterrupted;
      terminal.err << "reference: there is no valid estimate of the load to go from; see motionlab status\n";
      return kExitNobody;
    }
    const Place load = *talk.load();
    for (std::size_t i = 0; i < 3; ++i) reference.p_world_load_m[i] += load[i];
  }
  if (!talk.say(reference)) {
    if (terminal.interrupted) return kExitInterrupted;
    terminal.err << "reference: nobody listens to it; " << nobody_answers(connection, connection.timeout_s)
                 << "\n";
    return kExitNobody;
  }

  const auto mode = talk.mode();
  const bool engaged = mode && mode->state == topic::ModeState::engaged;
  std::string sentence =
      "told: " + metres(reference.p_world_load_m) + " in " + std::string{to_string(reference.frame)};
  if (!engaged) {
    sentence += "; the gateway is " + (mode ? std::string{to_string(mode->state)} : "silent") +
                " and goes there when it is engaged";
  }
  bool there = true;
  if (command.wait_s > 0) {
    Progress progress{terminal, "on the way"};
    const LabTime start = talk.now();
    there = talk.wait(from_seconds(command.wait_s), [&] {
      progress.show(talk.now() - start, from_seconds(command.wait_s));
      const auto load = talk.load();
      return load && distance(*load, reference.p_world_load_m) <= command.within_m;
    });
    progress.clear();
    if (terminal.interrupted) return kExitInterrupted;
    const auto load = talk.load();
    sentence += there ? "; the load is there" : "; the load is not there";
    if (load) sentence += ", " + fixed(1e3 * distance(*load, reference.p_world_load_m), 0) + " mm away";
  }
  if (command.json) {
    nlohmann::ordered_json out;
    out["told"] = topic_json(reference);
    out["engaged"] = engaged;
    out["there"] = command.wait_s > 0 ? nlohmann::ordered_json(there) : nullptr;
    out["sentence"] = sentence;
    terminal.out << json_text(out);
  } else {
    (there ? terminal.out : terminal.err) << sentence << "\n";
  }
  return there ? kExitGood : kExitWrong;
}

}  // namespace motionlab::monitor
