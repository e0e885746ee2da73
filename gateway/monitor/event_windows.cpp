#include "gateway/monitor/event_windows.hpp"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "gateway/monitor/text.hpp"
#include "gateway/record/cdr.hpp"

namespace motionlab::monitor {
namespace {

/// By the numbers of `topic::Severity`.
constexpr std::array<std::string_view, 3> kSeverities{"info", "warning", "fault"};

/// Of what comes from the bus: it may be any number.
std::string name_of(topic::Severity severity) {
  const auto number = static_cast<std::size_t>(severity);
  return std::string(number < kSeverities.size() ? kSeverities[number] : "unknown");
}

/// What was heard before a window's end may still be on its way through the queue.
constexpr Nanoseconds kOnItsWay = std::chrono::seconds{1};

}  // namespace

bool EventWindow::opened_by(const topic::Event& event) const {
  return std::any_of(on.begin(), on.end(), [&event](const std::string& wanted) {
    const auto severity = std::find(kSeverities.begin(), kSeverities.end(), wanted);
    return severity == kSeverities.end() ? event.code.view() == wanted
                                         : static_cast<int>(event.severity) >= severity - kSeverities.begin();
  });
}

EventWindows::EventWindows(EventWindow window, LabTime born, record::Recording& recording,
                           std::size_t most_held)
    : window_(std::move(window)), born_(born), recording_(recording), most_held_(most_held) {}

void EventWindows::take(const record::SampleToRecord& sample, Bytes cdr) {
  const LabTime heard = from_ns(sample.t_heard_ns);
  if (open_ && heard >= closes_) close();
  while (!held_.empty() && from_ns(held_.front().sample.t_heard_ns) < heard - window_.before) forget_oldest();
  topic::Event event;
  if (sample.topic == bus::topic_index<topic::Event>() && from_ns(sample.t_written_ns) >= born_ &&
      record::read_cdr(cdr, event, record::kDdsPadding) && window_.opened_by(event)) {
    open(event, heard);
  }
  if (open_) {
    recording_.take(sample, cdr);
    return;
  }
  held_.push_back({sample, {cdr.begin(), cdr.end()}});
  held_bytes_ += sizeof(Held) + cdr.size();
  while (held_bytes_ > most_held_) forget_oldest();
}

void EventWindows::open(const topic::Event& event, LabTime heard) {
  closes_ = heard + window_.after;
  if (std::exchange(open_, true)) return;
  ++count_;
  const LabTime whole_from = held_.empty() ? heard : from_ns(held_.front().sample.t_heard_ns);
  recording_.begin(heard, {{"source", event.source.str()},
                           {"code", event.code.str()},
                           {"severity", name_of(event.severity)},
                           {"text", event.text.str()},
                           {"t_heard_ns", std::to_string(to_ns(heard))},
                           {"before_s", fixed(seconds(heard - whole_from), 3)},
                           {"after_s", fixed(seconds(window_.after), 3)}});
  for (const Held& held : held_) recording_.take(held.sample, held.cdr);
  held_.clear();
  held_bytes_ = 0;
}

void EventWindows::keep_up(LabTime now) {
  if (open_ && now >= closes_ + kOnItsWay) close();
}

void EventWindows::close() {
  recording_.end();
  open_ = false;
}

void EventWindows::forget_oldest() {
  const Held& oldest = held_.front();
  recording_.pass(oldest.sample, oldest.cdr);
  held_bytes_ -= sizeof(Held) + oldest.cdr.size();
  held_.pop_front();
}

}  // namespace motionlab::monitor
