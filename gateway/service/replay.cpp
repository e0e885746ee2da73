#include "gateway/service/replay.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <sstream>
#include <variant>
#include <vector>

#include "drivers/core/error.hpp"
#include "gateway/bus/local_bus.hpp"
#include "gateway/record/field_text.hpp"
#include "gateway/record/mcap_reader.hpp"
#include "gateway/record/run_recorder.hpp"
#include "gateway/record/run_tape.hpp"
#include "gateway/service/control_loop.hpp"
#include "gateway/service/gateway_config.hpp"

namespace motionlab::service {
namespace {

using record::RunKind;

/// One sample of a step's outputs.
struct Output {
  RunKind kind;
  ByteBuffer cdr;
};

/// Runs the control room from what a recording says, one item after another.
class Replay {
 public:
  explicit Replay(const std::filesystem::path& file) : file_(file) {}

  /// @returns whether to go on
  bool take(const record::McapAttachment& attachment) {
    if (attachment.name == record::kRunConfiguration) configuration_ = as_text(attachment.data);
    return true;
  }

  bool take(const record::McapMetadata& metadata) {
    const auto value = [&](const char* key) {
      const auto found = metadata.values.find(key);
      return found == metadata.values.end() ? std::string() : found->second;
    };
    if (metadata.name == record::kGapMetadata) {
      refuse("has a gap: " + value("lost_steps") + " control steps before step " + value("before_step") +
             " found no room while it was written; only a whole recording can be run again");
    }
    if (metadata.name == record::kRunMetadata) {
      outcome_.version = value("version");
      const std::string every = value("outputs_every");
      const auto [end, bad] = std::from_chars(every.data(), every.data() + every.size(), outputs_every_);
      if (bad != std::errc{} || end != every.data() + every.size() || outputs_every_ == 0)
        refuse("does not say of which steps it keeps the outputs");
    }
    return true;
  }

  bool take(const record::McapMessage& message) {
    const auto kind = kind_of(message.channel->topic);
    if (!kind) return true;  // of somebody else
    if (*kind != record::run_kind<topic::Snapshot>()) {
      recorded_.push_back({*kind, {message.data.begin(), message.data.end()}});
      return true;
    }
    if (const Status read = record::read_cdr(message.data, inputs_); !read)
      refuse("is damaged at step " + std::to_string(outcome_.steps + 1) + ": " +
             std::string(read.fault().text));
    // First, because what a missing step published would count as the last one's.
    if (inputs_.sequence_number != outcome_.steps + 1) {
      refuse("has step " + std::to_string(inputs_.sequence_number) + " where step " +
             std::to_string(outcome_.steps + 1) +
             " should be; only a recording from the first step on, without gaps, can be run again");
    }
    return end_step() && begin_step();
  }

  /// @param whole  the recording was finished: its last step is compared, too
  ReplayOutcome finish(bool whole) {
    outcome_.cut_off = !whole && !outcome_.difference;
    if (outcome_.steps == 0) refuse("has no control step; record it with [record] inputs or --record");
    if (whole && !outcome_.difference) (void)end_step();
    if (!outcome_.difference && unequal_) outcome_.difference = unequal_;
    return std::move(outcome_);
  }

  [[noreturn]] void refuse(const std::string& why) const { throw StartupError(file_.string() + ' ' + why); }

 private:
  static std::optional<RunKind> kind_of(std::string_view topic) {
    std::optional<RunKind> found;
    for (RunKind kind = 0; kind < record::kRunKinds; ++kind) {
      record::for_run_type(kind, [&]<class T>() {
        if (topic == record::run_topic<T>()) found = kind;
      });
    }
    return found;
  }

  /// Builds the control room as the configuration in the file says.
  void build() {
    if (configuration_.empty()) refuse("has no configuration; it is not the recording of a run");
    if (outputs_every_ == 0) refuse("does not say of which steps it keeps the outputs");
    const GatewayConfig config = parse_gateway_config({file_.string() + ", gateway.toml", configuration_});
    tape_.emplace(outputs_every_, kTape);
    loop_.emplace(config, local_, schedule_, std::function<std::int64_t()>(), std::function<std::int64_t()>(),
                  &*tape_);
  }

  bool begin_step() {
    if (!loop_) build();
    if (inputs_.outputs_crc != (outcome_.steps == 0 ? 0 : tape_->outputs_crc()) && !unequal_) {
      unequal_ = Difference{outcome_.steps,
                            stepped_,
                            {},
                            {},
                            std::to_string(inputs_.outputs_crc),
                            std::to_string(tape_->outputs_crc()),
                            outcome_.steps};
    }
    loop_->step(inputs_);
    ++outcome_.steps;
    stepped_ = from_ns(inputs_.t_ns);
    return true;
  }

