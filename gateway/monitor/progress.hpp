/// @file  A line that tells how far a long work has come; only on a terminal.
#pragma once

#include <string>

#include "drivers/core/time.hpp"
#include "gateway/monitor/session.hpp"

namespace motionlab::monitor {

/// Writes to standard error, in place, at most five times a second, and leaves nothing behind.
class Progress {
 public:
  /// @param what  e.g. "listening to motionlab/mru"; may be of strangers, it is escaped
  Progress(const Terminal& terminal, std::string what);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void show(Nanoseconds done, Nanoseconds all);
  void clear();

 private:
  const Terminal& terminal_;
  std::string what_;
  Nanoseconds next_{0};
  bool shown_ = false;
};

}  // namespace motionlab::monitor
