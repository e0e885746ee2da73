/// @file  `Board`: which channels there are now, and what a client that comes late has to be told.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/core/time.hpp"
#include "gateway/bus/topic_list.hpp"
#include "gateway/console/outbox.hpp"

namespace motionlab::console {

/// A channel is its topic's row in `bus::kTopicList`, plus 1; the console's own comes after them.
inline constexpr std::uint32_t kOwnChannel = static_cast<std::uint32_t>(bus::kTopicList.size()) + 1;

/// Channels come when a topic has a writer and go when it has had none for `kGoneAfter`, so that a gateway
/// that is started again finds its listeners still listening. States and events are remembered for who comes
/// late.
class Board {
 public:
  static constexpr Nanoseconds kGoneAfter = 10s;

  /// Which channels are new and which are gone since the last call.
  struct Change {
    std::vector<std::uint32_t> come, gone;
  };
  /// @param written  for each row of the list, whether it has a writer now
  Change look(LabTime now, const std::vector<bool>& written);

  /// Makes a parcel of a sample, and remembers it where a late client has to be told.
  Parcel accept(std::size_t topic, std::string_view instance, LabTime now, Payload payload);

  [[nodiscard]] bool open(std::uint32_t channel) const;
  /// All that are open, the console's own among them.
  [[nodiscard]] std::vector<std::uint32_t> channels() const;
  /// What a new subscriber of the channel gets at once: the newest of every instance of a state, the last
  /// events.
  [[nodiscard]] std::vector<Parcel> remembered(std::uint32_t channel) const;

 private:
  static constexpr std::size_t kSlots =
      128;  ///< instances of one topic that are told apart; strangers may name many
  static constexpr std::size_t kEvents = 100;

  struct Row {
    bool open = false;
    LabTime written{};
    std::map<std::string, std::uint32_t, std::less<>> slots;
    std::map<std::uint32_t, Parcel> newest;
    std::deque<Parcel> last;
  };

  std::vector<Row> rows_{bus::kTopicList.size()};
};

}  // namespace motionlab::console
