/// @file  The gateway's end of what it shares with its deadman.
#pragma once

#include <sys/types.h>

#include <array>
#include <cstdint>

#include "gateway/deadman/page/page.hpp"

namespace motionlab::deadman {

/// An open file, closed at the end of its life.
class File {
 public:
  explicit File(int fd = -1) noexcept : fd_(fd) {}
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&&) = delete;
  [[nodiscard]] int fd() const noexcept { return fd_; }

 private:
  int fd_;
};

/// Tells the deadman that the gateway lives and what it last sent, and tells the gateway whether the deadman
/// lives.
///
/// `sent` and the beats are wait-free, allocate nothing and enter no kernel but for the time; each belongs to
/// one thread. When the process ends, however it ends, the kernel closes the pipe, which the deadman hears.
class Lifeline {
 public:
  /// @param page     shared, written by both; must outlive this
  /// @param pipe     whose other end the deadman holds; nothing is ever written to it
  /// @param deadman  a pidfd; readable once the deadman is gone
  Lifeline(Page& page, File pipe, File deadman) noexcept;
  /// Nothing was ever sent: the deadman is let go. Else only `end_in_order` lets it go.
  ~Lifeline();
  Lifeline(const Lifeline&) = delete;
  Lifeline& operator=(const Lifeline&) = delete;

  /// A datagram has left for the robot computer, now. The io thread.
  void sent(bool follow, const std::array<double, comau::kJointCount>& qd_radps) noexcept;
  /// The drivers have been stepped. The io thread.
  void io_beat() noexcept;
  /// A control step is done. The control thread.
  void control_beat() noexcept;

  /// The deadman has not looked for `kSilentBeats` beats of the io thread. To be asked by that thread.
  [[nodiscard]] bool deadman_silent() const noexcept { return beats_since_look_ > kSilentBeats; }
  [[nodiscard]] int deadman_pidfd() const noexcept { return deadman_.fd(); }

  /// The gateway ends and could not see arm and winch at rest: once it is gone the deadman tries.
  void leave() noexcept;
  /// Arm and winch are at rest: the deadman ends now, and the gateway need not beat any more.
  void end_in_order() noexcept;

 private:
  /// Of a millisecond each, so about a second in which the gateway itself got its turn.
  static constexpr std::uint64_t kSilentBeats = 1000;

  Page& page_;
  File pipe_;
  File deadman_;
  std::uint64_t ticks_seen_ = 0;
  std::uint64_t beats_since_look_ = 0;
};

}  // namespace motionlab::deadman
