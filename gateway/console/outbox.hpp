/// @file  What waits to be sent to one client: bounded, the newest of everything kept, what was left out
/// counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace motionlab::console {

using Payload = std::shared_ptr<const std::vector<std::byte>>;

/// One sample on its way to one client.
struct Parcel {
  std::uint32_t channel = 0;
  std::uint32_t slot =
      0;  ///< which instance of which topic; a newer parcel may stand in for an older one of its slot
  std::int64_t t_ns = 0;      ///< when the console took it
  bool every_counts = false;  ///< an event or a request: left out only when there is no room at all
  Payload payload;
};

/// A queue in order of arrival. Beyond its limit the oldest parcel of the same slot gives way to the new one,
/// so that it holds at most the limit and one parcel of each slot, however long nobody takes from it. The
/// only one of its slot leaves its place in the queue to the newer one: so each slot has its turn, however
/// slowly the client reads.
class Outbox {
 public:
  /// @param newest_only  the client wants the newest of each slot each time it is served, and no more; what
  /// gives way
  ///                     to that is not missed
  Outbox(std::size_t limit_bytes, bool newest_only) : limit_{limit_bytes}, newest_only_{newest_only} {}

  void push(Parcel parcel);
  [[nodiscard]] std::optional<Parcel> pop();
  /// Forgets what waits of a channel that the client no longer wants.
  void forget(std::uint32_t channel);

  [[nodiscard]] bool empty() const noexcept { return parcels_.empty(); }
  [[nodiscard]] std::size_t size() const noexcept { return parcels_.size(); }
  [[nodiscard]] std::size_t bytes() const noexcept { return bytes_; }
  /// Parcels left out so far because the client was slow.
  [[nodiscard]] std::uint64_t missed() const noexcept { return missed_; }
  /// Of each channel, since the last call.
  [[nodiscard]] std::map<std::uint32_t, std::uint64_t> newly_missed();

 private:
  const std::size_t limit_;
  const bool newest_only_;
  std::deque<Parcel> parcels_;
  std::size_t bytes_ = 0;
  std::uint64_t missed_ = 0;
  std::map<std::uint32_t, std::uint64_t> newly_missed_;
};

}  // namespace motionlab::console
