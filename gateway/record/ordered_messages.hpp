/// @file  `OrderedMessages`: a recording in the order of its time.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

#include "drivers/core/bytes.hpp"
#include "drivers/core/time.hpp"
#include "gateway/record/mcap_reader.hpp"

namespace motionlab::record {

struct OrderedMessage {
  const McapChannel* channel = nullptr;
  std::uint64_t logged_ns = 0;
  ByteBuffer data;
};

/// A recorder takes topic by topic, so that the messages of a moment lie in its file in any order. Reads
/// `kAhead` ahead and gives them in the order of the time they were logged, equal ones as they lie. Damaged
/// records are left out.
class OrderedMessages {
 public:
  /// By so much the order in the file may be wrong.
  static constexpr Nanoseconds kAhead = 1s;

  /// @param reader  outlives this
  explicit OrderedMessages(McapReader& reader) : reader_(reader) {}

  /// Nothing at the end.
  [[nodiscard]] std::optional<OrderedMessage> next();
  /// What ended it before the end of the file, or was left out on the way; the last of them.
  [[nodiscard]] const std::optional<Fault>& fault() const noexcept { return fault_; }

 private:
  void read_ahead();

  McapReader& reader_;
  std::multimap<std::uint64_t, OrderedMessage> waiting_;
  std::uint64_t newest_ns_ = 0;
  bool ended_ = false;
  std::optional<Fault> fault_;
};

}  // namespace motionlab::record