  /// Compares what the last step published with what was recorded of it.
  bool end_step() {
    if (outcome_.steps == 0) return true;
    replayed_.clear();
    if (!tape_->ring().pop(step_)) refuse("has a step that is too large to be run again");
    (void)record::for_each_sample(step_, [this](RunKind kind, Bytes cdr) {
      if (kind != record::run_kind<topic::Snapshot>()) replayed_.push_back({kind, {cdr.begin(), cdr.end()}});
    });
    const std::size_t both = std::min(recorded_.size(), replayed_.size());
    for (std::size_t i = 0; i < both && !outcome_.difference; ++i) compare(recorded_[i], replayed_[i]);
    if (!outcome_.difference && recorded_.size() != replayed_.size()) {
      const bool missing = recorded_.size() > replayed_.size();
      differ(missing ? recorded_[both].kind : replayed_[both].kind, "",
             missing ? "published" : "not published", missing ? "not published" : "published");
    }
    recorded_.clear();
    return !outcome_.difference;
  }

  void compare(const Output& recorded, const Output& replayed) {
    ++outcome_.outputs_compared;
    if (recorded.kind != replayed.kind) {
      differ(recorded.kind, "", "published", "not published");
    } else if (recorded.cdr != replayed.cdr) {
      record::for_run_type(recorded.kind, [&]<class T>() { compare<T>(recorded, replayed); });
    }
  }

  /// Of two samples with different bytes: they may differ in what a stopwatch measured.
  template <class T>
  void compare(const Output& recorded, const Output& replayed) {
    T was{}, is{};
    if (!record::read_cdr(recorded.cdr, was) || !record::read_cdr(replayed.cdr, is))
      refuse("is damaged at step " + std::to_string(outcome_.steps));
    record::without_stopwatch(was);
    record::without_stopwatch(is);
    const auto before = record::field_texts(was), after = record::field_texts(is);
    const auto [a, b] = std::mismatch(before.begin(), before.end(), after.begin(), after.end());
    if (a != before.end()) differ(recorded.kind, a->first, a->second, b->second);
  }

  void differ(RunKind kind, std::string field, std::string recorded, std::string replayed) {
    std::string topic;
    record::for_run_type(kind, [&]<class T>() { topic = record::run_topic<T>(); });
    outcome_.difference = Difference{outcome_.steps,
                                     stepped_,
                                     std::move(topic),
                                     std::move(field),
                                     std::move(recorded),
                                     std::move(replayed),
                                     unequal_ ? unequal_->step : outcome_.steps};
  }

  static constexpr std::size_t kTape = 4 * record::RunTape::kLargestStep;

  std::filesystem::path file_;
  std::string configuration_;
  std::uint32_t outputs_every_ = 0;
  bus::LocalBus local_;
  ArmSchedule schedule_;
  std::optional<record::RunTape> tape_;
  std::optional<ControlLoop> loop_;
  topic::Snapshot inputs_;
  LabTime stepped_{};
  ByteBuffer step_;
  std::vector<Output> recorded_, replayed_;
  std::optional<Difference> unequal_;  ///< the first that the checksum tells
  ReplayOutcome outcome_;
};

}  // namespace

ReplayOutcome replay(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw StartupError(file.string() + " cannot be read; check the path");
  record::McapReader reader(in);
  Replay replay(file);
  for (;;) {
    const auto item = reader.next();
    if (!item) {
      replay.refuse("cannot be read beyond byte " + std::to_string(reader.position()) + ": " +
                    std::string(item.fault().text));
    }
    if (!item->has_value()) break;
    if (!std::visit([&](const auto& found) { return replay.take(found); }, **item)) break;
  }
  return replay.finish(reader.complete());
}

std::string describe(const ReplayOutcome& outcome) {
  std::ostringstream text;
  text << outcome.steps << " steps";
  if (outcome.cut_off) text << ", up to where the recording was cut off";
  if (!outcome.difference) {
    text << ": equal to the bit (checksum of every step, " << outcome.outputs_compared << " samples)";
    return text.str();
  }
  const Difference& d = *outcome.difference;
  text << ": differs from step " << d.since_step;
  if (d.topic.empty()) {
    text << " on by its checksum; no sample of it was kept";
  } else {
    if (d.since_step != d.step) text << " on by its checksum; first sample kept";
    text << " at step " << d.step << ", t = " << to_ns(d.t) << " ns: " << d.topic << ' ' << d.field << " was "
         << d.recorded << ", is " << d.replayed;
  }
  return text.str();
}

}  // namespace motionlab::service
