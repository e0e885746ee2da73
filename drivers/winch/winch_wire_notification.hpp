/// @file  The notification stream: samples grouped by stamp, several of each in one frame.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "drivers/core/bytes.hpp"
#include "drivers/core/result.hpp"

namespace motionlab::winch {

/// One value of one subscription.
struct NotificationSample {
  std::uint32_t handle = 0;
  Bytes data{};  ///< empty: the server's hint that the handle has become void
};

/// Samples taken at the same moment of the PLC's clock.
struct NotificationStamp {
  std::uint64_t filetime = 0;
  std::span<const NotificationSample> samples{};
};

/// The data of a DeviceNotification, for the server.
struct NotificationStream {
  std::span<const NotificationStamp> stamps{};

  void encode(LittleWriter& writer) const noexcept;
};

/// Walks through the samples of a DeviceNotification, oldest first.
class NotificationReader {
 public:
  struct Item {
    std::uint64_t filetime = 0;
    NotificationSample sample{};
  };

  /// Checks the whole stream before the first sample is given out, so that a malformed frame has no effect at
  /// all. Faults: too_short, too_long, bad_header (the stream's own length does not fit the frame).
  [[nodiscard]] static Result<NotificationReader> open(Bytes data) noexcept;

  /// The next sample, or nothing after the last.
  [[nodiscard]] std::optional<Item> next() noexcept;
  [[nodiscard]] bool ok() const noexcept { return reader_.ok(); }

 private:
  explicit NotificationReader(Bytes data) noexcept;

  LittleReader reader_;
  std::uint32_t stamps_left_ = 0;
  std::uint32_t samples_left_ = 0;
  std::uint64_t filetime_ = 0;
};

}  // namespace motionlab::winch
