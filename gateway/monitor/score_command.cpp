#include "gateway/monitor/score_command.hpp"

#include <fstream>
#include <ostream>
#include <tuple>

#include "gateway/monitor/scorer.hpp"
#include "gateway/monitor/text.hpp"

namespace motionlab::monitor {
namespace {

/// An estimate alone is taken for a laboratory without truth when it has been there for so long.
constexpr Nanoseconds kGraceForTruth = 2s;
constexpr Nanoseconds kPoll = 20ms;
constexpr Nanoseconds kLinePeriod = 1s;

/// Every topic that the score looks at.
class Inboxes {
 public:
  explicit Inboxes(Session& session) : session_(session) {
    std::apply([&](auto&... inbox) { (open(inbox), ...); }, all_);
  }

  /// Empties all inboxes into the scorers. To be called several times a second, or samples are lost.
  template <class... Scorers>
  void feed(Scorers&... scorers) {
    std::apply([&](auto&... inbox) { (drain(inbox, scorers...), ...); }, all_);
  }

  /// Where the score can come from; nothing as long as that is not known.
  [[nodiscard]] std::optional<Source> source(LabTime now) {
    if (truth_.newest()) return Source::truth;
    const auto estimate = estimate_.newest();
    if (!estimate || !estimate->valid) return std::nullopt;
    if (!estimate_since_) estimate_since_ = now;
    return now - *estimate_since_ >= kGraceForTruth ? std::optional{Source::estimate} : std::nullopt;
  }

  [[nodiscard]] std::optional<topic::Mode> mode() const { return mode_.newest(); }
  [[nodiscard]] std::optional<topic::Control> control() const { return control_.newest(); }
  [[nodiscard]] std::optional<topic::Estimate> estimate() const { return estimate_.newest(); }
  [[nodiscard]] HealthSummary health() const {
    HealthSummary summary;
    session_.local.for_each_newest<topic::Health>(
        [&summary](const topic::Health& health) { summary.add(health); });
    return summary;
  }

 private:
  template <class T>
  using Inbox = std::optional<bus::Subscription<T>>;

  template <class T>
  void open(Inbox<T>& inbox) {
    session_.dds.in<T>();
    inbox.emplace(session_.local.subscribe<T>());
  }

  template <class T, class... Scorers>
  static void drain(Inbox<T>& inbox, Scorers&... scorers) {
    while (const auto sample = inbox->next()) (scorers.take(*sample), ...);
  }

