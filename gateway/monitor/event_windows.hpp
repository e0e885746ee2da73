/// @file  `EventWindows`: of all that is said, what surrounds certain events.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "drivers/core/bytes.hpp"
#include "drivers/core/time.hpp"
#include "gateway/record/recording.hpp"
#include "idl/event.hpp"

namespace motionlab::monitor {

/// Which events open a window, and how far it reaches.
struct EventWindow {
  /// Each a severity ("info", "warning", "fault": at least so severe) or the code of an event.
  std::vector<std::string> on;
  Nanoseconds before{0}, after{0};

  [[nodiscard]] bool opened_by(const topic::Event& event) const;
};

/// Stands before a recording on occasion: holds the newest `before` of everything, and hands it over, with
/// all that follows for `after`, when an event says so. A further event within a window makes it longer.
///
/// DDS keeps events for those who come late: what was written before `born` opens nothing (by the clock of
/// the writer's host). What is held is bounded; beyond that the oldest is forgotten, and the part's metadata
/// tell from when on it is whole. One thread.
class EventWindows {
 public:
  /// Some two minutes of everything that a laboratory says.
  static constexpr std::size_t kMostHeld = 256 * 1024 * 1024;

  EventWindows(EventWindow window, LabTime born, record::Recording& recording,
               std::size_t most_held = kMostHeld);

  void take(const record::SampleToRecord& sample, Bytes cdr);
  /// Ends a window whose time is over while nothing is said. Call it some times a second.
  void keep_up(LabTime now);

  /// How many were opened so far.
  [[nodiscard]] std::uint64_t count() const noexcept { return count_; }

 private:
  struct Held {
    record::SampleToRecord sample;
    ByteBuffer cdr;
  };

  void open(const topic::Event& event, LabTime heard);
  void close();
  void forget_oldest();

  EventWindow window_;
  LabTime born_;
  record::Recording& recording_;
  std::size_t most_held_;
  std::deque<Held> held_;
  std::size_t held_bytes_ = 0;
  bool open_ = false;
  LabTime closes_{};
  std::uint64_t count_ = 0;
};

}  // namespace motionlab::monitor
