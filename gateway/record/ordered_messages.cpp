#include "gateway/record/ordered_messages.hpp"

#include <algorithm>
#include <utility>

namespace motionlab::record {
namespace {

/// However the times lie, no more is held.
constexpr std::size_t kMostWaiting = 1'000'000;

}  // namespace

void OrderedMessages::read_ahead() {
  constexpr auto ahead = static_cast<std::uint64_t>(kAhead.count());
  while (!ended_ && waiting_.size() < kMostWaiting &&
         (waiting_.empty() || newest_ns_ - waiting_.begin()->first < ahead)) {
    const auto item = reader_.next();
    if (!item) {
      fault_ = item.fault();
      ended_ = !reader_.skip();
    } else if (!item->has_value()) {
      ended_ = true;
    } else if (const auto* const message = std::get_if<McapMessage>(&**item)) {
      newest_ns_ = waiting_.empty() ? message->logged_ns : std::max(newest_ns_, message->logged_ns);
      waiting_.emplace(
          message->logged_ns,
          OrderedMessage{message->channel, message->logged_ns, {message->data.begin(), message->data.end()}});
    }
  }
}

std::optional<OrderedMessage> OrderedMessages::next() {
  read_ahead();
  if (waiting_.empty()) return std::nullopt;
  OrderedMessage oldest = std::move(waiting_.begin()->second);
  waiting_.erase(waiting_.begin());
  return oldest;
}

}  // namespace motionlab::record