  Session& session_;
  // The source first: it tells the time for the rest.
  std::tuple<Inbox<topic::TruthWorld>, Inbox<topic::Estimate>, Inbox<topic::Mode>, Inbox<topic::Reference>,
             Inbox<topic::Health>, Inbox<topic::Control>, Inbox<topic::ArmState>, Inbox<topic::WinchState>>
      all_;
  bus::Reader<topic::TruthWorld> truth_ = session_.local.reader<topic::TruthWorld>();
  bus::Reader<topic::Estimate> estimate_ = session_.local.reader<topic::Estimate>();
  bus::Reader<topic::Mode> mode_ = session_.local.reader<topic::Mode>();
  bus::Reader<topic::Control> control_ = session_.local.reader<topic::Control>();
  std::optional<LabTime> estimate_since_;
};

/// Feeds both until it is known which of them it will be: the modes and references of this time count
/// already.
std::optional<Source> wait_for_source(Session& session, Inboxes& inboxes, Scorer& by_truth,
                                      Scorer& by_estimate, Nanoseconds timeout,
                                      const std::atomic<bool>& interrupted) {
  const LabTime end = session.clock.now() + timeout + kGraceForTruth;
  while (!interrupted) {
    const LabTime now = session.clock.now();
    inboxes.feed(by_truth, by_estimate);
    if (const auto source = inboxes.source(now)) return source;
    if (now >= end) break;
    session.wakeup->wait(kPoll);
  }
  return std::nullopt;
}

ScorerConfig scorer_config(const ScoreCommand& command, Source source) {
  ScorerConfig config;
  config.labels = command.labels;
  config.source = source;
  config.score_from_s = command.from_s;
  config.score_to_s = command.seconds;
  if (command.start_ns) config.t_start = from_ns(*command.start_ns);
  return config;
}

/// Feeds the scorer until the run is over, with a line a second.
void watch(Session& session, Inboxes& inboxes, bus::Publisher<topic::Score>& scores, Scorer& scorer,
           const ScoreCommand& command, Nanoseconds timeout, const Terminal& terminal) {
  std::ostream& lines = command.json ? terminal.err : terminal.out;
  const Paint paint{terminal.colour};
  const LabTime start = session.clock.now();
  LabTime heard = start;
  std::optional<LabTime> newest;
  LabTime line_due = start + kLinePeriod;
  std::uint64_t sequence_number = 0;
  while (!terminal.interrupted) {
    session.wakeup->wait(kPoll);
    inboxes.feed(scorer);
    const LabTime now = session.clock.now();
    if (scorer.t_newest() != newest) {
      newest = scorer.t_newest();
      heard = now;
    }
    if (now >= line_due) {
      line_due += kLinePeriod;
      LiveFacts facts{.t_s = scorer.elapsed_s(),
                      .score = scorer.live(now),
                      .mode = inboxes.mode(),
                      .control = inboxes.control(),
                      .health = inboxes.health(),
                      .silent_s = seconds(now - heard)};
      facts.score.sequence_number = ++sequence_number;
      scores.publish(facts.score);
      lines << live_line(facts, paint) << std::endl;
    }
    if (!command.seconds) continue;
    if (scorer.elapsed_s() >= *command.seconds) return;
    if (now - start >= from_seconds(*command.seconds) && now - heard >= timeout) return;
  }
}

}  // namespace

int run_score(const Connection& connection, const ScoreCommand& command, const Terminal& terminal) {
  std::ofstream file;
  if (!command.report_path.empty()) {
    file.open(command.report_path);
    if (!file) {
      terminal.err << "cannot write the report to " << command.report_path
                   << ": choose another --report FILE\n";
      return kExitWrong;
    }
  }
  Session session{connection, true};
  Inboxes inboxes{session};
  session.dds.out<topic::Score>();
  auto scores = session.local.advertise<topic::Score>();
  session.dds.start();
  const Nanoseconds timeout = from_seconds(connection.timeout_s);
  Scorer by_truth{scorer_config(command, Source::truth)};
  Scorer by_estimate{scorer_config(command, Source::estimate)};
  const auto source = wait_for_source(session, inboxes, by_truth, by_estimate, timeout, terminal.interrupted);
  if (!source) {
    if (terminal.interrupted) return kExitInterrupted;
    terminal.err << "neither the truth of a simulator nor a valid estimate is there; "
                 << nobody_answers(connection, connection.timeout_s) << "\n";
    return kExitNobody;
  }

  Scorer& scorer = *source == Source::truth ? by_truth : by_estimate;
  watch(session, inboxes, scores, scorer, command, timeout, terminal);
  inboxes.feed(scorer);
  Report report = scorer.report();
  if (const auto estimate = inboxes.estimate(); estimate && report.labels.platform.empty()) {
    report.labels.platform = estimate->platform_tracked ? "tracked" : "untracked";
  }
  if (file.is_open()) {
    file << to_json(report) << std::flush;
    if (!file) {
      terminal.err << "the report could not be written to " << command.report_path << ": is the disk full?\n";
      return kExitWrong;
    }
  }
  terminal.out << (command.json ? to_json(report) : summary(report));
  if (report.motion) return kExitGood;
  terminal.err << "nothing was scored: the window begins at " << fixed(command.from_s, 1)
               << " s (--from), the run was seen until " << fixed(report.duration_s, 1) << " s\n";
  return kExitWrong;
}

}  // namespace motionlab::monitor
